"""Light through a sensor's bodies, followed by NumPy from what `fabkit export --format light` says.

An oracle: it reads that document, knows the model that docs/light.md describes, and shares nothing with
fabkit's own tracer. Solids are asked where straight lines cross them; where a formula offers several
places, points between them decide.
"""
