"""The small models: the only place that knows scikit-learn, which has no types.

All of them are seeded and run on one thread, so that figures do not depend on the machine's cores.
"""

from __future__ import annotations

import contextlib
import importlib
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit.errors import invalid

if TYPE_CHECKING:
    from collections.abc import Generator

    from numpy.typing import NDArray

    Array = NDArray[np.floating[Any]]

__all__ = ["Network", "Process", "Ridge", "needed", "one_thread"]


def _module(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        hint = "pip install fabkit-cad[bench]"
        raise invalid("benches need scikit-learn, which is not installed", hint) from error


def needed() -> None:
    """Say at once if scikit-learn is missing."""
    _module("sklearn")


@contextlib.contextmanager
def one_thread() -> Generator[None]:
    """Let linear algebra use one thread: sums in another order differ in their last digits."""
    try:
        limits: Any = importlib.import_module("threadpoolctl").threadpool_limits
    except ImportError:
        # It comes with scikit-learn, without which nothing is learned.
        yield
        return
    with limits(1):
        yield


class Network:
    """A perceptron with hidden layers, ReLU between them, on standardised numbers."""

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
        """Learn: features (n, f), targets (n,) or (n, t)."""
        self._middle, self._spread = _scale(features)
        self._to_middle, self._to_spread = _scale(targets)
        with warnings.catch_warnings():
            # It always ends by its number of epochs.
            warnings.simplefilter("ignore")
            self._model.fit(self._in(features), self._out(targets))
        return self

    def go_on(self, features: Array, targets: Array, epochs: int) -> None:
        """Learn on from other samples, with the scales of the first ones."""
        with warnings.catch_warnings():
            # A batch may be larger than all that there is.
            warnings.simplefilter("ignore")
            for _ in range(epochs):
                self._model.partial_fit(self._in(features), self._out(targets))

    def predict(self, features: Array) -> Array:
        """Answer (n,) or (n, t)."""
        return self._model.predict(self._in(features)) * self._to_spread + self._to_middle

    def _in(self, features: Array) -> Array:
        return (features - self._middle) / self._spread

    def _out(self, targets: Array) -> Array:
        return (targets - self._to_middle) / self._to_spread


class Ridge:
    """Least squares with a penalty, chosen among some by leaving out one sample after the other."""

    def __init__(self, penalties: tuple[float, ...] = (1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0)) -> None:
        self._model = _module("sklearn.linear_model").RidgeCV(alphas=penalties)

    def fit(self, features: Array, targets: Array) -> Ridge:
        """Learn: features (n, f), targets (n,) or (n, t)."""
        self._middle, self._spread = _scale(features)
        self._model.fit((features - self._middle) / self._spread, targets)
        return self

    def predict(self, features: Array) -> Array:
        """Answer (n,) or (n, t)."""
        return self._model.predict((features - self._middle) / self._spread)


class Components:
    """The directions in which samples differ most."""

    def __init__(self, count: int) -> None:
        self._count = count

    def fit(self, samples: Array) -> Components:
        """Learn from (n, f)."""
        self._middle = samples.mean(axis=0)
        _, _, directions = np.linalg.svd(samples - self._middle, full_matrices=False)
        self._directions = directions[: self._count]
        return self

    def __call__(self, samples: Array) -> Array:
        """Tell how far samples (n, f) lie along them: (n, count)."""
        found: Array = np.einsum("nf,cf->nc", samples - self._middle, self._directions)
        return found


class Process:
    """A Gaussian process of one number, with noise, its lengths fitted."""

    def __init__(self, seed: int) -> None:
        kernels = _module("sklearn.gaussian_process.kernels")
        kernel = kernels.ConstantKernel() * kernels.RBF() + kernels.WhiteKernel()
        self._model = _module("sklearn.gaussian_process").GaussianProcessRegressor(
            kernel, normalize_y=True, random_state=seed
        )

    def fit(self, features: Array, targets: Array) -> Process:
        """Learn: features (n, f), targets (n,)."""
        self._middle, self._spread = _scale(features)
        with warnings.catch_warnings():
            # A length at its bound is an answer too.
            warnings.simplefilter("ignore")
            self._model.fit((features - self._middle) / self._spread, targets)
        return self

    def predict(self, features: Array) -> Array:
        """Answer (n,)."""
        return self._model.predict((features - self._middle) / self._spread)


def _scale(values: Array) -> tuple[Array, Array]:
    """Mean and standard deviation of each column; 1 where nothing varies."""
    spread = values.std(axis=0)
    return values.mean(axis=0), np.where(spread > 1e-12, spread, 1.0)
