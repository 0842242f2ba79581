"""Sweeps into an object store, here a server of its protocol on this machine."""

import socket
from collections.abc import Iterator
from typing import Any

import pandas
import pytest

from tt_precise.sweeps import read_rows, specification, sweep

pytestmark = pytest.mark.slow

BUCKET = "s3://bucket"
SPEC = specification("reference", until="0.05", vary={"phi_dot": "-20:20:12"})


@pytest.fixture(scope="module")
def store() -> Iterator[Any]:
    """A file system of fsspec on an empty bucket; workers find it by the environment."""
    why = "needs s3fs and moto[server], which no extra has"
    s3fs = pytest.importorskip("s3fs", reason=why)
    server = pytest.importorskip("moto.server", reason=why)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    running = server.ThreadedMotoServer(ip_address="127.0.0.1", port=port, verbose=False)
    running.start()
    with pytest.MonkeyPatch.context() as patch:
        for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
            patch.setenv(name, "anything")
        patch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{port}")
        files = s3fs.S3FileSystem()
        files.mkdir("bucket")
        yield files
    running.stop()


def test_the_rows_are_those_of_a_sweep_in_memory(store: Any) -> None:
    out = f"{BUCKET}/one/sweep"
    found = sweep(SPEC, out=out, chunk=4, one_in=5, workers=2).summary
    assert (found["out"], found["rows"]) == (out, 12)
    chunks = store.ls("bucket/one/sweep/chunks")
    assert len(chunks) == 3
    rows = read_rows(out)
    pandas.testing.assert_frame_equal(rows, sweep(SPEC, one_in=0).rows, check_exact=True)
    again = sweep(SPEC, out=out, one_in=5).summary
    assert (again["how"]["rows_computed"], again["recheck"]) == (0, found["recheck"])


@pytest.mark.parametrize("damage", ["flipped", "gone"])
def test_what_is_damaged_is_computed_again(store: Any, damage: str) -> None:
    out = f"{BUCKET}/{damage}"
    sweep(SPEC, out=out, chunk=4, one_in=0, workers=1)
    rows, place = read_rows(out), f"bucket/{damage}/chunks/00000001.parquet"
    content = bytearray(store.cat_file(place))
    content[60] ^= 1  # in the first column; the middle may be a statistic
    if damage == "gone":
        store.rm(place)
    else:
        store.pipe_file(place, bytes(content))
    again = sweep(SPEC, out=out, one_in=0).summary
    assert (again["how"]["rows_computed"], again["rows"]) == (4, 12)
    pandas.testing.assert_frame_equal(read_rows(out), rows, check_exact=True)
