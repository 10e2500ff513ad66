"""A worker process that computes rows of a sweep for ``fabkit sweep``.

It reads the source of a plan on the first line of standard input, then numbers of variants. It
answers each line with one line of JSON: ``version``, then ``row`` for each number; ``missing`` if
scikit-learn is missing, or ``error``.
"""

from __future__ import annotations

import json
import os
import signal
import sys

from fabkit import _fabkit
from fabkit.errors import FabkitError
from fabkit.sweep import Plan
from fabkit_bench import _models


def main() -> None:
    """Answer lines of standard input until its end."""
    # Without Python's handler Ctrl-C ends the process without a traceback.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # Text that a library prints must not reach the answers: standard output becomes standard error.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)

    def answer(**what: str) -> None:
        print(json.dumps(what), file=answers, flush=True)

    try:
        plan = Plan(_fabkit.SweepPlan.of_source(sys.stdin.readline()))
        try:
            _models.require()
        except FabkitError as error:
            return answer(missing=str(error).splitlines()[0])
        answer(version=_fabkit.__version__)
        for line in sys.stdin:
            answer(row=plan.line(int(line)))
    except Exception as error:
        answer(error=f"{type(error).__name__}: {error}".splitlines()[0])
