"""Command `python -m fabkit_verify check FOLDER`: prints one JSON document on standard output.

Exit codes: 0 everything agrees, 1 something does not, 2 the folder or the arguments cannot be used.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path

from . import __version__
from .job import KERNELS, jobs
from .workers import Limits, run_all

BAD_INPUT = 2


def main() -> int:
    """Runs the command that the command line names, and returns its exit code."""
    parser = argparse.ArgumentParser(prog="fabkit_verify", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    check = commands.add_parser("check", help="rebuild and compare what was exported")
    check.add_argument("folder", type=Path, help="with trees, samples, STL files and manifest")
    check.add_argument("--kernel", action="append", choices=KERNELS, help="only this one")
    check.add_argument("--limit", type=float, default=600.0, help="seconds for one part and kernel")
    check.add_argument("--processes", type=int, default=2, help="how many at once")
    check.add_argument("--report", type=Path, help="an HTML file to write")
    step = commands.add_parser("step", help="write STEP files of what was exported")
    step.add_argument("folder", type=Path, help="with trees")
    step.add_argument("output", type=Path, help="folder for the STEP files")
    step.add_argument("--part", action="append", default=[], help="only this; may be repeated")
    step.add_argument("--assembly", help="name of a file with everything in its place")
    step.add_argument("--limit", type=float, default=600.0, help="seconds for one file")
    step.add_argument("--processes", type=int, default=2, help="how many at once")
    commands.add_parser("versions", help="which kernels there are")
    arguments = parser.parse_args()
    match arguments.command:
        case "check":
            return _check(arguments)
        case "step":
            return _step(arguments)
        case _:
            return _versions()


def _parts(folder: Path) -> list[str]:
    """Lists the bodies whose tree documents a folder contains."""
    suffix = ".tree.json"
    return sorted(path.name.removesuffix(suffix) for path in folder.glob(f"*{suffix}"))


def _complain(message: str) -> int:
    print(f"fabkit_verify: {message}", file=sys.stderr)
    return BAD_INPUT


def _progress(count: int, name: Callable[[dict], str]) -> Callable[[dict], None]:
    """Returns a function that reports progress on standard error, for the program that started this
    one."""
    done = 0

    def finished(answer: dict) -> None:
        nonlocal done
        done += 1
        print(f"fabkit-progress {done} {count} {name(answer)}", file=sys.stderr, flush=True)

    return finished


def _check(arguments: argparse.Namespace) -> int:
    parts = _parts(arguments.folder)
    if not parts:
        return _complain(f"{arguments.folder} holds no tree documents")
    kernels = [k for k in KERNELS if not arguments.kernel or k in arguments.kernel]
    todo = jobs(arguments.folder, parts, kernels)
    # Largest first: otherwise one process may still work on a long job when the others are done.
    largest = {part: -(arguments.folder / f"{part}.tree.json").stat().st_size for part in parts}
    order = sorted(todo, key=lambda job: largest[job.part])
    finished = _progress(len(order), lambda answer: f"{answer['part']} in {answer['kernel']}")
    answers = run_all(order, Limits(arguments.limit, arguments.processes), finished)
    by_job = dict(zip(order, answers))
    results = [by_job[job] for job in todo]
    document = {
        "format": "fabkit-verification",
        "version": 1,
        "fabkit_verify": __version__,
        "kernels": kernels,
        "report_error": None,
        "passed": all(result["verdict"] == "agrees" for result in results),
        "results": results,
    }
    if arguments.report:
        from .report import write

        try:
            write(arguments.report, document, arguments.folder)
        except OSError as error:
            # The results are printed even if the report cannot be written.
            document["passed"] = False
            document["report_error"] = f"{arguments.report}: {error.strerror}"
    print(json.dumps(document))
    return 0 if document["passed"] else 1


def _step(arguments: argparse.Namespace) -> int:
    from .step import StepJob

    folder, output = arguments.folder.resolve(), arguments.output.resolve()
    todo = [StepJob(folder, output, part) for part in arguments.part or _parts(folder)]
    if arguments.assembly:
        todo.insert(0, StepJob(folder, output, arguments.assembly, assembly=True))
    limits = Limits(arguments.limit, arguments.processes)
    finished = _progress(len(todo), lambda answer: answer["name"])
    files = run_all(todo, limits, finished)
    passed = all(file["passed"] for file in files)
    print(json.dumps({"format": "fabkit-step", "version": 1, "passed": passed, "files": files}))
    return 0 if passed else 1


def _versions() -> int:
    from importlib.metadata import version

    for kernel in KERNELS:
        __import__(kernel)
    packages = [*KERNELS, "cadquery-ocp", "gmsh"]
    print(json.dumps({package: version(package) for package in packages}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
