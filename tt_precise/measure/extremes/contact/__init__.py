"""The normal force and its denominator at zero."""
