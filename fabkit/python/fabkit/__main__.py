"""The ``fabkit`` command, as ``python -m fabkit`` too."""

import os
import sys

from fabkit import _fabkit


def main() -> None:
    """Run the command with this process's arguments, and end the process with its exit code."""
    if {"bench", "sweep"} & set(sys.argv[1:]):
        # What learns is Python, and this one has it.
        os.environ.setdefault("FABKIT_PYTHON", sys.executable)
    sys.exit(_fabkit.command(["fabkit", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
