"""What the claims rest on, computed once a process: runs, proofs, sweeps, formulas as text."""
