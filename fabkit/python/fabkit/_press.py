"""Made from the options of ``fabkit press`` by ``cargo test -p fabkit``; do not edit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import fabkit.pressing
from fabkit import _arrays

if TYPE_CHECKING:
    from fabkit.designs import Sensor
    from fabkit.pressing import Pressed


def press(
    sensor: Sensor | str,
    indenter: str,
    depth_mm: float | str,
    *,
    contact: str = "linear",
    shear_mm: tuple[float | str, float | str] = (0.0, 0.0),
    friction: float | None = None,
    steps: int = 10,
    spacing_mm: float | str | None = None,
) -> Pressed:
    """Press an indenter into a sensor's soft layers, as ``fabkit press`` does.

    Layers are bonded to each other and to rigid bodies; see the book's page on presses for what
    that leaves out.

    Parameters
    ----------
    sensor
        A sensor, or the name of one.
    indenter
        Name and place of the indenter: ``ball@30deg,120deg`` by polar angle and azimuth on a dome,
        ``ball@2mm,-3mm`` on a pad.
    depth_mm
        Indentation along the surface's normal at that place; like all lengths, a number of mm, or
        text with a unit.
    contact
        Elastic model. ``"linear"``: small strain, layered, nearly incompressible, with Coulomb
        friction; ``"finite"``: large strain, neo-Hookean, without friction, axially symmetric: at
        the tip of a dome or on a pad; takes seconds.
    shear_mm
        Tangential motion of the indenter after pressing: on a dome away from the tip and around it,
        on a pad along x and y.
    friction
        Coulomb friction coefficient for ``shear_mm``. Default: of the touched material.
    steps
        Number of equal steps of the force curve.
    spacing_mm
        Node spacing on the surface. Default: about 5,000 nodes on a dome, about 20 across the
        contact on a pad.

    Raises
    ------
    FabkitError
        The press is unknown or deeper than the layers, or the contact does not converge.

    >>> import fabkit
    >>> pressed = fabkit.press("rtac0", "ball@0deg,0deg", "0.6 mm", steps=3)
    >>> [round(step["depth_mm"], 1) for step in pressed.curve], pressed.force_n[2] < 0
    ([0.2, 0.4, 0.6], True)
    """
    options: dict[str, Any] = {
        "contact": contact,
        "shear": _arrays.lengths_mm(shear_mm, "shear_mm"),
        "friction": friction,
        "steps": steps,
        "spacing": _arrays.optional_length_mm(spacing_mm, "spacing_mm"),
    }
    return fabkit.pressing.pressed(sensor, indenter, depth_mm, options)
