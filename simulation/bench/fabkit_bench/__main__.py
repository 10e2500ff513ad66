"""Command ``python -m fabkit_bench SENSOR -o DIR``: published and simulated figures in a table."""

from __future__ import annotations

import argparse
import json
import sys

from fabkit.designs import load
from fabkit.errors import FabkitError, invalid
from fabkit_bench._run import run


def main(arguments: list[str] | None = None) -> int:
    """Run the command and return its exit code: 0, or that of the error."""
    asked = _parser().parse_args(arguments)
    try:
        overrides = dict(_override(text) for text in asked.set)
        report = run(
            load(asked.sensor, overrides),
            quick=not asked.full,
            seed=asked.seed,
            rows=asked.rows or None,
            tell=None if asked.quiet else _tell,
        )
        written = [] if asked.output is None else report.save(asked.output)
    except FabkitError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    if asked.json:
        print(json.dumps(report.document(), indent=2))
    else:
        print(report.text())
        for path in written:
            print(f"wrote {path}")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m fabkit_bench",
        description="Run a paper's experiment in simulation, and print its table beside that.",
    )
    parser.add_argument("sensor", help="a built-in sensor, or a YAML file")
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--quick", action="store_true", help="minutes; what is done without --full")
    size.add_argument("--full", action="store_true", help="larger counts; up to hours")
    parser.add_argument("--seed", type=int, default=0, help="of places, noise and models")
    parser.add_argument(
        "-o", "--output", metavar="DIR", help="write bench.json, bench.html and networks/"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("--quiet", action="store_true", help="say nothing on the way")
    parser.add_argument(
        "--rows", action="append", default=[], metavar="EXPERIMENT", help="only this; repeatable"
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="PATH=VALUE", help="change a parameter"
    )
    return parser


def _override(text: str) -> tuple[str, str]:
    path, equals, value = text.partition("=")
    if not equals or not path:
        hint = "write it like `--set translucent_gel.thickness=1.2mm`"
        raise invalid(f"`{text}` is not of the form PATH=VALUE", hint)
    return path, value


def _tell(what: str) -> None:
    print(what, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
