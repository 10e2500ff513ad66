"""The report of a bench: a table as JSON, as text and as an HTML page."""

from __future__ import annotations

import html
import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fabkit import _fabkit
from fabkit_bench._networks import Network, digest, files, remove_stale

if TYPE_CHECKING:
    from os import PathLike

__all__ = ["Report", "Row"]


@dataclass(frozen=True)
class Row:
    """One figure of an experiment, published and simulated."""

    name: str
    """Measured quantity, in words."""
    unit: str
    """Unit, for example ``mm``; empty for ratios."""
    paper: float | None
    """Published value; ``None`` if there is none."""
    simulated: float | None
    """Simulated value; ``None`` if it could not be simulated: the note says why."""
    baseline: float | None
    """Score of a trivial guess that uses no image."""
    samples: int
    """Number of presses behind the simulated value."""
    note: str
    """Differences from the paper, and choices."""
    experiment: str = ""
    """Name of the experiment."""


@dataclass(frozen=True)
class Report:
    """Published and simulated figures of a sensor."""

    sensor: str
    """Name of the design."""
    title: str
    """Title of the design."""
    reference: str
    """Publication of the experiments."""
    design_hash: str
    """BLAKE3 hash over fabkit's version and all parameters of the design."""
    seed: int
    """Seed of press positions, noise and models."""
    quick: bool
    """True for small sizes, false for those nearer to the paper's."""
    rows: list[Row]
    """Rows of the table."""
    choices: list[str]
    """Choices that the paper does not state or that differ from it, in words."""
    constants: list[dict[str, Any]]
    """Constants of the simulated images, with sources."""
    left_out: list[str]
    """Effects that are not simulated, and experiments of the paper that are not run."""
    seconds: float = 0.0
    """Duration of the run; the only value that differs between runs with one seed."""
    networks: dict[str, Network] = field(default_factory=dict[str, Network])
    """Trained networks by name."""

    def document(self) -> dict[str, Any]:
        """Return the content of ``bench.json``; except ``seconds``, the seed determines it."""
        return {
            "format": "fabkit-bench",
            "version": 1,
            "sensor": self.sensor,
            "title": self.title,
            "reference": self.reference,
            "design_hash": self.design_hash,
            "seed": self.seed,
            "quick": self.quick,
            "is_simulated": True,
            "rows": [asdict(row) for row in self.rows],
            "choices": list(self.choices),
            "constants": list(self.constants),
            "left_out": list(self.left_out),
            "networks": [
                {"name": name, "sha256": digest(network.onnx)}
                for name, network in self.networks.items()
            ],
            "seconds": round(self.seconds, 1),
        }

    def text(self) -> str:
        """Return the table as text for a terminal."""
        head = ("what", "unit", "paper", "simulated", "trivial", "samples")
        lines = [f"{self.title}: simulated, seed {self.seed}, {self._how()}"]
        for experiment, rows in self._groups():
            cells = [_cells(row) for row in rows]
            widths = [max(len(line[k]) for line in [head, *cells]) for k in range(len(head))]
            lines += ["", experiment, _line(head, widths)]
            lines += [_line(line, widths) for line in cells]
            notes = dict.fromkeys(row.note for row in rows if row.note)
            lines += [f"  - {note}" for note in notes]
        return "\n".join(lines)

    def html(self) -> str:
        """Return the report as one HTML page that works offline, in light or dark colours."""
        parts: list[str] = []
        for experiment, rows in self._groups():
            head = "".join(f"<th scope='col'>{word}</th>" for word in _HEAD)
            body = "".join(_html_row(row) for row in rows)
            parts.append(
                f"<h2>{_e(experiment)}</h2><table><thead><tr>{head}</tr></thead>"
                f"<tbody>{body}</tbody></table>"
            )
        parts += [
            _html_list("Trained networks", [_network(*one) for one in self.networks.items()]),
            _html_list("What was chosen", self.choices),
            _html_list("What is left out", self.left_out),
            _html_list("What pictures rest on", [_constant(one) for one in self.constants]),
        ]
        title = f"{self.sensor}: the paper and its simulation"
        return (
            f"<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'><title>{_e(title)}</title>"
            "<meta name='viewport' content='width=device-width, initial-scale=1'>"
            f"<style>{_STYLE}</style></head><body><main><h1>{_e(title)}</h1>"
            f"<p>{_e(self.title)}. {_e(self.reference)}.</p>"
            f"<p><strong>Simulated.</strong> Seed {self.seed}, {self._how()}, design "
            f"<code>{_e(self.design_hash[:16])}</code>, {self.seconds:.0f} s.</p>"
            f"{''.join(parts)}</main></body></html>\n"
        )

    def save(self, folder: str | PathLike[str]) -> list[Path]:
        """Write ``bench.json``, ``bench.html`` and ``networks/`` into a folder; return the paths.

        All files are replaced together or not at all; files that fabkit did not write stay.
        Networks and cards of an earlier run are removed afterwards.

        Raises
        ------
        FabkitError
            The folder cannot be written to, or holds a file of that name that fabkit did not write.
        """
        folder = Path(folder)
        contents = files(self.networks)
        contents["bench.html"] = self.html().encode()
        contents["bench.json"] = (json.dumps(self.document(), indent=2) + "\n").encode()
        # All files or none, and none that somebody else wrote.
        _fabkit.write_folder(str(folder), list(contents.items()))
        remove_stale(folder, self.networks)
        return [folder / name for name in contents]

    def _how(self) -> str:
        return "quick" if self.quick else "full"

    def _groups(self) -> list[tuple[str, list[Row]]]:
        names = dict.fromkeys(row.experiment for row in self.rows)
        return [(name, [row for row in self.rows if row.experiment == name]) for name in names]


def _number(value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"


def _cells(row: Row) -> tuple[str, ...]:
    figures = [_number(value) for value in (row.paper, row.simulated, row.baseline)]
    return (row.name, row.unit, *figures, str(row.samples))


def _line(cells: tuple[str, ...], widths: list[int]) -> str:
    # The first two columns are words, the others numbers.
    placed = [
        cell.ljust(width) if k < 2 else cell.rjust(width)
        for k, (cell, width) in enumerate(zip(cells, widths, strict=True))
    ]
    return "  ".join(placed).rstrip()


_HEAD = ("what", "unit", "paper", "simulated", "trivial guess", "samples", "note")


def _e(text: str) -> str:
    return html.escape(text, quote=True)


def _html_row(row: Row) -> str:
    cells = [*_cells(row), row.note]
    kinds = ["what", "unit", *["figure"] * 4, "note"]
    # Narrow screens show a row as a card, where each cell needs its column's name.
    return (
        "<tr>"
        + "".join(
            f"<td class='{kind}' data-of='{head}'>{_e(cell)}</td>"
            for kind, head, cell in zip(kinds, _HEAD, cells, strict=True)
        )
        + "</tr>"
    )


def _html_list(title: str, items: list[str]) -> str:
    if not items:
        return ""
    return f"<h2>{_e(title)}</h2><ul>{''.join(f'<li>{_e(item)}</li>' for item in items)}</ul>"


def _network(name: str, network: Network) -> str:
    held_out = [
        f"{one['what']} {_number(one['value'])} {one['unit']}".rstrip() + f" ({one['samples']})"
        for one in network.card["held_out"]
    ]
    return f"{name}: {network.card['form']}. Held out: {'; '.join(held_out)}"


def _constant(constant: dict[str, Any]) -> str:
    value = constant["value"]
    shown = _number(value) if isinstance(value, int | float) else json.dumps(value)
    return f"{constant['name']} {shown}, {constant['known']}: {constant['source']}"


_STYLE = """
:root { color-scheme: light dark; --ink: #1c1c1e; --ground: #fff; --soft: #6a6a70; --rule: #d9d9de }
@media (prefers-color-scheme: dark) {
  :root { --ink: #ececf0; --ground: #17171a; --soft: #a2a2aa; --rule: #3a3a40 }
}
body { margin: 0; color: var(--ink); background: var(--ground) }
body { font: 16px/1.5 system-ui, sans-serif }
main { max-width: 72rem; margin: 0 auto; padding: 1.5rem }
table { border-collapse: collapse; width: 100% }
th, td { padding: .35rem .6rem; border-bottom: 1px solid var(--rule); vertical-align: top }
th { text-align: left; color: var(--soft); font-weight: 600 }
th:nth-child(n+3):nth-child(-n+6) { text-align: right }
.figure { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap }
.note { color: var(--soft); font-size: .875rem; max-width: 34rem }
li { margin: .2rem 0 }
@media (max-width: 46rem) {
  thead { display: none }
  table, tbody, tr, td { display: block }
  tr { border-bottom: 1px solid var(--rule); padding: .6rem 0 }
  td, td.figure { border: 0; padding: .1rem 0; text-align: left; white-space: normal }
  td.what { font-weight: 600 }
  td:not(.what)::before { content: attr(data-of) ": "; color: var(--soft) }
}
@media print {
  :root { --ink: #000; --ground: #fff; --soft: #444; --rule: #bbb }
  main { padding: 0; max-width: none }
  body { font-size: 10pt }
  tr { break-inside: avoid }
}
"""
