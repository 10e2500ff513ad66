"""Processes that may crash or hang without taking the others with them.

A process is used for many jobs, because OpenCascade takes seconds to load, and replaced when it dies
or is killed: what it was doing is then known, and everything else goes on.
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
    """Something that can be sent to another process and done there; hashable."""

    def run(self) -> dict[str, Any]:
        """The answer."""
        ...

    def failed(self, reason: str, seconds: float) -> dict[str, Any]:
        """The answer in its place, if the process dies or takes too long."""
        ...


_CONTEXT = multiprocessing.get_context("spawn")


def _serve(pipe: connection.Connection) -> None:
    # Standard output carries one JSON document; kernels print to it as they like.
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
    """How long one job may take, and how many run at once."""

    seconds: float
    processes: int


def run_all(
    jobs: list[Job], limits: Limits, finished: Callable[[dict[str, Any]], None]
) -> list[dict[str, Any]]:
    """All answers in the order of `jobs`; `finished` is told each as it comes."""
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
