"""The paper's claims, one function each, and their verdicts."""
