from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from fabkit import _arrays

if TYPE_CHECKING:
    from collections.abc import Sequence
    from os import PathLike

    from fabkit.depth import Captured


class Capture:
    """Pictures of presses."""

    def _take(self, presses: list[str], options: dict[str, Any]) -> Captured:
        raise NotImplementedError

    def capture(
        self,
        press: str | Sequence[str] = (),
        *,
        # ARGUMENTS
    ) -> Captured:
        """Take the picture of a press, simulated, as ``fabkit capture`` does.

        Parameters
        ----------
        press
            What presses, as for :func:`fabkit.depth.cast`, or several at once; nothing for the
            sensor at rest.
        # PARAMETERS

        Raises
        ------
        FabkitError
            A light that the sensor has not, a file that is none of constants, and as for
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
