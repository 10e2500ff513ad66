"""Independent ray tracer in NumPy for a sensor's bodies, as `fabkit export --format light` describes them.

It implements the model of docs/light.md and shares nothing with fabkit's own tracer. Each solid computes the
candidate crossings of straight lines with its faces; points between neighbouring candidates decide which stretches
are inside.
"""
