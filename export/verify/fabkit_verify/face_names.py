"""Which feature each face of a rebuilt solid belongs to.

A rebuilt solid has lost its features' names: booleans split and merge faces. But the samples say where
lines cross the exact surface, and at which primitive of the tree; so whichever face is there is that
primitive's.
"""

from __future__ import annotations

import numpy

from .kernels.occt import Probe

# How close a face must be to where the samples have one, mm; OpenCascade's faces are within 1e-7.
THERE_MM = 1e-6


def face_names(tree: dict, samples: dict, probe: Probe) -> list[str]:
    """For each of the probe's faces the feature's name; empty where none or more than one is found.

    A face that no line meets stays without: lines are aimed at each face of the tree, and a boolean
    may have left more than one piece of it.
    """
    features = [leaf["feature"] for leaf in tree["leaves"]]
    found: list[set[str]] = [set() for _ in probe.faces]
    for line in samples["lines"]:
        names = [features[leaf] for leaf in line["leaf"]]
        if not any(names):
            continue
        origin, direction = numpy.array(line["origin_mm"]), numpy.array(line["direction"])
        exact = numpy.array(line["t_mm"])
        for face, hits in probe.faces_met(origin, direction):
            for hit in hits:
                nearest = int(numpy.abs(exact - hit).argmin())
                if abs(exact[nearest] - hit) < THERE_MM:
                    found[face].add(names[nearest])
    return [next(iter(names)) if len(names) == 1 else "" for names in found]
