"""``tt.sweep``: a sweep from one call, as a table."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tt_precise.scene.scene import Scene
from tt_precise.sweeps import run, spot_check
from tt_precise.sweeps.specification import specification

if TYPE_CHECKING:
    import pandas

Number = str | int | float


def sweep(
    scene: str | Scene,
    *,
    vary: Mapping[str, str | Iterable[Number]] | None = None,
    box: Mapping[str, str | tuple[Number, Number]] | None = None,
    samples: int = 0,
    record: Iterable[str] = (),
    until: str | int | None = None,
    out: str | Path | None = None,
    workers: int = 1,
    recheck: int = spot_check.ONE_IN,
    **others: Any,
) -> pandas.DataFrame:
    """Integrate ``scene`` from many starts; a row of the result is a start.

    Parameters
    ----------
    scene
        A shipped name, a path to a TOML file, or a scene.
    vary
        A grid: by name of a start value (rad, rad/s, m/s) or parameter (SI; I1 and I3 in units of
        m R^2) the values it takes, as numbers or as text: "0.1,0.2", or "-200:200:801" for 801
        values, ends included.
    box, samples
        So many samples of a box: by name the range, as two numbers or as "low:high".
    record
        Further columns; see ``tt_precise.sweeps.columns``.
    until
        Horizon in s, instead of the scene's.
    out
        A folder or URL for the rows; what is there already is not computed again.
    workers
        Processes; more than one need the usual ``if __name__ == "__main__"`` in a script.
    recheck
        One row in so many is integrated again in double-double; 0: none.
    others
        ``sampler``, ``seed``, ``contact`` as for a ``Specification``.

    Returns
    -------
    pandas.DataFrame
        ``index``, what was varied, ``outcome``, and the columns of ``sweep.columns``, in SI;
        ``attrs["summary"]`` says what was found, what is missing, and how it ran.

    Raises
    ------
    InputError
        Something of this cannot be used.
    """
    spec = specification(
        scene, vary=vary, box=box, until=until, samples=samples, record=tuple(record), **others
    )
    swept = run.sweep(spec, out=out, workers=workers, one_in=recheck)
    rows = swept.rows
    rows.attrs["summary"] = dict(swept.summary)
    return rows
