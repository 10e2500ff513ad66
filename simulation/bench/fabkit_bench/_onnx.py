"""Writer of ONNX files without the onnx package: graphs, chains of convolutions, perceptrons.

It encodes the few kinds of Protocol Buffers fields that are needed; field numbers are those of
``onnx.proto``. ONNX Runtime reads all files that are written here, ``fabkit reconstruct`` reads the
chains. PyTorch's own exporter is not used: it needs two more packages and writes paths of the
machine's modules into its files.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Axes = Sequence[int | str]

__all__ = ["TYPES", "Convolution", "Dense", "Graph", "OnnxNetwork", "Relu", "chain", "perceptron"]

TYPES = {"float32": 1, "uint8": 2, "uint16": 4, "int64": 7, "float64": 11}
"""ONNX data type numbers by numpy's type names."""

# Attribute types of ONNX.
_FLOAT, _INT, _STRING, _INTS = 1, 2, 3, 7


@dataclass(frozen=True, eq=False)
class OnnxNetwork:
    """A network as ONNX, with its shape and description for the card."""

    onnx: bytes
    """Content of the ONNX file."""
    type: str
    """Type of input and output, by numpy's name."""
    takes: tuple[int | str, ...]
    """Axes of its input ``x``; an axis with a name has any length."""
    gives: tuple[int | str, ...]
    """Axes of its output ``y``."""
    form: str
    """Architecture, in words."""
    learned: str = ""
    """Training, in words."""


@dataclass(frozen=True, eq=False)
class Convolution:
    """A convolution with zero padding that keeps the map's size."""

    weights: NDArray[np.float32]
    """Weights, outputs x inputs of a group x rows x columns."""
    bias: NDArray[np.float32]
    """Bias of each output."""
    groups: int = 1
    """Number of groups of channels; each output sees the inputs of its group."""


@dataclass(frozen=True)
class Relu:
    """The rectifier max(x, 0)."""


@dataclass(frozen=True, eq=False)
class Dense:
    """A fully connected layer."""

    weights: NDArray[np.float64]
    """Weights, inputs x outputs."""
    bias: NDArray[np.float64]
    """Bias of each output."""


class Graph:
    """An ONNX graph under construction; each added node returns its output's name."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._nodes: list[bytes] = []
        self._constants: list[bytes] = []

    def constant(self, values: NDArray[Any], name: str = "") -> str:
        """Add a constant tensor and return its name."""
        name = name or f"c{len(self._constants)}"
        self._constants.append(_tensor(name, values))
        return name

    def node(
        self,
        operator: str,
        *inputs: str,
        out: str = "",
        **attributes: int | float | str | list[int],
    ) -> str:
        """Add an operator of opset 13 and return its output's name.

        An optional input is left out by an empty name.
        """
        out = out or f"t{len(self._nodes) + 1}"
        node = b"".join(_bytes(1, name) for name in inputs) + _bytes(2, out) + _bytes(4, operator)
        node += b"".join(_bytes(5, _attribute(*one)) for one in attributes.items())
        self._nodes.append(node)
        return out

    def model(self, takes: Axes, gives: Axes, type: str = "float32") -> bytes:
        """Return the content of an ONNX file with input ``x`` and output ``y``."""
        graph = b"".join(_bytes(1, node) for node in self._nodes) + _bytes(2, self._name)
        graph += b"".join(_bytes(5, constant) for constant in self._constants)
        graph += _bytes(11, _value("x", takes, type)) + _bytes(12, _value("y", gives, type))
        version = _bytes(8, _integer(2, 13))
        return _integer(1, 8) + _bytes(2, "fabkit") + _bytes(7, graph) + version


def chain(layers: Sequence[Convolution | Relu]) -> bytes:
    """Write a chain of layers from one channel to one as ONNX."""
    graph, last = Graph("chain"), "x"
    for i, layer in enumerate(layers):
        out = "y" if i + 1 == len(layers) else ""
        if isinstance(layer, Relu):
            last = graph.node("Relu", last, out=out)
            continue
        named = ((f"w{i}", layer.weights), (f"b{i}", layer.bias))
        numbers = [graph.constant(values.astype(np.float32), name) for name, values in named]
        rows, columns = (size // 2 for size in layer.weights.shape[2:])
        pads = [rows, columns, rows, columns]
        last = graph.node("Conv", last, *numbers, out=out, pads=pads, group=layer.groups)
    if not layers:
        graph.node("Identity", last, out="y")
    axes = (1, 1, "rows", "columns")
    return graph.model(axes, axes)


def perceptron(
    layers: Sequence[Dense],
    *,
    learned: str,
    within: tuple[float, float] | None = None,
) -> OnnxNetwork:
    """Write a perceptron as ONNX: dense layers with ReLU between them, n x f to n x t.

    Parameters
    ----------
    layers
        Layers, at least one.
    learned
        Training, in words.
    within
        Limits to clip the output at.
    """
    type = "float32"
    graph, last = Graph("perceptron"), "x"
    for i, layer in enumerate(layers):
        numbers = [graph.constant(one.astype(type)) for one in (layer.weights, layer.bias)]
        last = graph.node("Gemm", last, *numbers)
        last = graph.node("Relu", last) if i + 1 < len(layers) else last
    if within is not None:
        last = graph.node("Clip", last, *(graph.constant(np.array(one, type)) for one in within))
    graph.node("Identity", last, out="y")
    sizes = [len(layers[0].weights), *(len(layer.bias) for layer in layers)]
    takes, gives = ("n", sizes[0]), ("n", sizes[-1])
    form = f"perceptron {'-'.join(map(str, sizes))}, ReLU between layers"
    form = form if len(layers) > 1 else f"{sizes[1]} linear sums of {sizes[0]} numbers"
    form += "" if within is None else f", cut off at {within[0]:g} and {within[1]:g}"
    return OnnxNetwork(graph.model(takes, gives, type), type, takes, gives, form, learned)


def _varint(value: int) -> bytes:
    """Encode a number in groups of 7 bits, the lowest first, as Protocol Buffers does."""
    found = bytearray()
    while value >= 0x80:
        found.append(value & 0x7F | 0x80)
        value >>= 7
    found.append(value)
    return bytes(found)


def _integer(number: int, value: int) -> bytes:
    """Encode a field with an integer (wire type 0)."""
    return _varint(number << 3) + _varint(value)


def _bytes(number: int, value: bytes | str) -> bytes:
    """Encode a field with bytes, a text or a message (wire type 2)."""
    value = value.encode() if isinstance(value, str) else value
    return _varint(number << 3 | 2) + _varint(len(value)) + value


def _tensor(name: str, values: NDArray[Any]) -> bytes:
    """Encode a ``TensorProto``."""
    about = b"".join(_integer(1, size) for size in values.shape)
    about += _integer(2, TYPES[values.dtype.name]) + _bytes(8, name)
    little = values.astype(f"<{values.dtype.kind}{values.dtype.itemsize}")
    return about + _bytes(9, little.tobytes())


def _attribute(name: str, value: int | float | str | list[int]) -> bytes:
    """Encode an ``AttributeProto``."""
    if isinstance(value, list):
        written, kind = b"".join(_integer(8, one) for one in value), _INTS
    elif isinstance(value, str):
        written, kind = _bytes(4, value), _STRING
    elif isinstance(value, float):
        written, kind = _varint(2 << 3 | 5) + struct.pack("<f", value), _FLOAT
    else:
        written, kind = _integer(3, value), _INT
    return _bytes(1, name) + written + _integer(20, kind)


def _value(name: str, axes: Axes, type: str) -> bytes:
    """Encode a ``ValueInfoProto``: name, type and axes of an input or output."""
    sizes = [_bytes(2, one) if isinstance(one, str) else _integer(1, one) for one in axes]
    shape = _bytes(2, b"".join(_bytes(1, size) for size in sizes))
    return _bytes(1, name) + _bytes(2, _bytes(1, _integer(1, TYPES[type]) + shape))
