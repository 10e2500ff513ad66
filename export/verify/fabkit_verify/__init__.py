"""Rebuilds what fabkit exports in kernels that fabkit did not write, and compares.

Lengths are in millimetres, angles in radians, frames right-handed. Nothing here imports fabkit: the
only things known about a body are its tree document (the exact primitives) and its samples document
(what fabkit believes about the solid that they make).
"""

__version__ = "0.1.0"
