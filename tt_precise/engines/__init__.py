"""Other people's physics engines on a ladder of tests.

An engine is a program: one job as JSON on standard input, rows as CSV on standard output
(``protocol``, ``PROTOCOL.md``; ``adapters`` for engines with a Python interface). ``ladder`` has
the tests with their references, measures order and floor and says what follows from them;
``scoreboard`` lists the engines that adapters exist for, and what was measured of them.
"""
