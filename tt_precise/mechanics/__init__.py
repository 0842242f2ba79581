"""The physics of the Tippe Top, written once, generic in the arithmetic.

Functions take ``Parameters``, a state whose entries are scalars of one arithmetic, and, if they
need elementary functions, a module ``fn`` with these (numpy, an mpmath context, heyoka, sympy).
Units are SI or any other consistent set; frames and names are the paper's.
"""
