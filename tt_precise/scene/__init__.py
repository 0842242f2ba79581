"""A top, its start and its run, as exact numbers, and the scenes that ship."""
