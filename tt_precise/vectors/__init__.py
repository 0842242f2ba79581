"""Test vectors for other languages, at three depths: forces, one step, whole trajectories.

``states`` draws the states of depth 1 and computes every term of the equations; ``steps`` advances
them by 0.1, 1 and 10 ms; ``index`` lists every file of the reference data.
"""
