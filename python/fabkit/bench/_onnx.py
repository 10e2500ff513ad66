"""Writes chains of convolutions as ONNX, without its package.

Protocol buffers of two kinds of field; their numbers are those of ``onnx.proto``. ``fabkit
reconstruct`` reads what is written here, and so does ONNX Runtime.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

__all__ = ["Convolution", "Relu", "chain"]

_FLOAT, _INT, _INTS = 1, 2, 7


@dataclass(frozen=True, eq=False)
class Convolution:
    """A convolution that keeps a map's size."""

    weights: NDArray[np.float32]
    """Outputs x inputs of a group x rows x columns."""
    bias: NDArray[np.float32]
    """One for each output."""
    groups: int = 1


@dataclass(frozen=True)
class Relu:
    """Zero below zero."""


def _varint(value: int) -> bytes:
    found = bytearray()
    while value >= 0x80:
        found.append(value & 0x7F | 0x80)
        value >>= 7
    found.append(value)
    return bytes(found)


def _integer(number: int, value: int) -> bytes:
    return _varint(number << 3) + _varint(value)


def _bytes(number: int, value: bytes | str) -> bytes:
    value = value.encode() if isinstance(value, str) else value
    return _varint(number << 3 | 2) + _varint(len(value)) + value


def _tensor(name: str, values: NDArray[np.float32]) -> bytes:
    sizes = b"".join(_integer(1, size) for size in values.shape)
    return sizes + _integer(2, _FLOAT) + _bytes(8, name) + _bytes(9, values.astype("<f4").tobytes())


def _map(name: str) -> bytes:
    """Say that a map is 1 x 1 x rows x columns, any of either."""
    axes = [_integer(1, 1), _integer(1, 1), _bytes(2, "rows"), _bytes(2, "columns")]
    shape = b"".join(_bytes(1, axis) for axis in axes)
    return _bytes(1, name) + _bytes(2, _bytes(1, _integer(1, _FLOAT) + _bytes(2, shape)))


def chain(layers: Sequence[Convolution | Relu]) -> bytes:
    """Write a model of these layers one after the other, from one channel to one."""
    nodes, constants = b"", b""
    for i, layer in enumerate(layers):
        inputs = ["x" if i == 0 else f"t{i}"]
        output = "y" if i + 1 == len(layers) else f"t{i + 1}"
        attributes = b""
        if isinstance(layer, Convolution):
            for name, values in ((f"w{i}", layer.weights), (f"b{i}", layer.bias)):
                inputs.append(name)
                constants += _bytes(5, _tensor(name, values))
            rows, columns = layer.weights.shape[2:]
            pads = b"".join(_integer(8, size // 2) for size in (rows, columns, rows, columns))
            attributes = _bytes(5, _bytes(1, "pads") + pads + _integer(20, _INTS))
            group = _bytes(1, "group") + _integer(3, layer.groups) + _integer(20, _INT)
            attributes += _bytes(5, group)
        node = b"".join(_bytes(1, name) for name in inputs) + _bytes(2, output)
        node += _bytes(4, "Conv" if isinstance(layer, Convolution) else "Relu") + attributes
        nodes += _bytes(1, node)
    if not layers:
        nodes = _bytes(1, _bytes(1, "x") + _bytes(2, "y") + _bytes(4, "Identity"))
    graph = nodes + _bytes(2, "chain") + constants + _bytes(11, _map("x")) + _bytes(12, _map("y"))
    return _integer(1, 8) + _bytes(2, "fabkit") + _bytes(7, graph) + _bytes(8, _integer(2, 13))
