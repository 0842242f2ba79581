"""The paper's section 2.2: its start values one at a time and in a box, for the claims about them.

Every sweep varies the reference scene. Rows that lose contact are integrated twice: "unilateral",
where the trajectory ends when g_n reaches 0, and "bilateral", where it goes on with g_n < 0, as
the paper's own equations do. Conclusions can so be drawn with and without them.

The rows are kept in ``reports/`` of the checkout, in a file that names the definition it was made
from; elsewhere, or after a change of the definition, they are computed anew (a minute or two).
"""

from __future__ import annotations

import fcntl
import gzip
import hashlib
import io
import json
import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tt_precise.files import atomic_write
from tt_precise.mechanics.quantities import jellett
from tt_precise.scene import Inclination, Scene, load_scene
from tt_precise.sweep.crew import Failure, crew_of, performed
from tt_precise.sweep.specification import STARTS, Plan, blocks, specification

if TYPE_CHECKING:
    import pandas

UNTIL = "12"  # s; the paper's figures end at 8, which some starts need longer than
RANGES = {"theta_dot": "-15:15", "nu_x": "-0.3:0.3", "nu_y": "-0.8:0.8"}  # rad/s, m/s; section 2.2
TENTH = {"theta_dot": "-1.5:1.5", "nu_x": "-0.03:0.03", "nu_y": "-0.08:0.08"}
RECORD = (
    "climb_A", "climb_B", "climb_C", "t_equator", "nu_crossing_init", "nu_crossing_end",
    "min_nu_x", "max_nu_x", "min_nu_y", "max_nu_y", "min_theta_dot", "max_theta_dot",
    "end_theta", "start_E", "lambda_ratio",
)  # fmt: skip
TASK_ROWS = 128
DIGITS = 12  # significant, in the file
FILE = "sweeps-section-2.2.csv.gz"
VERSION = 1  # of everything above that the fingerprint does not see


@dataclass(frozen=True)
class Series:
    """One of the section's sweeps: its name, what it varies, and the sentence it is about."""

    name: str
    vary: dict[str, str]
    box: dict[str, str]
    samples: int
    about: str
    keep_lambda: bool = False  # omega_3 such that lambda stays the reference's


def _grid(name: str, about: str, keep_lambda: bool = False, **vary: str) -> Series:
    return Series(name, vary, {}, 0, about, keep_lambda)


SERIES = (
    _grid("phi_dot", "phi_dot(0) in [-200, 200]", phi_dot="-200:200:801"),
    _grid("phi_dot near the peak", "where t_init is largest", phi_dot="-5:5:401"),
    _grid("phi_dot near the end", "where t_init reaches zero", phi_dot="80:86:241"),
    _grid("phi_dot, smooth", "[195, 200]", phi_dot="195:200:51", theta="0.1,0.01"),
    _grid("theta", "other inclinations", theta="0.01:1:199"),
    _grid("theta at lambda", "the same at fixed lambda", keep_lambda=True, theta="0.01:1:199"),
    _grid("theta_dot", "theta_dot(0) alone", theta_dot="-15:15:301"),
    _grid("nu_x", "nu_x(0) alone", nu_x="-0.3:0.3:301"),
    _grid("nu_y", "nu_y(0) alone", nu_y="-0.8:0.8:321"),
    Series(
        "box", {}, {"phi_dot": "-200:200", **RANGES}, 2048,
        "phi_dot(0), theta_dot(0), nu_x(0), nu_y(0) at random",
    ),
    Series("tenth", {}, TENTH, 512, "perturbations of at most 10 % of the ranges"),
)  # fmt: skip


@cache
def rows() -> pandas.DataFrame:
    """All rows: ``series``, ``contact``, the six start values, and the columns of a sweep.

    Each start has a row with ``contact`` "unilateral", and one with "bilateral" if it loses
    contact. Read from the file if that is up to date, else computed on all cores and kept.
    """
    for folder in _folders():
        found = _read(folder / FILE)
        if found is not None:
            return found
    with _alone():
        for folder in _folders():  # somebody else may have made it meanwhile
            found = _read(folder / FILE)
            if found is not None:
                return found
        content = packed(compute())
        for folder in _folders():
            if folder.is_dir() and os.access(folder, os.W_OK):
                atomic_write(folder / FILE, content)
                break
    # from the bytes, so that nobody sees other digits than the next one who reads the file
    table = _unpacked(content)
    assert table is not None
    return table


def series(name: str, *, contact: str = "held") -> pandas.DataFrame:
    """The rows of one series.

    ``contact`` "held": only those that keep contact (conclusions without the others);
    "through": all starts, those that lose contact integrated on with g_n < 0 as in the paper;
    "unilateral": all starts, ended where contact is lost.
    """
    table = rows()
    mine = table[table["series"] == name]
    if not len(mine):
        raise ValueError(f"series: got {name!r}, expected one of {[one.name for one in SERIES]}")
    if contact == "unilateral":
        return mine[mine["contact"] == "unilateral"].reset_index(drop=True)
    held = (mine["contact"] == "unilateral") & (mine["outcome"] != "contact_lost")
    chosen = mine[held if contact == "held" else held | (mine["contact"] == "bilateral")]
    return chosen.sort_values("index", kind="stable").reset_index(drop=True)


def compute(workers: int | None = None, progress: Callable[[float], None] | None = None) -> Any:
    """Integrate everything; the table that ``rows`` gives."""
    import pandas

    crew = crew_of(workers or len(os.sched_getaffinity(0)))
    try:
        first = _integrated(crew, list(_starts()), "unilateral", progress)
        lost = first[first["outcome"] == "contact_lost"]
        again = [
            (str(name), some["index"].to_numpy(), some[list(STARTS)].to_numpy())
            for name, some in lost.groupby("series", sort=False)
        ]
        second = _integrated(crew, again, "bilateral", progress)
    finally:
        crew.leave()
    order = {one.name: position for position, one in enumerate(SERIES)}
    table = pandas.concat([first, second], ignore_index=True)
    table["order"] = table["series"].map(order)
    table["later"] = table["contact"] == "bilateral"
    table = table.sort_values(["order", "index", "later"]).drop(columns=["order", "later"])
    return table.reset_index(drop=True)


def packed(table: pandas.DataFrame) -> bytes:
    """The file of the rows, with their fingerprint; the same rows give the same bytes."""
    text = table.to_csv(index=False, float_format=f"%.{DIGITS}g", lineterminator="\n")
    sink = io.BytesIO()
    # no time and no name in the header, which would change with every run
    with gzip.GzipFile(filename="", mode="wb", fileobj=sink, mtime=0) as file:
        file.write(f"# {fingerprint()}\n{text}".encode())
    return sink.getvalue()


@cache
def fingerprint() -> str:
    """SHA-256 of what the rows are made from: scene, series, columns."""
    scene = _scene()
    told = {
        "version": VERSION,
        "body": repr(scene.body),
        "start": repr(scene.start),
        "until": UNTIL,
        "series": [repr(one) for one in SERIES],
        "record": RECORD,
    }
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode("utf-8")).hexdigest()


def _scene() -> Scene:
    return replace(load_scene("reference"), until=Fraction(UNTIL))


def _starts() -> Iterator[tuple[str, Any, Any]]:
    """(series, index, start values of shape (rows, six)) of every series."""
    import numpy

    scene = _scene()
    reference = [float(getattr(scene.start, name)) for name in STARTS if name != "theta"]
    reference.insert(STARTS.index("theta"), scene.start.theta.radians(math, float))
    for one in SERIES:
        spec = specification(scene, vary=one.vary, box=one.box, samples=one.samples, seed=22)
        values = numpy.concatenate([block for _, block in blocks(spec, 4096, set())])
        table = numpy.tile(reference, (len(values), 1))
        for position, name in enumerate(spec.names):
            table[:, STARTS.index(name)] = values[:, position]
        if one.keep_lambda:
            table[:, STARTS.index("omega_3")] = _spins(scene, table[:, STARTS.index("theta")])
        yield one.name, numpy.arange(len(table)), table


def _spins(scene: Scene, thetas: Any) -> Any:
    """omega_3(0) with which each inclination has the reference's lambda, the rest at rest."""
    import numpy

    from tt_precise.integrate.precision import precision_named
    from tt_precise.integrate.start import beginning
    from tt_precise.mechanics.quantities import Motion

    def lambda_of(theta: float) -> float:
        # lambda is linear in omega_3, with no other rate
        start = replace(scene.start, theta=Inclination(Fraction(theta)), omega_3=Fraction(1))
        begun = beginning(replace(scene, start=start), precision_named("double"))
        return float(jellett(Motion(begun.body, begun.vectors, precision_named("double").context)))

    spin = float(scene.start.omega_3)
    own = lambda_of(scene.start.theta.radians(math, float))
    return numpy.array([spin * own / lambda_of(theta) for theta in thetas.tolist()])


def _integrated(
    crew: Any,
    starts: list[tuple[str, Any, Any]],
    contact: str,
    progress: Callable[[float], None] | None,
) -> pandas.DataFrame:
    import heyoka
    import pandas

    from tt_precise import __version__
    from tt_precise.sweep.run import chunk_task

    plan = Plan(_scene(), STARTS, RECORD, contact)
    pieces = [
        (name, index[first : first + TASK_ROWS], values[first : first + TASK_ROWS])
        for name, index, values in starts
        for first in range(0, len(index), TASK_ROWS)
    ]
    lanes = heyoka.recommended_simd_size()
    tasks = (
        (number, (plan, __version__, number, piece[2], lanes))
        for number, piece in enumerate(pieces)
    )
    frames = {}
    for done, (number, _, result) in enumerate(performed(crew, chunk_task, tasks), start=1):
        if isinstance(result, Failure):
            raise RuntimeError(f"section 2.2: {result.error}")
        name, index, values = pieces[number]
        columns = {"series": name, "contact": contact, "index": index}
        columns |= {start: values[:, position] for position, start in enumerate(STARTS)}
        frames[number] = pandas.DataFrame({**columns, **result["columns"]})
        if progress:
            progress(done / len(pieces))
    return pandas.concat([frames[number] for number in sorted(frames)], ignore_index=True)


def _folders() -> tuple[Path, ...]:
    """Where the file may be: the checkout's reports, then the user's cache."""
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    checkout = Path(__file__).parents[2]
    known = [checkout / "reports"] if (checkout / "pyproject.toml").is_file() else []
    return (*known, home / "tt-precise")


def _read(path: Path) -> pandas.DataFrame | None:
    """The rows in a file, unless it was made from another definition."""
    return _unpacked(path.read_bytes()) if path.is_file() else None


def _unpacked(content: bytes) -> pandas.DataFrame | None:
    import pandas

    text = gzip.decompress(content).decode("utf-8")
    if not text.startswith(f"# {fingerprint()}\n"):
        return None
    return pandas.read_csv(io.StringIO(text), comment="#")


@contextmanager
def _alone() -> Iterator[None]:
    """Keep other processes waiting, so that not each of them computes the same."""
    folder = _folders()[-1]
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / f"{FILE}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
