"""Worker processes that may crash or hang without affecting other jobs.

A process runs many jobs, because OpenCascade takes seconds to load. When it dies or is killed, its
current job counts as failed, and a new process runs the remaining ones.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing import connection
from typing import Any, Protocol



class Job(Protocol):
    """A job that can be pickled, sent to another process and run there; hashable."""

    def run(self) -> dict[str, Any]:
        """Runs the job and returns its result."""
        ...

    def failed(self, reason: str, seconds: float) -> dict[str, Any]:
        """Returns the result if the process dies or takes too long."""
        ...


# Spawn, not fork: each process starts with a fresh interpreter.
_CONTEXT = multiprocessing.get_context("spawn")


def _serve(pipe: connection.Connection) -> None:
    """Runs jobs from the pipe until it is closed."""
    # Standard output carries one JSON document; what kernels print goes to standard error.
    os.dup2(2, 1)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    while True:
        try:
            job = pipe.recv()
        except EOFError:
            return
        pipe.send(job.run())


class _Worker:
    def __init__(self) -> None:
        self.pipe, other = _CONTEXT.Pipe()
        self.process = _CONTEXT.Process(target=_serve, args=(other,), daemon=True)
        self.process.start()
        other.close()
        self.job: Job | None = None
        self.started = 0.0

    def give(self, job: Job) -> None:
        self.job, self.started = job, time.monotonic()
        self.pipe.send(job)

    def end(self) -> None:
        self.pipe.close()
        self.process.kill()
        self.process.join()


@dataclass(frozen=True)
class Limits:
    """Time limit of one job, and number of jobs that run at once."""

    seconds: float
    processes: int


def run_all(
    jobs: list[Job], limits: Limits, finished: Callable[[dict[str, Any]], None]
) -> list[dict[str, Any]]:
    """Runs all jobs and returns their results in order; calls `finished` with each as it comes."""
    answers: dict[Job, dict[str, Any]] = {}
    waiting = list(reversed(jobs))
    workers: list[_Worker] = []

    def record(worker: _Worker, answer: dict[str, Any]) -> None:
        answers[worker.job] = answer
        worker.job = None
        finished(answer)

    try:
        while len(answers) < len(jobs):
            busy = [worker for worker in workers if worker.job]
            idle = [worker for worker in workers if not worker.job]
            while waiting and len(busy) < limits.processes:
                worker = idle.pop() if idle else _Worker()
                if worker not in workers:
                    workers.append(worker)
                worker.give(waiting.pop())
                busy.append(worker)
            next_limit = min(worker.started for worker in busy) + limits.seconds
            patience = max(0.0, next_limit - time.monotonic())
            ready = connection.wait([worker.pipe for worker in busy], timeout=patience)
            for worker in busy:
                seconds = time.monotonic() - worker.started
                if worker.pipe in ready:
                    try:
                        record(worker, worker.pipe.recv())
                        continue
                    except (EOFError, ConnectionError):
                        worker.process.join()
                        reason = f"the process {_how_it_ended(worker.process.exitcode)}"
                elif seconds >= limits.seconds:
                    reason = f"took longer than {limits.seconds:g} s and was stopped"
                else:
                    continue
                record(worker, worker.job.failed(reason, seconds))
                worker.end()
                workers.remove(worker)
    finally:
        for worker in workers:
            worker.end()
    return [answers[job] for job in jobs]


def _how_it_ended(code: int | None) -> str:
    if code is not None and code < 0:
        return f"crashed ({signal.Signals(-code).name})"
    return f"ended with exit code {code}"
