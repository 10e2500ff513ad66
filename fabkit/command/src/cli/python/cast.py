from __future__ import annotations

from typing import TYPE_CHECKING, Any

import fabkit
from fabkit import _arrays

if TYPE_CHECKING:
    from collections.abc import Sequence
    from os import PathLike

    from numpy.typing import ArrayLike

    from fabkit.calibrate import Extrinsics
    from fabkit.cameras import Camera
    from fabkit.depth import Truth
    from fabkit.designs import Sensor


class Cast:
    """Ground truth of presses."""

    def _see(self, presses: list[str], options: dict[str, Any]) -> Truth:
        raise NotImplementedError

    def cast(
        self,
        press: str | Sequence[str] = (),
        *,
        # ARGUMENTS
    ) -> Truth:
        """Cast a ray for each pixel; see :func:`fabkit.depth.cast`."""
        options: dict[str, Any] = {
            # VALUES
        }
        return self._see([press] if isinstance(press, str) else list(press), options)


def cast(
    sensor: Sensor | str,
    press: str | Sequence[str] = (),
    *,
    camera: Camera | str | PathLike[str] | None = None,
    pose: Extrinsics | str | PathLike[str] | ArrayLike | None = None,
    # ARGUMENTS
) -> Truth:
    """Cast a ray for each pixel: exact depth, normals, labels, and how sure they are.

    To cast many presses with one camera, make a :class:`fabkit.depth.Scene` once.

    Parameters
    ----------
    sensor
        A sensor, or the name of one.
    press
        What presses, ``semi-dome-017`` or ``hemisphere@30deg,120deg,1.2mm`` (an indenter by polar
        angle, azimuth and depth), or several at once; nothing for the untouched surface.
    camera, pose
        As for :class:`fabkit.depth.Scene`.
    # PARAMETERS

    Raises
    ------
    FabkitError
        An unknown press, a press deeper than the surface is soft, one without contact, options
        beyond their limits.
    KeyboardInterrupt
        What is under way ends in the background; its result is dropped.

    >>> import fabkit
    >>> truth = fabkit.depth.cast("rtac0", "hemisphere@30deg,120deg,1mm")
    >>> truth.range_mm.shape, truth.label_names
    ((480, 640), ['none', 'surface', 'hemisphere'])
    """
    scene = fabkit.depth.Scene(sensor, camera=camera, pose=pose)
    return scene.cast(
        press,
        # PASSED
    )
