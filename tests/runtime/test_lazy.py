"""Names that are imported when they are first used."""

import subprocess
import sys

import pytest

PACKAGES = ("tt_precise", "tt_precise.check", "tt_precise.claims", "tt_precise.golden",
            "tt_precise.certify")  # fmt: skip
LISTED = """
import importlib, sys
package = importlib.import_module(sys.argv[1])
before = set(sys.modules)
assert set(package.__all__) <= set(dir(package))
assert set(sys.modules) == before, set(sys.modules) - before
for name in package.__all__:
    assert getattr(package, name) is not None
assert not hasattr(package, "_private")
try: package.nothing
except AttributeError as error: assert f"{sys.argv[1]!r} has no attribute 'nothing'" in str(error)
"""


@pytest.mark.parametrize("package", PACKAGES)
def test_all_names_are_listed_and_there(package: str) -> None:
    if package == "tt_precise.certify":
        pytest.importorskip("flint", reason="needs the extra certify")
    subprocess.run([sys.executable, "-c", LISTED, package], check=True)
