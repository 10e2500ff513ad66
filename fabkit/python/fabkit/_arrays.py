"""Conversion of arguments to what the compiled library takes; errors name the wrong argument."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit import _fabkit
from fabkit.errors import InvalidInputError, invalid

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from fabkit.sim import Asked, Body


def numbers(values: ArrayLike, name: str) -> NDArray[np.float64]:
    """Convert to float64 in C order, of any shape; raise unless all values are real numbers."""
    given = np.asarray(values)
    if given.dtype.kind not in "fiu":
        raise invalid(f"{name} has the dtype {given.dtype}; it must hold real numbers")
    return np.asarray(given, dtype=np.float64, order="C")


def rows(values: ArrayLike, columns: int, name: str) -> tuple[NDArray[np.float64], tuple[int, ...]]:
    """Flatten (..., columns) to (n, columns); return it with the leading shape."""
    given = numbers(values, name)
    if given.ndim == 0 or given.shape[-1] != columns:
        raise _shape(name, given, f"(..., {columns})")
    return given.reshape(-1, columns), given.shape[:-1]


def matrix(values: ArrayLike, size: int, name: str) -> list[list[float]]:
    """Convert a (size, size) matrix to a list of rows."""
    given = numbers(values, name)
    if given.shape != (size, size):
        raise _shape(name, given, f"({size}, {size})")
    return given.tolist()


def vector(values: ArrayLike, count: int, name: str) -> NDArray[np.float64]:
    """Convert to shape (count,); a single number is repeated."""
    given = numbers(values, name)
    if given.ndim == 0:
        return np.full(count, given)
    if given.shape != (count,):
        raise _shape(name, given, f"({count},) or ()")
    return given


def luminance(values: ArrayLike, name: str) -> NDArray[np.float32]:
    """Convert an image to luminance from 0 to 1, (rows, columns).

    The input is (rows, columns), or (rows, columns, 3 or 4) in the order RGB; alpha is ignored.
    Integers are divided by the largest value of their type; colours are weighted as in ITU-R
    BT.709, without undoing gamma.
    """
    given = np.asarray(values)
    if given.dtype.kind == "u":
        scale = float(np.iinfo(given.dtype).max)
    elif given.dtype.kind == "f":
        scale = 1.0
    else:
        raise invalid(f"{name} has the dtype {given.dtype}; it must be unsigned or floating point")
    if given.ndim == 3 and given.shape[2] in (3, 4):
        weights = np.array([0.2126, 0.7152, 0.0722])
        given = np.asarray(given[..., :3] @ weights)
    if given.ndim != 2:
        raise _shape(name, given, "(rows, columns) or (rows, columns, 3)")
    return np.ascontiguousarray(given / scale, dtype=np.float32)


def length_mm(value: float | str, name: str) -> float:
    """Convert a length to mm: a number is in mm, a text has a unit."""
    return _fabkit.length_mm(value, name) if isinstance(value, str) else float(value)


def optional_length_mm(value: float | str | None, name: str) -> float | None:
    """Convert a length to mm; ``None`` stays ``None``."""
    return None if value is None else length_mm(value, name)


def lengths_mm(value: tuple[float | str, float | str], name: str) -> tuple[float, float]:
    """Convert two lengths to mm."""
    first, second = value
    return length_mm(first, name), length_mm(second, name)


def sides_mm(
    value: tuple[float | str, float | str] | None, name: str
) -> tuple[float, float] | None:
    """Convert width and depth to mm; ``None`` stays ``None``."""
    if value is None:
        return None
    width, depth = value
    return length_mm(width, name), length_mm(depth, name)


def view(given: str | tuple[float, float] | None) -> str | None:
    """Convert a viewing direction to the command's text: a side, or ``azimuth,elevation``."""
    return given if given is None or isinstance(given, str) else ",".join(map(str, given))


def _shape(name: str, given: NDArray[Any], wanted: str) -> InvalidInputError:
    return invalid(f"{name} has the shape {given.shape}; it must be {wanted}")


def image(picture: ArrayLike, name: str) -> NDArray[np.float32]:
    """Convert an image to rows x columns x channels, float32 from 0 to 1."""
    given = np.asarray(picture)
    if given.dtype.kind == "u":
        given = given / np.float32(np.iinfo(given.dtype).max)
    elif given.dtype.kind != "f":
        raise invalid(f"{name} has the dtype {given.dtype}; it must be unsigned or floating point")
    if given.ndim == 2:
        given = given[:, :, None]
    if given.ndim != 3 or given.shape[2] not in (1, 3):
        raise invalid(f"{name} has the shape {given.shape}; it must be (rows, columns[, 3])")
    return np.ascontiguousarray(given, dtype=np.float32)


def press_arguments(
    pressers: list[str | Body],
    asked: Asked,
) -> tuple[
    list[str],
    list[tuple[str, list[float], list[list[float]]]],
    tuple[float, float],
    float | None,
    int | None,
]:
    """Convert a press to names, bodies (kind, sizes in mm, pose), shear in mm, friction, seed."""
    names = [one for one in pressers if isinstance(one, str)]
    bodies = [
        (one.kind, list(one.sizes_mm), one.sensor_from_body.tolist())
        for one in pressers
        if not isinstance(one, str)
    ]
    return names, bodies, lengths_mm(asked.shear_mm, "shear_mm"), asked.friction, asked.seed
