"""Small regression models from scikit-learn; no other module imports it, as it has no types.

All models are seeded and run on one thread, so that figures do not depend on the number of cores.
"""

from __future__ import annotations

import contextlib
import importlib
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit.errors import invalid
from fabkit_bench._onnx import Dense, Graph, OnnxNetwork, perceptron

if TYPE_CHECKING:
    from collections.abc import Generator

    from numpy.typing import NDArray

    from fabkit_bench._similarity import Code

    Array = NDArray[np.floating[Any]]

__all__ = ["Components", "Network", "Process", "Ridge", "one_thread", "require"]


def _module(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        hint = "pip install fabkit-cad[bench]"
        raise invalid("benches need scikit-learn, which is not installed", hint) from error


def require() -> None:
    """Raise if scikit-learn is missing."""
    _module("sklearn")


@contextlib.contextmanager
def one_thread() -> Generator[None]:
    """Limit linear algebra to one thread: sums in another order differ in their last digits."""
    try:
        limits: Any = importlib.import_module("threadpoolctl").threadpool_limits
    except ImportError:
        # It comes with scikit-learn; without that nothing is trained.
        yield
        return
    with limits(1):
        yield


class Network:
    """A multilayer perceptron with ReLU, on standardised features and targets."""

    def __init__(
        self,
        hidden: tuple[int, ...],
        *,
        seed: int,
        epochs: int,
        rate: float = 1e-3,
        batch: int = 200,
    ) -> None:
        self._model = _module("sklearn.neural_network").MLPRegressor(
            hidden_layer_sizes=hidden,
            batch_size=batch,
            learning_rate_init=rate,
            max_iter=epochs,
            n_iter_no_change=epochs,
            random_state=seed,
        )

    def fit(self, features: Array, targets: Array) -> Network:
        """Train on features (n, f) and targets (n,) or (n, t)."""
        self._middle, self._spread = _scale(features)
        self._to_middle, self._to_spread = _scale(targets)
        with warnings.catch_warnings():
            # scikit-learn warns whenever training ends by the number of epochs, as it always does.
            warnings.simplefilter("ignore")
            self._model.fit(self._in(features), self._out(targets))
        return self

    def fine_tune(self, features: Array, targets: Array, epochs: int) -> None:
        """Continue training on other samples, with the scales of the first ones."""
        with warnings.catch_warnings():
            # scikit-learn warns if a batch is larger than the number of samples.
            warnings.simplefilter("ignore")
            for _ in range(epochs):
                self._model.partial_fit(self._in(features), self._out(targets))

    def predict(self, features: Array) -> Array:
        """Predict targets (n,) or (n, t)."""
        return self._model.predict(self._in(features)) * self._to_spread + self._to_middle

    def layers(self, of: Components | None = None) -> list[Dense]:
        """Return the layers with standardisation folded in: raw numbers in and out."""
        sums = zip(self._model.coefs_, self._model.intercepts_, strict=True)
        layers = [Dense(weights, bias) for weights, bias in sums]
        layers[0] = _standardising(layers[0], self._middle, self._spread)
        if of is not None:
            layers[0] = of.before(layers[0])
        last, spread, middle = layers[-1], self._to_spread, self._to_middle
        layers[-1] = Dense(last.weights * spread, last.bias * spread + middle)
        return layers

    def to_onnx(
        self, *, of: Components | None = None, within: tuple[float, float] | None = None
    ) -> OnnxNetwork:
        """Write the network as ONNX with raw inputs and outputs: n x f to n x t.

        Parameters
        ----------
        of
            Components that its features are; the ONNX input is then the samples themselves.
        within
            Limits to clip the output at.
        """
        model = self._model
        learned = (
            f"squared error, Adam at first {model.learning_rate_init:g}, {model.max_iter} epochs, "
            f"batches of {model.batch_size}"
        )
        return perceptron(self.layers(of), learned=learned, within=within)

    def _in(self, features: Array) -> Array:
        return (features - self._middle) / self._spread

    def _out(self, targets: Array) -> Array:
        return (targets - self._to_middle) / self._to_spread


class Ridge:
    """Ridge regression; leave-one-out cross-validation chooses the penalty."""

    def __init__(self, penalties: tuple[float, ...] = (1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0)) -> None:
        self._model = _module("sklearn.linear_model").RidgeCV(alphas=penalties)

    def fit(self, features: Array, targets: Array) -> Ridge:
        """Train on features (n, f) and targets (n,) or (n, t)."""
        self._middle, self._spread = _scale(features)
        self._model.fit((features - self._middle) / self._spread, targets)
        return self

    def predict(self, features: Array) -> Array:
        """Predict targets (n,) or (n, t)."""
        return self._model.predict((features - self._middle) / self._spread)

    def layers(self, into: Code | None = None) -> list[Dense]:
        """Return its one layer with standardisation folded in: raw numbers in."""
        weights = np.transpose(np.atleast_2d(self._model.coef_))
        layer = Dense(weights, np.atleast_1d(self._model.intercept_))
        layer = _standardising(layer, self._middle, self._spread)
        return [layer if into is None else into.after(layer)]

    def to_onnx(
        self, *, into: Code | None = None, within: tuple[float, float] | None = None
    ) -> OnnxNetwork:
        """Write the model as ONNX with raw inputs: n x f to n x t.

        Parameters
        ----------
        into
            Code whose numbers it predicts; the ONNX output is then the decoded images.
        within
            Limits to clip the output at.
        """
        learned = f"ridge, penalty {self._model.alpha_:g} by leaving one sample out"
        return perceptron(self.layers(into), learned=learned, within=within)


class Components:
    """Principal components of samples."""

    def __init__(self, count: int) -> None:
        self._count = count

    def fit(self, samples: Array) -> Components:
        """Compute the components of samples (n, f)."""
        self._middle = samples.mean(axis=0)
        _, _, directions = np.linalg.svd(samples - self._middle, full_matrices=False)
        self._directions = directions[: self._count]
        return self

    def __call__(self, samples: Array) -> Array:
        """Project samples (n, f) onto the components: (n, count)."""
        found: Array = np.einsum("nf,cf->nc", samples - self._middle, self._directions)
        return found

    def before(self, layer: Dense) -> Dense:
        """Convert a layer that takes components to one that takes samples."""
        weights: Array = np.transpose(self._directions) @ layer.weights
        return Dense(weights, layer.bias - self._middle @ weights)


class Process:
    """Gaussian process regression of one number, with fitted length scales and noise."""

    def __init__(self, seed: int) -> None:
        kernels = _module("sklearn.gaussian_process.kernels")
        kernel = kernels.ConstantKernel() * kernels.RBF() + kernels.WhiteKernel()
        self._model = _module("sklearn.gaussian_process").GaussianProcessRegressor(
            kernel, normalize_y=True, random_state=seed
        )

    def fit(self, features: Array, targets: Array) -> Process:
        """Train on features (n, f) and targets (n,)."""
        self._middle, self._spread = _scale(features)
        with warnings.catch_warnings():
            # scikit-learn warns if a length scale ends at its bound, which is acceptable.
            warnings.simplefilter("ignore")
            self._model.fit((features - self._middle) / self._spread, targets)
        return self

    def predict(self, features: Array) -> Array:
        """Predict targets (n,)."""
        return self._model.predict((features - self._middle) / self._spread)

    def to_onnx(self) -> OnnxNetwork:
        """Write the mean as ONNX with raw inputs and outputs: n x f to n x 1.

        It uses float64, as the evaluation here: weights of both signs may nearly cancel.
        """
        model, graph = self._model, Graph("process")
        kernel = model.kernel_.k1
        length = self._spread * kernel.k2.length_scale
        near = model.X_train_ / kernel.k2.length_scale
        alone = graph.constant(np.array([1], np.int64))
        scaled = graph.node("Sub", "x", graph.constant(self._middle))
        scaled = graph.node("Div", scaled, graph.constant(length))
        # (n, 1, f) minus (m, f): differences of each sample to each training sample.
        apart = graph.node("Unsqueeze", scaled, alone)
        apart = graph.node("Sub", apart, graph.constant(near))
        apart = graph.node("Mul", apart, apart)
        apart = graph.node("ReduceSum", apart, graph.constant(np.array([2], np.int64)), keepdims=0)
        alike = graph.node("Exp", graph.node("Mul", apart, graph.constant(np.array(-0.5))))
        weights = kernel.k1.constant_value * model._y_train_std * model.alpha_.reshape(-1, 1)
        found = graph.node("MatMul", alike, graph.constant(weights))
        middle = np.atleast_1d(model._y_train_mean).astype(float)
        graph.node("Add", found, graph.constant(middle), out="y")
        takes, gives = ("n", near.shape[1]), ("n", 1)
        form = f"Gaussian process of {len(near)} samples: its mean, with a squared exponential"
        learned = "likeliest constant, length and noise, from their defaults"
        written = graph.model(takes, gives, "float64")
        return OnnxNetwork(written, "float64", takes, gives, form, learned)


def _standardising(layer: Dense, middle: Array, spread: Array) -> Dense:
    """Fold standardisation of the inputs into a layer."""
    weights = layer.weights / spread[:, None]
    return Dense(weights, layer.bias - middle @ weights)


def _scale(values: Array) -> tuple[Array, Array]:
    """Compute mean and standard deviation of each column; 1 where values are constant."""
    spread = values.std(axis=0)
    return values.mean(axis=0), np.where(spread > 1e-12, spread, 1.0)
