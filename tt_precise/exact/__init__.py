"""Exactness: mpmath determinations, SymPy proofs, and Jellett's integral of printed states.

``thresholds`` evaluates lambda, the thresholds and the asymptotic values to any number of digits,
each in two independent ways; ``identities`` proves statements of the paper about the equations of
``tt_precise.mechanics``; ``jellett`` recomputes lambda from the decimal strings of a trajectory.
"""
