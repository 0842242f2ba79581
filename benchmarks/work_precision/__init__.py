"""Speed against accuracy of integrators: ``python -m benchmarks.work_precision`` (half an hour).

Writes ``tradeoff.csv`` and ``tradeoff-growth.csv`` into ``reports/measured``, from which the report
computes its findings (``tt_precise.tradeoff.findings``). Other people's integrators come with the
extra ``peers``; one that is not installed is skipped with a line.
"""
