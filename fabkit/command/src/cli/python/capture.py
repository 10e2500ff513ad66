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
        # ARGUMENTS
    ) -> Captured:
        """Simulate a capture of the pressed sensor, as ``fabkit capture`` does.

        Parameters
        ----------
        press
            A press as for :func:`fabkit.depth.cast`, or several at once. Default: the sensor at
            rest.
        # PARAMETERS

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
            # VALUES
        }
        return self._take([press] if isinstance(press, str) else list(press), options)
