"""Verification of fabkit's exports: rebuilds each solid in independent CAD kernels and compares.

Lengths are in millimetres, angles in radians, frames right-handed. Nothing here imports fabkit: a
body is known only by its tree document (exact primitives and booleans) and its samples document
(the properties that fabkit computed for the resulting solid).
"""

__version__ = "0.1.0"
