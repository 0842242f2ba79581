"""Exactness: mpmath determinations, SymPy proofs, and Jellett's integral of printed states.

``thresholds`` evaluates lambda, the thresholds and the asymptotic values to any number of digits,
each beside an independent determination; ``identities`` proves that the equations of
``tt_precise.mechanics`` say what the paper claims of them; ``jellett`` recomputes lambda from
the decimal strings of a trajectory.
"""
