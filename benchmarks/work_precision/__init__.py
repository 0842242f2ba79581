"""Speed against accuracy of integrators: ``python -m benchmarks.work_precision`` (half an hour).

Writes ``tradeoff.csv`` and ``tradeoff-growth.csv`` into ``reports/measured``, and their findings
with figures as ``tradeoff.json`` and SVG, which the report shows. Other people's integrators come
with the extra ``peers``; one that is not installed is skipped with a line.
"""
