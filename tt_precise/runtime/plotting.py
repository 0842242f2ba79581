"""The style of all pictures, and one function to save them: equal pictures make equal files.

Colours are Okabe and Ito's, which everybody can distinguish. Letters are stored as outlines, so
that a picture looks the same with any fonts.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from tt_precise.runtime.files import replacing
from tt_precise.runtime.values import Array, InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BLUE, ORANGE, GREEN, RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
SKY, PURPLE, BLACK, GREY = "#56B4E9", "#CC79A7", "#000000", "#767676"
CYCLE = (BLUE, ORANGE, GREEN, RED, SKY, PURPLE, BLACK, GREY)
# The names of columns and parameters as the paper prints them.
SYMBOLS = {
    "theta": r"$\theta$", "theta_dot": r"$\dot\theta$", "phi_dot": r"$\dot\varphi$",
    "psi_dot": r"$\dot\psi$", "omega_3": r"$\omega_3$", "nu_x": r"$\nu_x$", "nu_y": r"$\nu_y$",
    "g_n": "$g_n$", "E": "$E$", "E_rot": "$E_{rot}$", "E_trans": "$E_{trans}$",
    "E_pot": "$E_{pot}$", "E_tilde": r"$\tilde E$", "lambda": r"$\lambda$",
    "mu": r"$\mu$", "alpha": r"$\alpha$",
    "I1": "$I_1$", "I3": "$I_3$", "m": "$m$", "R": "$R$", "g": "$g$",
    "t_init": r"$t_{\theta\approx0}$", "t_end": r"$t_{\theta\approx\pi}$", "climb": "$T_{inv}$",
    "lambda_ratio": r"$\lambda/\lambda_{thres}$", "t_equator": r"$t_{\theta=\pi/2}$",
    "t_stop": "end of the row", "jellett_drift": r"drift of $\lambda$",
}  # fmt: skip
DPI = 150  # Pixels in an inch of a PNG.
BINS = 700  # Intervals of time across a panel; each keeps first, least, greatest, last value.
STYLE = Path(__file__).parent / "templates" / "pictures.mplstyle"
# Metadata by suffix: neither time nor version, so that a file changes only with its picture
FORMATS: dict[str, dict[str, None]] = {
    ".svg": {"Date": None, "Creator": None},
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


@contextmanager
def styled() -> Iterator[None]:
    """A context with the common style."""
    import logging

    import matplotlib
    from cycler import cycler

    # Its warning of a cache that cannot be written is no part of a command's one line.
    logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)
    with matplotlib.rc_context({"axes.prop_cycle": cycler(color=CYCLE)}, STYLE):
        yield


def new_figure(width: float, height: float) -> Figure:
    """An empty figure, in inches, with a layout that makes room for labels; needs no display.

    A notebook shows it when it is the last value of a cell; there is no window.
    """
    from matplotlib.figure import Figure

    drawn: Any = Figure(figsize=(width, height), layout="constrained")
    # matplotlib registers its own figures only where pyplot is in use
    drawn._repr_svg_ = lambda: svg_text(drawn)
    return drawn


def thinned(times: Array, values: Array, bins: int = BINS) -> Array:
    """Indices of the first, least, greatest and last value in each of ``bins`` spans of time."""
    import numpy

    if len(times) <= 4 * bins:
        return numpy.arange(len(times))
    places = (times - times[0]) / (times[-1] - times[0])
    # a time on the edge of a span belongs to the later one, however its last bits are rounded
    spans = numpy.minimum((bins * places + 1e-9).astype(int), bins - 1)
    edges = numpy.flatnonzero(numpy.diff(spans, prepend=-1, append=bins)).tolist()
    chosen = {0, len(times) - 1}
    for begin, end in pairwise(edges):
        piece = values[begin:end]
        chosen |= {begin, begin + int(piece.argmin()), begin + int(piece.argmax()), end - 1}
    return numpy.array(sorted(chosen))


def require_format(path: str | Path) -> str:
    """Return the suffix of a picture's file, before anything has been computed.

    Raises ``InputError``: neither .svg nor .png nor .pdf.
    """
    ending = Path(path).suffix.lower()
    if ending not in FORMATS:
        raise InputError(f"picture: got {path}, expected a name that ends in {', '.join(FORMATS)}")
    return ending


def save(figure: Figure, path: str | Path) -> None:
    """Write a picture in the format of the suffix of ``path``.

    Raises ``InputError``: another ending than ``FORMATS``, or the place cannot be written.
    """
    ending = require_format(path)
    with styled(), replacing(path) as temporary:
        if ending == ".svg":
            temporary.write_text(svg_text(figure), "utf-8")
        else:
            figure.savefig(temporary, format=ending[1:], metadata=FORMATS[ending], dpi=DPI)


def svg_text(figure: Figure, letters: Literal["path", "none"] = "path") -> str:
    """A picture as SVG text; its letters as outlines, or with "none" as text."""
    import matplotlib

    sink = io.StringIO()
    with styled(), matplotlib.rc_context({"svg.fonttype": letters}):
        figure.savefig(sink, format="svg", metadata=FORMATS[".svg"])
    # matplotlib makes ids of clip paths and markers from numbers whose last bits may change
    ids = re.finditer(r'\bid="([A-Za-z_]*?)([0-9a-f]{10})"', sink.getvalue())
    numbers = {match[2]: str(number) for number, match in enumerate(ids, 1)}
    hashes = re.compile("|".join(numbers) or "(?!)")  # which matches nothing
    return hashes.sub(lambda match: numbers[match[0]], sink.getvalue())
