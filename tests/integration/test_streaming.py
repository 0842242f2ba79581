"""Samples by blocks: the same numbers as a trajectory's, and no more memory for more of them."""

import subprocess
import sys

import numpy
import pandas
import pytest

from tt_precise.claims.evidence.run import variant
from tt_precise.integration import integrate
from tt_precise.integration.streaming import Stream
from tt_precise.runtime.values import InputError

EPS = 2.0**-52

MEMORY = """
import resource, sys
from tt_precise.claims.evidence.run import variant
from tt_precise.integration.streaming import Stream
def peak(every):
    for frame in Stream(variant("frictionless", until="10", sample_every=every), "lambda"):
        pass
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
peak("1e-3")
few = peak("1e-4")
print(few, peak("1e-5"))
"""


@pytest.mark.parametrize("scene", ["reference", "rolling", "upright"])
@pytest.mark.parametrize("block", [1, 100, 100_000])
def test_streams_what_a_trajectory_has(scene: str, block: int) -> None:
    short = variant(scene, until="0.5")
    stream = Stream(short, "kx", "Lz", "omega_3", block=block)
    found = pandas.concat(list(stream), ignore_index=True)
    expected = integrate(short).frame("kx", "Lz", "omega_3")
    assert stream.status == "complete"
    assert list(found["t"]) == list(expected["t"])
    for name in expected.columns[1:]:
        # blocks cut steps short: another rounding of each, and 50 steps
        bound = 100 * EPS * max(1e-6, expected[name].abs().max())
        assert (found[name] - expected[name]).abs().max() <= bound


def test_late_times_are_not_rounded() -> None:
    """At 1000 s the last bit of a dimensionless time is 4e-12: 3e-10 rad of rotation."""
    scene = variant("inverted", theta="pi - 1e-9", until="1000", sample_every="100")
    found = pandas.concat(list(Stream(scene, "kx", "ky")))
    end = integrate(scene).state
    last = found.iloc[-1]
    assert (
        numpy.hypot(last["kx"] - end.kx, last["ky"] - end.ky)
        < 1e-11 * numpy.hypot(end.kx, end.ky) + 1e-25
    )


def test_ends_where_the_model_ends() -> None:
    stream = Stream("contact-lost", "theta")
    found = pandas.concat(list(stream))
    assert stream.status == "contact_lost"
    end = float(integrate("contact-lost").t_end)
    assert found["t"].iloc[-1] < end < found["t"].iloc[-1] + 0.01


def test_unknown_columns_are_refused_at_once() -> None:
    with pytest.raises(InputError, match="expected one of"):
        Stream("reference", "thetta")


def test_memory_does_not_grow_with_the_samples() -> None:
    """A million samples take no more than 100,000: 8 MB would be one column of them."""
    measured = subprocess.run(
        [sys.executable, "-c", MEMORY], capture_output=True, text=True, check=True
    )
    few, many = map(int, measured.stdout.split())
    assert many - few < 4_000  # kB
