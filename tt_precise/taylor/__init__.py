"""A Taylor integrator of its own: any system of equations, in two or three doubles.

``graph`` traces functions that are generic in their arithmetic, ``kernel`` turns what was traced,
once, into instructions (``emit``), ``machine`` compiles these, ``system`` steps, ``crossings``
finds zeros of traced functions along the way. It knows no physics, and shares no code with heyoka.
"""
