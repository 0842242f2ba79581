"""Proofs of digits: enclosures of exact solutions in ball arithmetic, rounding included.

One small program is trusted. It verifies at run time everything on which it depends:

- ``problem``: an exact initial value problem, that of a scene, and signs at t = 0, where many
  functions vanish.
- ``kernel``: the theorem with its proof, and the verification of its hypotheses, step by step.
- ``motion``: phases, samples and zeros in a step; a step that cannot be verified is shortened.
- ``compare``: golden tables against the enclosure, cell by cell.
- ``well``: a second theorem, on all later times, and what it says of the end of any trajectory.

``propose`` guesses polynomials, weights, bases and lengths of steps, and is not trusted. The
arithmetics are in ``balls`` and ``models``. ``statements`` derives the statements about a scene;
``files`` writes them to the folder of the golden tables, or proves them again.

    >>> import dataclasses
    >>> import tt_precise as tt
    >>> from tt_precise.certify import prove
    >>> proof = prove(dataclasses.replace(tt.load_scene("reference"), until="0.02"))
    >>> proof.state("0.02")["theta"].str(30)
    '[0.0974468621270673365519920016122 +/- 2.95e-32]'

A program that decides alone needs controls: ``tests/certify`` drops each hypothesis in turn, and a
closed form reveals the error.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
