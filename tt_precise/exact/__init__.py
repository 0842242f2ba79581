"""Exact results: determinations in mpmath to any number of digits, and proofs in SymPy.

``thresholds`` evaluates lambda, the thresholds and the asymptotic values, each in two independent
ways; ``stability`` finds the spin at which a steady motion changes its stability, and has mpmath
contexts; ``identities`` proves statements of the paper about the equations of
``tt_precise.mechanics``; ``chart`` has the symbolic coordinates of these proofs.
"""
