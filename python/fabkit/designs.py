"""Sensors and the fixtures that calibrate them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fabkit import _fabkit
from fabkit.bodies import Body

if TYPE_CHECKING:
    from collections.abc import Mapping
    from os import PathLike


def sensors() -> list[str]:
    """Names of the built-in sensors."""
    return _fabkit.sensors()


def load(
    sensor: str | PathLike[str],
    overrides: Mapping[str, object] | None = None,
    *,
    preset: str | None = None,
    **values: object,
) -> Sensor:
    """Read a sensor: a built-in one by name, or a YAML file."""
    dotted = {name.replace("__", "."): value for name, value in values.items()}
    listed = [f"{path}={value}" for path, value in ({**(overrides or {}), **dotted}).items()]
    return Sensor(_fabkit.load(str(sensor), preset, listed))


class Design:
    """A kit of parts: a sensor, or a fixture made for one."""

    def __init__(self, native: _fabkit.Design) -> None:
        self._native = native

    @property
    def parts(self) -> dict[str, Body]:
        """What is made from a file, by name."""
        names = self._native.body_names()
        return {name: Body(self._native, name, kind) for kind, name in names if kind == "part"}


class Fixture(Design):
    """Calibration hardware made for a sensor."""


class Sensor(Design):
    """A sensor."""

    def __init__(self, project: _fabkit.Project) -> None:
        super().__init__(project.design())
        self._project = project
