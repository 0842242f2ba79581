"""Friction, shape, scale and spin at their edges."""
