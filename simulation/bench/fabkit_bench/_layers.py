"""Conversion of trained PyTorch layers to nodes of an ONNX graph."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from fabkit_bench._onnx import Graph

__all__ = ["layer"]


def layer(graph: Graph, module: Any, given: str) -> str:
    """Write a module of a type that the papers' networks use; return its output's name."""
    return _LAYERS[type(module).__name__](graph, module, given)


def _constant(graph: Graph, values: Any) -> str:
    found: NDArray[np.float32] = values.detach().numpy()
    return graph.constant(found)


def _integers(graph: Graph, *values: int) -> str:
    return graph.constant(np.array(values, np.int64))


def _sequential(graph: Graph, module: Any, given: str) -> str:
    for one in module:
        given = layer(graph, one, given)
    return given


def _convolution(graph: Graph, module: Any, given: str) -> str:
    numbers = [_constant(graph, one) for one in (module.weight, module.bias) if one is not None]
    pads, strides = [*module.padding, *module.padding], list(module.stride)
    return graph.node("Conv", given, *numbers, pads=pads, strides=strides)


def _normalised(graph: Graph, module: Any, given: str) -> str:
    numbers = (module.weight, module.bias, module.running_mean, module.running_var)
    names = [_constant(graph, one) for one in numbers]
    return graph.node("BatchNormalization", given, *names, epsilon=float(module.eps))


def _largest(graph: Graph, module: Any, given: str) -> str:
    size, stride, pad = module.kernel_size, module.stride, module.padding
    sizes: dict[str, Any] = {"kernel_shape": [size] * 2, "strides": [stride] * 2, "pads": [pad] * 4}
    return graph.node("MaxPool", given, **sizes, ceil_mode=int(module.ceil_mode))


def _linear(graph: Graph, module: Any, given: str) -> str:
    numbers = [_constant(graph, one) for one in (module.weight, module.bias)]
    return graph.node("Gemm", given, *numbers, transB=1)


def _larger(graph: Graph, module: Any, given: str) -> str:
    factor = module.scale_factor
    scales = graph.constant(np.array([1, 1, factor, factor], np.float32))
    # Repeats each pixel, as PyTorch's nearest upsampling does.
    how = {"mode": "nearest", "nearest_mode": "floor"}
    how["coordinate_transformation_mode"] = "asymmetric"
    return graph.node("Resize", given, "", scales, **how)


def _split(graph: Graph, module: Any, given: str) -> str:
    return graph.node("Reshape", given, _integers(graph, -1, *module.unflattened_size))


def _block(graph: Graph, module: Any, given: str) -> str:
    ahead, around = (layer(graph, one, given) for one in (module.ahead, module.around))
    return graph.node("Relu", graph.node("Add", ahead, around))


def _last(graph: Graph, module: Any, given: str) -> str:
    """Write an LSTM that predicts from its last step.

    ONNX has steps as the first axis, and another order of gates than PyTorch.
    """
    steps, width = module.steps, module.steps.hidden_size
    given = graph.node("Transpose", given, perm=[1, 0, 2])
    for k in range(steps.num_layers):
        gates = [_reordered(getattr(steps, f"{name}_l{k}"), width) for name in _GATES]
        bias = np.concatenate(gates[2:])
        numbers = [graph.constant(one[None]) for one in (*gates[:2], bias)]
        given = graph.node("LSTM", given, *numbers, hidden_size=width)
        # Remove the axis of directions, which has one.
        given = graph.node("Squeeze", given, _integers(graph, 1))
    last = graph.node("Gather", given, graph.constant(np.array(-1, np.int64)), axis=0)
    return layer(graph, module.out, last)


_GATES = ("weight_ih", "weight_hh", "bias_ih", "bias_hh")


def _reordered(values: Any, width: int) -> NDArray[np.float32]:
    """Reorder gates from PyTorch's order to ONNX's.

    PyTorch: input, forget, cell, output. ONNX: input, output, forget, cell.
    """
    into, forget, cell, out = values.detach().numpy().reshape(4, width, *values.shape[1:])
    return np.concatenate([into, out, forget, cell])


def _operator(name: str) -> Callable[[Graph, Any, str], str]:
    return lambda graph, _, given: graph.node(name, given)


_LAYERS: dict[str, Callable[[Graph, Any, str], str]] = {
    "AdaptiveAvgPool2d": _operator("GlobalAveragePool"),
    "BatchNorm2d": _normalised,
    "Block": _block,
    "Conv2d": _convolution,
    "Flatten": _operator("Flatten"),
    "Identity": _operator("Identity"),
    "Last": _last,
    "Linear": _linear,
    "MaxPool2d": _largest,
    "ReLU": _operator("Relu"),
    "Sequential": _sequential,
    "Sigmoid": _operator("Sigmoid"),
    "Unflatten": _split,
    "Upsample": _larger,
}
