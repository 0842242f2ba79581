"""Column sets: one motion in each of them, the rigid body's way to vectors, and its height."""

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, Healthy, check
from tt_precise.check.columns import (
    COLUMN_SETS,
    Block,
    CheckSetup,
    choose_set,
    renamed,
    renaming,
)
from tt_precise.scene.scene import load_scene

# Causes are tested elsewhere.
pytestmark = pytest.mark.usefixtures("no_cause")


def test_a_rigid_body_is_checked_like_its_vectors(healthy: Healthy, rigid_body: Healthy) -> None:
    frame = rigid_body(healthy())
    result = check(frame, "reference", limits={"jellett": 1e-13})
    assert result.passed, str(result)
    assert result.columns == "rigid body"
    for name in ("contact_velocity", "quaternion_norm", "equations"):
        assert result[name].verdict == "pass"
    assert result["axis_norm"].verdict == "skipped"
    # as vectors
    assert set(result["golden"].parts) == set(VECTORS[1:])
    assert (result["golden"].value or 0) > 8
    # off the table, and with a drifting quaternion
    lifted = frame.assign(vcz=frame["vcz"] + numpy.where(frame["t"] > 6, 1e-4, 0))
    assert check(lifted, "reference")["contact_velocity"].verdict == "fail"
    longer = frame.assign(qw=frame["qw"] * 1.00001)
    assert check(longer, "reference")["quaternion_norm"].verdict == "fail"
    resting = check(frame.drop(columns=["vcx", "vcy", "vcz"]), "reference")
    assert resting["jellett"].verdict == "pass"
    assert resting["energy"].note == "needs the velocity: columns vcx, vcy, vcz"


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ("time kx", "f.csv: no column t .* rename yours with --columns"),
        ("t kx ky Lx Ly Lz", "f.csv: missing kz of the vectors columns"),
        ("t a", "f.csv: no column set among the columns t, a"),
    ],
)
def test_what_is_missing_is_named(columns: str, message: str) -> None:
    with pytest.raises(tt.InputError, match=message):
        choose_set(columns.split(), "f.csv")


def test_renames(healthy: Healthy) -> None:
    theirs = healthy()[EULER[:5]].rename(columns={"t": "time", "omega_3": "spin"})
    result = check(theirs, "reference", columns={"time": "t", "spin": "omega_3"})
    assert result.columns == "Euler"
    assert renaming(["time=t, spin=omega_3"]) == {"time": "t", "spin": "omega_3"}
    for wrong, message in (
        (lambda: renaming(["time"]), "got 'time', expected theirs=ours"),
        (
            lambda: renaming(["w=omega3"]),
            "got 'omega3', expected one of ours: .* did you mean 'omega_3'",
        ),
        (lambda: renamed(["t"], {"spin": "omega_3"}, "f.csv"), "no column 'spin' to rename"),
        (lambda: renamed(["t", "time"], {"time": "t"}, "f.csv"), "column t occurs twice"),
    ):
        with pytest.raises(tt.InputError, match=message):
            wrong()


# What contact_velocity says where the contact point leaves the table.


@pytest.fixture
def body(healthy: Healthy, rigid_body: Healthy) -> Healthy:
    return lambda *size: rigid_body(healthy("reference", *size))


def contact_velocity(frame: pandas.DataFrame, scene: str | tt.Scene = "reference") -> str:
    found = check(frame, scene, friction="other")["contact_velocity"]
    assert (found.note == "") == (found.verdict == "pass")
    return found.note


def test_a_soft_contact_is_recognised_and_the_limit_that_is_named_is_enough(
    body: Healthy,
) -> None:
    assert contact_velocity(body()) == ""
    soft = body(801, 1)
    # sinks and rises by 20 um, 30 times a second
    soft["vcz"] += 1e-5 * 190 * numpy.cos(190 * soft["t"])
    said = contact_velocity(soft)
    assert said.startswith("it sinks and rises by 2e-05 m, as a soft contact does")
    limit = float(said.rpartition(": ")[2].rstrip("}"))
    assert limit < 1e-2
    found = check(soft, "reference", friction="other", limits={"contact_velocity": limit})
    assert found["contact_velocity"].verdict == "pass"


def test_another_arm_is_recognised(body: Healthy) -> None:
    """The rows have alpha R = 6 mm; 1 per cent is too little for the guard of units."""
    assert contact_velocity(body(), tt.load_scene("reference").varied(alpha="0.303")) == (
        "its height follows the axis: alpha R = 0.006 m would keep it on the table, the scene "
        "has 0.00606 m"
    )


def test_a_top_that_flies_is_no_soft_contact(body: Healthy) -> None:
    flying = body(801, 1)
    flying["vcz"] += 0.1 * flying["t"]  # 5 cm high in the end
    assert check(flying, "reference", friction="other")["contact_velocity"].note == ""


def test_the_precision_of_columns_goes_with_what_is_made_of_them() -> None:
    """Their sums, and multiples of these, have no decimals."""
    rng = numpy.random.default_rng(1)
    names = COLUMN_SETS["rigid body"].names
    block = Block({"t": numpy.arange(20.0), **{n: rng.normal(size=20).round(3) for n in names}})
    sums = block.converted(lambda c: {"wx": (c["wx"] + c["wy"]) / numpy.sqrt(2)})
    threefold = sums.converted(lambda c: {"wx": 3 * c["wx"]})
    setup = CheckSetup(load_scene("reference"), COLUMN_SETS["rigid body"], False)
    for rows in (setup.samples(threefold), setup.samples(threefold).rows(slice(9))):
        assert rows.resolution["wx"] == pytest.approx(3 * numpy.sqrt(2) * 5e-4)
        assert rows.precisions["wx"].words == "3 decimals"
