"""Progress of long calls, shown by tqdm where it is installed."""

from __future__ import annotations

import importlib
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Generator

    Progress = bool | Callable[[int, int], object] | None


@contextmanager
def shown(progress: Progress, what: str) -> Generator[Callable[[int, int], object] | None]:
    """Yield the function to call with ``(done, total)``, or ``None`` for no display.

    Parameters
    ----------
    progress
        ``None`` shows a bar on a terminal or in a notebook if tqdm is installed, ``True``
        everywhere, ``False`` nowhere; a function is yielded as it is.
    what
        Text beside the bar.
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
    # `disable=None` makes tqdm draw only on a terminal.
    with tqdm(desc=what, disable=None if progress is None else False, leave=False) as bar:

        def update(done: int, count: int) -> None:
            bar.total = count
            bar.update(done - bar.n)

        yield update
