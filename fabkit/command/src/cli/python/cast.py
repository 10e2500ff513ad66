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
    """Mixin of :class:`fabkit.depth.Scene`: ground truth of presses."""

    def _see(self, presses: list[str], options: dict[str, Any]) -> Truth:
        raise NotImplementedError

    def cast(
        self,
        press: str | Sequence[str] = (),
        *,
        # ARGUMENTS
    ) -> Truth:
        """Compute ground truth for each pixel; see :func:`fabkit.depth.cast`."""
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
    """Compute exact ground truth for each pixel: depth, normals, labels, standard deviations.

    It casts a ray for each pixel. For many presses with one camera, create a
    :class:`fabkit.depth.Scene` once.

    Parameters
    ----------
    sensor
        A sensor, or the name of one.
    press
        A press such as ``semi-dome-017`` or ``hemisphere@30deg,120deg,1.2mm`` (an indenter with
        polar angle, azimuth and indentation), or several at once. Default: the surface at rest.
    camera, pose
        As for :class:`fabkit.depth.Scene`.
    # PARAMETERS

    Raises
    ------
    FabkitError
        The press is unknown, deeper than the soft layers, or without contact, or an option is out
        of its limits.
    KeyboardInterrupt
        The call was interrupted; the computation ends in the background and its result is dropped.

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
