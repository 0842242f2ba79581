"""Measurements: speed against accuracy, overheads, stability at the extremes."""
