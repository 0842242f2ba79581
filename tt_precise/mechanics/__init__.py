"""The physics of the Tippe Top, written once, generic in the arithmetic.

Functions take ``Parameters``, a state whose components are scalars of one arithmetic, and, if
needed, a module ``fn`` with elementary functions (numpy, an mpmath context, heyoka, sympy).
Units are SI or any other consistent set; frames and names are the paper's.
"""
