"""Evidence for the claims, computed once per process: runs, proofs, sweeps, formulas as text."""
