"""Made from the options of ``fabkit capture`` by ``cargo test -p fabkit``; do not edit."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from fabkit import _arrays

if TYPE_CHECKING:
    from collections.abc import Sequence
    from os import PathLike

    from fabkit.depth import Captured


class Capture:
    """Mixin of :class:`fabkit.depth.Scene`: simulated captures of presses."""

    def _take(self, presses: list[str], options: dict[str, Any]) -> Captured:
        raise NotImplementedError

    def capture(
        self,
        press: str | Sequence[str] = (),
        *,
        samples: int = 1,
        contact: str = "linear",
        shear_mm: tuple[float | str, float | str] = (0.0, 0.0),
        friction: float | None = None,
        spacing_mm: float | str | None = None,
        light: str | None = None,
        constants: str | PathLike[str] | None = None,
        seed: int | None = 0,
        allow_no_contact: bool = False,
    ) -> Captured:
        """Simulate a capture of the pressed sensor, as ``fabkit capture`` does.

        Parameters
        ----------
        press
            A press as for :func:`fabkit.depth.cast`, or several at once. Default: the sensor at
            rest.
        samples
            Cast N x N rays for each pixel, which records their mean.
        contact
            How the layers answer: as elastic ones that bulge, or as what follows the presser and
            nothing else. ``"rigid"``: they follow what presses, and nothing else moves;
            ``"linear"``: they give way as elastic ones do, and bulge.
        shear_mm
            How far all that presses then moves along the surface, in linear contact: on a dome away
            from the tip and around it where it goes deepest, on a pad along x and y.
        friction
            Coulomb's coefficient of friction where something moves along the surface. Default: that
            of the touched material.
        spacing_mm
            Distance of the surface's nodes in linear contact. Default: as fine as a few seconds
            allow.
        light
            Which of the sensor's lights is on, for example ``uv``. Default: its usual one.
        constants
            Constants of a unit's light, as ``fit-light`` writes them. Default: those of R-Tac0's
            published unit.
        seed
            Of noise and drift: another seed is another picture of the same. ``None``: neither noise
            nor drift, and not as the JPEG in which a camera sends it.
        allow_no_contact
            Go on where a press does not touch the surface, or where the camera sees nothing of it.

        Raises
        ------
        FabkitError
            The sensor has no such light, or the file holds no light constants; and as for
            :func:`fabkit.depth.cast`.

        >>> import fabkit
        >>> scene = fabkit.depth.Scene("9dtact")
        >>> captured = scene.capture("ball@0mm,0mm,1mm", seed=None)
        >>> captured.grey.shape, captured.document["is_simulated"]
        ((480, 640), True)
        """
        options: dict[str, Any] = {
            "samples": samples,
            "contact": contact,
            "shear": _arrays.lengths_mm(shear_mm, "shear_mm"),
            "friction": friction,
            "spacing": _arrays.optional_length_mm(spacing_mm, "spacing_mm"),
            "light": light,
            "constants": None if constants is None else os.fspath(constants),
            "seed": 0 if seed is None else seed,
            "no_noise": seed is None,
            "allow_no_contact": allow_no_contact,
        }
        return self._take([press] if isinstance(press, str) else list(press), options)
