"""Tests of physics engines.

An engine is a program: one job as JSON on standard input, rows as CSV on standard output
(``protocol``, ``PROTOCOL.md``). ``ladder`` has the tests with their references, measures order and
floor, and derives the verdicts; ``results`` writes them. Programs for ten engines lie in
``examples/engines`` of the repository, their scoreboard in ``benchmarks/engines.py``.
"""
