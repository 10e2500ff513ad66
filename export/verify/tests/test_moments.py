"""Centroid and inertia of OpenCascade's shapes agree with closed forms within the stated errors."""

from __future__ import annotations

import math
import unittest

import numpy

from fabkit_verify.kernels import occt
from fabkit_verify.kernels.occt_moments import moments
from fabkit_verify.kernels.with_cadquery import Cadquery

# Relative tolerance: OpenCascade intersects faces to 1e-7 mm, and the solids here measure some millimetres.
OPEN_CASCADE = 1e-8
# A rotation oblique to all axes.
ROTATION = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]]
SHIFT = [7.0, -3.0, 2.0]


def ball(radius: float) -> tuple[float, list[float]]:
    """Returns volume and principal moments of a ball."""
    volume = 4.0 / 3.0 * math.pi * radius**3
    return volume, [0.4 * volume * radius**2] * 3


class ClosedForms(unittest.TestCase):
    def assert_moments(self, shape, volume, centroid, inertia):
        """Checks the moments in the shape's own frame, and after a rotation and translation."""
        pose = {"rotation": ROTATION, "translation_mm": SHIFT}
        turn = numpy.array(ROTATION)
        cases = [
            (shape, numpy.array(centroid), numpy.diag(inertia)),
            (
                Cadquery().placed(shape, pose),
                turn @ centroid + SHIFT,
                turn @ numpy.diag(inertia) @ turn.T,
            ),
        ]
        for solid, centre, matrix in cases:
            found = moments(solid.wrapped, occt.bounds(solid.wrapped))
            size = volume ** (1.0 / 3.0)
            self.assertAlmostEqual(found.volume_mm3 / volume, 1.0, delta=OPEN_CASCADE)
            allowed = found.centroid_error_mm + OPEN_CASCADE * size
            self.assertLessEqual(numpy.linalg.norm(found.centroid_mm - centre), allowed)
            allowed = found.inertia_error_mm5 + OPEN_CASCADE * max(inertia)
            self.assertLessEqual(numpy.abs(found.inertia_mm5 - matrix).max(), allowed)
            # Stated errors must be small, or the comparison would prove nothing.
            self.assertLess(found.centroid_error_mm, 1e-8 * size)
            self.assertLess(found.inertia_error_mm5, 1e-7 * max(inertia))

    def test_a_cuboid(self):
        a, b, c = 2.0, 3.0, 5.0
        inertia = [30 / 12 * (b**2 + c**2), 30 / 12 * (a**2 + c**2), 30 / 12 * (a**2 + b**2)]
        self.assert_moments(Cadquery().cuboid([a, b, c]), 30.0, [0, 0, c / 2], inertia)

    def test_a_cone(self):
        radius, height = 3.0, 4.0
        volume = math.pi * radius**2 * height / 3
        across = 3 / 80 * volume * (4 * radius**2 + height**2)
        inertia = [across, across, 0.3 * volume * radius**2]
        shape = Cadquery().cone(radius, 0.0, height)
        self.assert_moments(shape, volume, [0, 0, height / 4], inertia)

    def test_a_torus(self):
        ring, tube = 4.0, 1.5
        volume = 2 * math.pi**2 * ring * tube**2
        across = volume * (ring**2 / 2 + 5 / 8 * tube**2)
        inertia = [across, across, volume * (ring**2 + 3 / 4 * tube**2)]
        self.assert_moments(Cadquery().torus(ring, tube), volume, [0, 0, 0], inertia)

    def test_an_ellipsoid_of_revolution(self):
        a, c = 5.0, 3.0
        volume = 4 / 3 * math.pi * a * a * c
        inertia = [volume / 5 * (a**2 + c**2)] * 2 + [volume / 5 * 2 * a**2]
        self.assert_moments(Cadquery().ellipsoid([a, a, c]), volume, [0, 0, 0], inertia)

    def test_an_ellipsoid_with_three_axes(self):
        # A rational spline: not a surface of revolution, and with breaks.
        a, b, c = 5.0, 4.0, 3.0
        volume = 4 / 3 * math.pi * a * b * c
        inertia = [volume / 5 * s for s in (b**2 + c**2, a**2 + c**2, a**2 + b**2)]
        self.assert_moments(Cadquery().ellipsoid([a, b, c]), volume, [0, 0, 0], inertia)

    def test_a_ball_with_a_hole_through_its_poles_and_one_across(self):
        # The napkin ring: the volume of a ball around a bore depends only on the bore's half height.
        radius, bore = 5.0, 3.0
        half = math.sqrt(radius**2 - bore**2)
        volume = 4 / 3 * math.pi * half**3
        # Shells of radius r, height 2 sqrt(R^2 - r^2): integrals over s = R^2 - r^2 from 0 to half^2.
        axial = 2 * math.pi * (2 / 3 * radius**2 * half**3 - 2 / 5 * half**5)
        second_z = 2 * math.pi / 3 * half**5 * 2 / 5
        inertia = [axial / 2 + second_z, axial / 2 + second_z, axial]
        kernel = Cadquery()
        drill = kernel.cylinder(bore, 20.0)
        for rotation, order in (
            ([[1, 0, 0], [0, 1, 0], [0, 0, 1]], [0, 1, 2]),
            ([[0, 0, 1], [0, 1, 0], [-1, 0, 0]], [2, 1, 0]),
        ):
            start = [-10.0 * row[2] for row in rotation]
            tool = kernel.placed(drill, {"rotation": rotation, "translation_mm": start})
            shape = kernel.difference(kernel.sphere(radius), [tool])
            self.assert_moments(shape, volume, [0, 0, 0], [inertia[i] for i in order])

    def test_half_a_ball_whose_edge_passes_the_pole_closely(self):
        # Close to the pole, u changes fast along the edge.
        radius, tilt = 5.0, math.radians(1.0)
        volume, inertia = ball(radius)
        sin, cos = math.sin(tilt), math.cos(tilt)
        # The plane through the centre whose normal is z turned by 89 degrees about y.
        rotation = [[sin, 0, cos], [0, 1, 0], [-cos, 0, sin]]
        kernel = Cadquery()
        half_space = kernel.placed(
            kernel.half_space(20.0), {"rotation": rotation, "translation_mm": [0, 0, 0]}
        )
        shape = kernel.intersection([kernel.sphere(radius), half_space])
        found = moments(shape.wrapped, occt.bounds(shape.wrapped))
        down = -3 / 8 * radius * numpy.array([cos, 0, sin])
        self.assertAlmostEqual(found.volume_mm3 / (volume / 2), 1.0, delta=OPEN_CASCADE)
        self.assertLess(numpy.linalg.norm(found.centroid_mm - down), 1e-7)
        # About the ball's centre the inertia is half of the ball's; Steiner's theorem shifts it to the centroid.
        moved = volume / 2 * (down @ down * numpy.eye(3) - numpy.outer(down, down))
        expected = numpy.diag(inertia) / 2 - moved
        self.assertLess(numpy.abs(found.inertia_mm5 - expected).max(), 1e-7 * inertia[0])


if __name__ == "__main__":
    unittest.main()
