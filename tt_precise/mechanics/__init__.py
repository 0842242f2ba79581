"""The physics of the Tippe Top, written once, generic in the arithmetic.

Every function takes ``Parameters`` and a state whose entries are scalars of one arithmetic, and
where it needs elementary functions, the module ``fn`` that has them (numpy, an mpmath context,
heyoka, sympy). Units are SI or any other consistent set; frames and names are the paper's.
"""
