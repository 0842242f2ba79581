"""Starts at and beside the poles, passages of the pole, and the two forms of the state there."""
