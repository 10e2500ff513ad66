"""Made from the options of ``fabkit depth`` by ``cargo test -p fabkit``; do not edit."""

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
        samples: int = 1,
        contact: str | None = None,
        membrane_mm: float | str = 0.0,
        shear_mm: tuple[float | str, float | str] = (0.0, 0.0),
        friction: float | None = None,
        spacing_mm: float | str | None = None,
        print_sigma_mm: float | str = 0.05,
        allow_no_contact: bool = False,
    ) -> Truth:
        """Compute ground truth for each pixel; see :func:`fabkit.depth.cast`."""
        options: dict[str, Any] = {
            "samples": samples,
            "contact": contact,
            "membrane": _arrays.length_mm(membrane_mm, "membrane_mm"),
            "shear": _arrays.lengths_mm(shear_mm, "shear_mm"),
            "friction": friction,
            "spacing": _arrays.optional_length_mm(spacing_mm, "spacing_mm"),
            "print_sigma": _arrays.length_mm(print_sigma_mm, "print_sigma_mm"),
            "allow_no_contact": allow_no_contact,
        }
        return self._see([press] if isinstance(press, str) else list(press), options)


def cast(
    sensor: Sensor | str,
    press: str | Sequence[str] = (),
    *,
    camera: Camera | str | PathLike[str] | None = None,
    pose: Extrinsics | str | PathLike[str] | ArrayLike | None = None,
    samples: int = 1,
    contact: str | None = None,
    membrane_mm: float | str = 0.0,
    shear_mm: tuple[float | str, float | str] = (0.0, 0.0),
    friction: float | None = None,
    spacing_mm: float | str | None = None,
    print_sigma_mm: float | str = 0.05,
    allow_no_contact: bool = False,
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
    samples
        Cast N x N rays per pixel; maps become N times as large each way.
    contact
        Contact model. Default: membrane with ``membrane_mm``, else rigid. ``"rigid"``: the surface
        follows the indenter; nothing else moves; ``"membrane"``: the surface returns to rest over
        the distance ``membrane_mm``; ``"linear"``: elastic layers that yield and bulge, small
        strain.
    membrane_mm
        Distance around a contact over which the gel returns to rest, 0 mm to 10 mm; without it only
        the contact moves.
    shear_mm
        Tangential motion of the indenter after pressing, linear contact only: on a dome away from
        the tip and around it, at the deepest point; on a pad along x and y.
    friction
        Coulomb friction coefficient for ``shear_mm``, linear contact only. Default: of the touched
        material.
    spacing_mm
        Node spacing on the surface, linear contact only. Default: as fine as a few seconds allow.
    print_sigma_mm
        Standard deviation of printed and cast surfaces along their normals, 0 mm to 1 mm.
    allow_no_contact
        Continue if a press does not touch the surface or the camera does not see it.

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
        samples=samples,
        contact=contact,
        membrane_mm=membrane_mm,
        shear_mm=shear_mm,
        friction=friction,
        spacing_mm=spacing_mm,
        print_sigma_mm=print_sigma_mm,
        allow_no_contact=allow_no_contact,
    )
