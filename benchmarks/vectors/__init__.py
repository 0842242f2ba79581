"""Test vectors for other languages: ``python -m benchmarks.vectors`` makes them.

``states`` draws states and computes every term of the equations; ``steps`` advances them by 0.1, 1
and 10 ms. The files lie in ``reference_data/vectors``; with ``--check`` they are compared with what
is computed now.
"""
