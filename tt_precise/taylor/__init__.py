"""A Taylor integrator for any system of equations, in double-double or triple-double.

``graph`` traces functions that are generic in their arithmetic, ``kernel`` turns the trace into
instructions (``emit``), ``machine`` compiles the instructions, ``system`` makes the steps;
``series`` and ``interpolation`` serve any program. The package contains no physics and shares no
code with heyoka.
"""
