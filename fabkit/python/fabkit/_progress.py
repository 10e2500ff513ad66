"""How far long work is, shown by tqdm where it is installed."""

from __future__ import annotations

import importlib
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Generator

    Progress = bool | Callable[[int, int], object] | None


@contextmanager
def shown(progress: Progress, what: str) -> Generator[Callable[[int, int], object] | None]:
    """Yield what is to be told ``(done, all)``.

    ``None`` shows a bar on a terminal or in a notebook if tqdm is there, ``True`` everywhere,
    ``False`` nowhere; a function is told itself.
    """
    if callable(progress):
        yield progress
        return
    try:
        tqdm: Any = importlib.import_module("tqdm.auto").tqdm if progress is not False else None
    except ImportError:
        tqdm = None
    if tqdm is None:
        yield None
        return
    # None means: only where somebody looks.
    with tqdm(desc=what, disable=None if progress is None else False, leave=False) as bar:

        def update(done: int, count: int) -> None:
            bar.total = count
            bar.update(done - bar.n)

        yield update
