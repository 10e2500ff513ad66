"""Tasks on an executor of the caller: lost ones are retried, results are yielded as they finish."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from fabkit.errors import FabkitError, Problem, invalid

if TYPE_CHECKING:
    from collections.abc import Generator

Result = TypeVar("Result")
Submit: TypeAlias = "Callable[..., Future[Any]] | None"
"""Function that submits a task and returns its future; ``None`` runs tasks in this process."""

# Longest wait for a Dask scheduler to answer.
_CONNECT_SECONDS = 10


def completed(
    submit: Submit,
    work: Callable[[list[int]], tuple[Result, Exception | None]],
    tasks: list[list[int]],
    retries: int,
    what: str,
) -> Generator[Result]:
    """Yield the result of each task as it finishes; raise an error after all finished results.

    Parameters
    ----------
    submit
        Submits a task; ``None`` runs the tasks here, one after the other.
    work
        Computes a task. Returns the result, and the error that stopped it after that, if any. It
        must return the same on every worker and at every attempt.
    tasks
        Numbers of the items in each task.
    retries
        Number of further attempts at a task whose worker was lost.
    what
        Name of the items, plural, for messages.
    """
    if submit is None:
        for task in tasks:
            result, error = work(task)
            yield result
            if error is not None:
                raise error
        return
    failure: Exception | None = None
    pending: dict[Future[Any], tuple[list[int], int]] = {}
    try:
        for task in tasks:
            pending[submit(work, task)] = (task, 0)
        while pending:
            ready, _ = wait(pending, return_when=FIRST_COMPLETED)
            for future in ready:
                task, tries = pending.pop(future)
                # `exception` would raise for a cancelled future.
                error = None if future.cancelled() else future.exception()
                if future.cancelled():
                    continue
                if error is None:
                    result, wrong = future.result()
                    yield result
                    failure = failure or wrong
                # A broken executor accepts no more tasks.
                elif failure is None and tries < retries and not isinstance(error, BrokenExecutor):
                    pending[submit(work, task)] = (task, tries + 1)
                else:
                    failure = failure or _lost(what, task, tries, error)
            if failure is not None:
                # Running tasks cannot be cancelled: wait for their results, which are kept.
                for future in pending:
                    future.cancel()
                pending = {f: task for f, task in pending.items() if not f.cancelled()}
        if failure is not None:
            raise failure
    finally:
        for future in pending:
            future.cancel()


def _lost(what: str, task: list[int], tries: int, error: BaseException) -> FabkitError:
    text = f"{what} {task[0]} to {task[-1]} failed {tries + 1} times: {error!r}"
    hint = "finished results are kept; run again with resume=True"
    problem = Problem(text, hint)
    lost = FabkitError(f"{text}\n  = help: {hint}", code="io", exit_code=4, problems=(problem,))
    lost.__cause__ = error
    return lost


@contextmanager
def submitter(executor: Any, retries: int) -> Generator[Submit]:
    """Yield the submit function of an executor, a Dask client, or a scheduler's address."""
    if isinstance(executor, str):
        with _client(executor) as client:
            yield client.get_executor(pure=False, retries=retries).submit
    elif executor is None:
        yield None
    elif hasattr(executor, "get_executor"):
        yield executor.get_executor(pure=False, retries=retries).submit
    elif hasattr(executor, "submit"):
        yield executor.submit
    else:
        hint = "give an executor of concurrent.futures, a Dask client, or a scheduler's address"
        raise invalid(f"{executor!r} is not an executor: it has no `submit`", hint)


def _client(address: str) -> Any:
    """Connect to a Dask scheduler."""
    try:
        from distributed import Client  # pyright: ignore
    except ImportError as error:
        message = f"Dask is needed to reach {address}"
        raise invalid(message, 'pip install "fabkit-cad[dask]"') from error
    try:
        return Client(address, timeout=_CONNECT_SECONDS)  # pyright: ignore
    except (OSError, ValueError) as error:
        text = f"there is no scheduler at {address}: {error}"
        raise FabkitError(text, code="io", exit_code=4) from error
