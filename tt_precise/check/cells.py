"""Numbers out of cells: what is missing becomes NaN, what is no real number is refused."""

from __future__ import annotations

import datetime
import math
from typing import Any

import numpy

from tt_precise.runtime.arithmetic import Array
from tt_precise.runtime.errors import InputError

SHOWN = 40  # characters of a bad cell
INFINITIES = ("inf", "infinity")
MISSING = ("", "nan", "na", "n/a", "null", "none", "<na>")
DATES = (datetime.date, datetime.time, datetime.timedelta, numpy.datetime64, numpy.timedelta64)


def number(value: Any, *, strict: bool) -> float:
    """The number in a cell (text, or a number of any kind); NaN where there is none.

    Text that is no number is NaN, too, unless ``strict``.

    Raises
    ------
    ValueError
        With what was expected: it is no real number within the range of a double.
    """
    if value is None or type(value).__name__ == "NAType":
        return math.nan
    if isinstance(value, DATES) or type(value).__name__ == "NaTType":
        raise ValueError("seconds as a number, such as (t - t[0]) / numpy.timedelta64(1, 's')")
    if isinstance(value, str):
        return _number_of_text(value.strip(), strict)
    if isinstance(value, complex | numpy.complexfloating):
        raise ValueError("a real number")
    try:
        return float(value)
    except OverflowError:
        raise ValueError("a number within the range of a double") from None
    except (TypeError, ValueError):
        if strict:
            raise ValueError("a number") from None
        return math.nan


def _number_of_text(text: str, strict: bool) -> float:
    if text.lower() in MISSING:
        return math.nan
    try:
        if "_" in text or not text.isascii():  # float reads the digits of every script
            raise ValueError
        found = float(text)
    except ValueError:
        if strict or _is_complex(text):
            raise ValueError("a real number" if _is_complex(text) else "a number") from None
        return math.nan
    if math.isinf(found) and text.lstrip("+-").lower() not in INFINITIES:
        raise ValueError("a number within the range of a double")
    return found


def _is_complex(text: str) -> bool:
    try:
        complex(text)
    except ValueError:
        return False
    return text[-1:] in "jJ)"


def column_of(values: Any, name: str, where: str) -> Array:
    """``values`` as an array with one entry a row.

    Raises
    ------
    InputError
        It has another shape, or a mask, or holds dates or complex numbers.
    """
    # naming numpy.ma would import it
    if type(values).__name__ == "MaskedArray" and numpy.any(values.mask):
        raise InputError(f"{where}: column {name}: got masked entries, expected numbers")
    try:
        array = numpy.asarray(values)
    except (TypeError, ValueError) as error:
        raise InputError(f"{where}: column {name}: {_line(error)}, expected numbers") from None
    if array.ndim != 1:
        raise InputError(
            f"{where}: column {name}: got an array of shape {array.shape}, expected one number "
            "for each row"
        )
    if array.dtype.kind in "mM":
        raise InputError(
            f"{where}: column {name}: got {array.dtype}, expected seconds as a number, such as "
            f"({name} - {name}[0]) / numpy.timedelta64(1, 's')"
        )
    if array.dtype.kind in "cb":
        got = "complex numbers" if array.dtype.kind == "c" else "truth values"
        raise InputError(f"{where}: column {name}: got {got}, expected real numbers")
    return array


def numbers_of(
    array: Array, name: str, where: str, first: int = 0, *, strict: bool = True
) -> numpy.ndarray:
    """The numbers in an array of ``column_of``, NaN where there are none; row ``first`` onwards.

    Raises
    ------
    InputError
        An entry is no real number; the line says in which row.
    """
    if array.dtype.kind in "fiu":
        with numpy.errstate(over="ignore"):
            rounded = numpy.asarray(array, dtype=float)
        if array.dtype.itemsize <= 8 or not numpy.any(numpy.isinf(rounded) & ~numpy.isinf(array)):
            return rounded
    found = numpy.empty(len(array))
    for row, value in enumerate(array):
        try:
            found[row] = number(value, strict=strict)
        except ValueError as error:
            raise InputError(bad_cell(f"{where}: row {first + row}", name, value, error)) from None
    return found


def bad_cell(place: str, name: str, value: object, error: ValueError) -> str:
    """The line that refuses a cell."""
    # Python does not print integers of more than some thousand digits
    huge = isinstance(value, int) and value.bit_length() > 1000
    shown = "an integer of that size" if huge else repr(str(value)[:SHOWN])
    return f"{place}, column {name}: got {shown}, expected {error}"


def _line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0][:120]
