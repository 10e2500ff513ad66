"""The ``fabkit`` command; ``python -m fabkit`` runs it too."""

import os
import sys

from fabkit import _fabkit


def main() -> None:
    """Run the command with this process's arguments and exit with its exit code."""
    if {"bench", "sweep"} & set(sys.argv[1:]):
        # The command starts a Python that trains networks; this interpreter has the packages.
        os.environ.setdefault("FABKIT_PYTHON", sys.executable)
    sys.exit(_fabkit.command(["fabkit", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
