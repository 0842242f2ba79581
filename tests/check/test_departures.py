"""Columns that leave the solution alone are named, since when and how; a wrong motion is not."""

from collections.abc import Callable

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, Healthy, check
from tests.conftest import more

Spoil = Callable[[pandas.DataFrame], pandas.DataFrame]
REST = "; every other column is right to 1"  # 11 or 12 digits


def times(factor: float, *names: str, since: float = 0.0) -> Spoil:
    def spoil(frame: pandas.DataFrame) -> pandas.DataFrame:
        late = frame["t"] >= since
        return frame.assign(**{n: frame[n].where(~late, factor * frame[n]) for n in names})

    return spoil


def holding(**sources: str) -> Spoil:
    """Columns that hold others."""
    return lambda frame: frame.assign(
        **{n: -frame[s[1:]] if s[0] == "-" else frame[s] for n, s in sources.items()}
    )


def above(offset: float, name: str, since: float) -> Spoil:
    return lambda frame: frame.assign(**{name: frame[name] + offset * (frame["t"] >= since)})


def late(*names: str) -> Spoil:
    return lambda frame: frame.assign(**{n: frame[n].shift(1).fillna(frame[n]) for n in names})


def both(*spoils: Spoil) -> Spoil:
    def spoil(frame: pandas.DataFrame) -> pandas.DataFrame:
        for one in spoils:
            frame = one(frame)
        return frame

    return spoil


def noisy(frame: pandas.DataFrame) -> pandas.DataFrame:
    return frame.assign(vx=frame["vx"] * (1 + 1e-2 * numpy.sin(37.0 * frame.index)))


SPOILT: dict[str, Spoil] = {
    "from t = 1.01 s on Lz is 1.000010 times the solution's": times(1.00001, "Lz", since=1.005),
    "from t = 1.01 s on Lz is 1.000010 times the solution's; from t = 0.5 s on vx is 1.0010 times "
    "the solution's": both(times(1.00001, "Lz", since=1.005), times(1.001, "vx", since=0.495)),
    "Lx, Ly, Lz are 1.00010 times the solution's": times(1.0001, "Lx", "Ly", "Lz"),
    "vx, vy are 1.010 times the solution's": times(1.01, "vx", "vy"),
    "kx is 1.0010 times the solution's": times(1.001, "kx"),
    "from t = 1 s on kx is 0.0001 above the solution's": above(1e-4, "kx", 0.995),
    "in the row at t = 1 s (number 101) alone Lz is 1.0010 times the solution's": both(
        times(1.001, "Lz", since=0.995), times(1 / 1.001, "Lz", since=1.005)
    ),
    "kz has the other sign": times(-1, "kz"),
    "Lz has the other sign": times(-1, "Lz"),
    "vx, vy have the other sign": times(-1, "vx", "vy"),
    "Lx, Ly, Lz have the other sign": times(-1, "Lx", "Ly", "Lz"),
    "kx, Ly, Lz, vx have the other sign": times(-1, "kx", "Ly", "Lz", "vx"),
    "vx, vy are the solution's vy, vx": holding(vx="vy", vy="vx"),
    "kx, ky are the solution's ky, kx": holding(kx="ky", ky="kx"),
    "Lx, Ly are the solution's Ly, Lx": holding(Lx="Ly", Ly="Lx"),
    "kx, ky, kz, Lx, Ly, Lz are the solution's ky, kz, kx, Ly, Lz, Lx": holding(
        kx="ky", ky="kz", kz="kx", Lx="Ly", Ly="Lz", Lz="Lx"
    ),
    "ky, kz, Ly, Lz are the solution's kz, -ky, Lz, -Ly": holding(
        ky="kz", kz="-ky", Ly="Lz", Lz="-Ly"
    ),
    "vx, vy are the solution's of the row before": late("vx", "vy"),
    "Lz is the solution's of the row before": late("Lz"),
    "vx is wrong": noisy,
    "nu_x, nu_y are the solution's nu_y, nu_x": holding(nu_x="nu_y", nu_y="nu_x"),
    "from t = 1.01 s on omega_3 is 1.0010 times the solution's": times(
        1.001, "omega_3", since=1.005
    ),
    "from t = 1 s on theta is 0.0001 above the solution's": above(1e-4, "theta", 0.995),
}


# Of factors, signs and exchanged columns some are in the default run.
ALIKE = (
    "kz has the other sign", "Lz has the other sign", "Lx, Ly, Lz have the other sign",
    "kx, ky are the solution's ky, kx", "Lx, Ly are the solution's Ly, Lx",
    "vx, vy have the other sign", "Lx, Ly, Lz are 1.00010 times the solution's",
    "ky, kz, Ly, Lz are the solution's kz, -ky, Lz, -Ly",
)  # fmt: skip


@pytest.mark.parametrize("text", [more(one) if one in ALIKE else one for one in SPOILT])
def test_wrong_columns_are_named(healthy: Healthy, text: str) -> None:
    euler = any(name in text for name in ("nu_", "omega_3", "theta"))
    frame = SPOILT[text](healthy("reference", 201, 2)[EULER if euler else VECTORS])
    for friction in ("scene", "other"):
        found = check(frame, "reference", friction=friction)
        assert not found.passed
        (cause,) = found.causes
        assert cause.kind == "columns"
        assert cause.text.startswith(text + REST)


def test_columns_beside_the_state_and_of_rigid_bodies_are_named(
    healthy: Healthy, rigid_body: Healthy
) -> None:
    frame = healthy("reference", 201, 2)
    beside = frame.assign(theta=numpy.random.default_rng(1).random(201))
    (cause,) = check(beside, "reference").causes
    assert cause.text.startswith("theta is wrong" + REST)
    body = times(1.001, "wz", since=1.005)(rigid_body(frame))
    (cause,) = check(body, "reference").causes
    assert cause.text.startswith("from t = 1.01 s on wz is 1.0010 times the solution's" + REST)


@pytest.mark.parametrize(
    "changed",
    [
        {"mu": "0.300003"},
        more({"I3": "0.40004"}),
        {"omega_3": "155.0155"},
        {"theta": "0.1001"},
        more({"g": "9.83"}),
    ],
)
def test_of_a_motion_that_is_wrong_as_a_whole_no_column_is_named(changed: dict[str, str]) -> None:
    other = tt.integrate(tt.load_scene("reference").varied(**changed, until="2"))
    found = check(other.frame(*VECTORS[1:]), "reference")
    assert not found.passed
    assert "columns" not in {cause.kind for cause in found.causes}


@pytest.mark.parametrize("further", [0.0, more(1e-5)])
def test_a_column_is_named_only_if_all_else_passes(healthy: Healthy, further: float) -> None:
    """Lz 5 % off, alone or beside columns that fail by little."""
    rows = healthy("reference", 401, 4)[VECTORS]
    bent = 1 + further * numpy.sin(40 * rows["t"])
    others = {name: bent * rows[name] for name in VECTORS[1:]}
    found = check(rows.assign(**(others | {"Lz": 1.05 * others["Lz"]})), "reference")
    assert [one.kind for one in found.causes].count("columns") == (further == 0)
