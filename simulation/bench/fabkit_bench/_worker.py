"""Rows of a sweep for ``fabkit sweep``: the source of a plan on the first line, then numbers.

Each line is answered by one line of JSON: ``version``, then ``row`` each time; ``missing`` or
``error`` where something is wrong.
"""

from __future__ import annotations

import json
import os
import signal
import sys

from fabkit import _fabkit
from fabkit.errors import FabkitError
from fabkit.sweep import Plan
from fabkit_bench import _learn


def main() -> None:
    """Answer lines until there are no more."""
    # An interrupted sweep shall not end in a traceback for each thread.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # What a library prints is no answer.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)

    def answer(**what: str) -> None:
        print(json.dumps(what), file=answers, flush=True)

    try:
        plan = Plan(_fabkit.SweepPlan.of_source(sys.stdin.readline()))
        try:
            _learn.needed()
        except FabkitError as error:
            return answer(missing=str(error).splitlines()[0])
        answer(version=_fabkit.__version__)
        for line in sys.stdin:
            answer(row=plan.line(int(line)))
    except Exception as error:
        answer(error=f"{type(error).__name__}: {error}".splitlines()[0])
