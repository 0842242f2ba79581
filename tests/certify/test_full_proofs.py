"""The long proofs: `make proofs`. Bars in units of what issue and README promise."""

import resource
import shutil
from pathlib import Path

import flint
import pytest

import tt_precise as tt
from tt_precise.certify import Proof, prove
from tt_precise.certify.golden_proof import certify
from tt_precise.golden import proofs, store

pytestmark = pytest.mark.proofs

MOST_MEMORY_KIB = 2 * 1024**2


@pytest.fixture(scope="module")
def proof() -> Proof:
    made = prove("reference")
    assert len(list(made.rows())) == 801
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < MOST_MEMORY_KIB
    return made


def test_initiation_and_ending_times_to_25_digits(proof: Proof) -> None:
    found = tt.integrate("reference", precision="quad").inversion
    with flint.ctx.workprec(300):
        for definition in "ABC":
            exact, other = getattr(proof.inversion, definition), getattr(found, definition)
            for name in ("t_init", "t_end"):
                ball = getattr(exact, name)
                assert ball.rad() < flint.arb("1e-26")
                assert abs(ball - flint.arb(str(getattr(other, name)))) < flint.arb("1e-26")


def test_another_precision_and_other_steps_agree(proof: Proof) -> None:
    other = prove("reference", bits=170)
    with flint.ctx.workprec(300):
        for seconds in proof.scene.sample_times[::20]:
            a, b = proof.state(seconds), other.state(seconds)
            assert all(a[name].overlaps(b[name]) for name in a)  # type: ignore[union-attr]


@pytest.mark.parametrize("name", [name for name in store.scenes() if proofs.read(name)])
def test_committed_proofs_come_out_again(name: str, tmp_path: Path) -> None:
    shutil.copytree(store.home() / name, tmp_path / name)
    certificate = certify(name, folder=tmp_path)
    assert certificate.complete, certificate.summary
    for file in (proofs.ENCLOSURE, proofs.EVENTS_ENCLOSURE):
        assert (tmp_path / name / file).read_bytes() == (store.home() / name / file).read_bytes()
    made, committed = (proofs.read(name, place) for place in (tmp_path, store.home()))
    assert made is not None
    assert committed is not None
    # sources and libraries may be others
    for key in made.content.keys() - {"prover", "versions", store.PROOF_HASH}:
        assert made.content[key] == committed.content[key], key
