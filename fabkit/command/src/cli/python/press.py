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
    # ARGUMENTS
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
    # PARAMETERS

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
        # VALUES
    }
    return fabkit.pressing.pressed(sensor, indenter, depth_mm, options)
