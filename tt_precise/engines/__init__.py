"""Tests of physics engines.

An engine is a program: one job as JSON on standard input, rows as CSV on standard output
(``protocol``, ``PROTOCOL.md``; ``adapters`` for engines with a Python interface). ``ladder`` has
the tests with their references, measures order and floor, and derives the verdicts; ``scoreboard``
lists the engines with adapters and their results.
"""
