"""Names for the faces of a rebuilt solid: the feature that each belongs to.

Booleans split and merge faces, so a rebuilt solid has lost the names of its features. But the samples
list where lines cross the exact surface, and on which primitive of the tree; the face at that point
belongs to that primitive.
"""

from __future__ import annotations

import numpy

from .kernels.occt import Probe

# Largest distance of a face from a sampled crossing, mm; OpenCascade's faces are within 1e-7.
THERE_MM = 1e-6


def face_names(tree: dict, samples: dict, probe: Probe) -> list[str]:
    """Finds the feature's name for each of the probe's faces; empty if none or several are found.

    A face that no line crosses gets no name: lines are aimed at each face of the tree, and a boolean may
    have split it into several.
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
