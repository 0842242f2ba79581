"""A Taylor integrator of its own: any system of equations, traced once, stepped in double-double.

``graph`` traces functions that are generic in their arithmetic, ``kernel`` turns what was traced
into instructions (``emit``), ``machine`` compiles these, ``system`` steps, ``crossings`` finds
zeros of traced functions along the way. It knows no physics, and shares no code with heyoka.
"""
