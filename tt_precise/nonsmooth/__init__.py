"""Motions whose equations change: stick and slip, gliding from rest, flight, elastic tables.

``backend`` is registered for scenes in pieces. The first of them that is integrated imports it.
"""
