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
            Cast N x N rays per pixel and average them.
        contact
            Contact model. ``"rigid"``: the surface follows the indenter; nothing else moves;
            ``"linear"``: elastic layers that yield and bulge, small strain.
        shear_mm
            Tangential motion of the indenter after pressing, linear contact only: on a dome away
            from the tip and around it, at the deepest point; on a pad along x and y.
        friction
            Coulomb friction coefficient for ``shear_mm``. Default: of the touched material.
        spacing_mm
            Node spacing on the surface, linear contact only. Default: as fine as a few seconds
            allow.
        light
            Light source that is on, for example ``uv``. Default: the sensor's usual one.
        constants
            Light constants of a unit, written by ``fit-light``. Default: those of R-Tac0's
            published unit.
        seed
            Seed of noise and drift. ``None``: without noise, drift and the camera's JPEG
            compression.
        allow_no_contact
            Continue if a press does not touch the surface or the camera does not see it.

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
