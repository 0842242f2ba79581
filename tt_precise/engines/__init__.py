"""Other people's physics engines on a ladder of tests.

An engine is a program: one job (``job``) as JSON on standard input, rows as CSV on standard output
(``PROTOCOL.md``). ``catalogue`` lists the engines that adapters exist for, ``rungs`` the tests with
their reference, ``ladder`` measures order and floor and says what follows from them.
"""
