"""Command ``python -m fabkit_bench.network SENSOR -o FILE.onnx``: trains a small depth network.

It is for sensors whose light shows thickness and that have semi-domes (R-Tac0). The network learns
from simulated captures of the camera's size: of most semi-domes, pins, balls and hemispheres; the
other semi-domes are held out. ``fabkit reconstruct --network FILE.onnx`` evaluates it. Training is
seeded and uses one thread of numpy.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit import sim
from fabkit.designs import load
from fabkit.errors import FabkitError, invalid
from fabkit_bench._models import one_thread
from fabkit_bench._onnx import chain
from fabkit_bench._small import PAPER, RATE, SMALL, Small

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

    from fabkit.designs import Sensor as Design

__all__ = ["Maps", "card", "main", "maps", "presses", "train"]

# Image preparation of R-Tac0's authors, except that images of another brightness are scaled first.
INPUT = {
    "blur_px": 5,
    "blur_sigma_px": 5.0,
    "as_bright_as_rest": True,
    "offset_grey": 3.0,
    "maximum_grey": 47.0,
}
# Indentation of the network's output 1, mm; deeper targets are clipped.
OUTPUT_MM = 2.0
_AT_ONCE = 8


@dataclass(frozen=True, eq=False)
class Maps:
    """Input and ground truth of a network for one press."""

    darkness: NDArray[np.float32]
    """Network input, 0 to 1, 0 where nothing touches: rows x columns."""
    depth_mm: NDArray[np.float32]
    """True indentation, 0 to 2 mm; 0 where no surface is seen."""
    contact: NDArray[np.bool_]
    """True where the pixel sees the contact with an indenter."""
    image: NDArray[np.uint8]
    """Capture."""


def presses(design: Design, seed: int) -> tuple[list[str], list[str]]:
    """Draw training presses, and held-out ones: a fifth of the semi-domes."""
    random = np.random.default_rng(seed)
    known = sorted(design.presses)
    domes = [name for name in known if name.startswith("semi-dome-")]
    if not domes:
        raise invalid(f"{design.name} has no semi-domes to learn from")
    domes = [domes[int(k)] for k in random.permutation(len(domes))]
    turned = [[name + turn for turn in ("", "-flipped")] for name in domes]
    held_out, others = turned[: len(turned) // 5], turned[len(turned) // 5 :]
    learned = [name for pair in others for name in pair]
    learned += [name for name in known if name.startswith("pin-") and name.endswith("-long")]
    for kind in ("ball", "hemisphere"):
        for _ in range(30):
            angle, around, depth = random.uniform([0, 0, 0.3], [60, 360, 1.5])
            learned.append(f"{kind}@{angle:.2f}deg,{around:.2f}deg,{depth:.3f}mm")
    return learned, [name for pair in held_out for name in pair]


def maps(sensor: sim.Sensor, names: list[str], rest: sim.Felt, seed: int) -> Iterator[Maps]:
    """Simulate presses by name and prepare their images as network inputs."""
    with tempfile.TemporaryDirectory() as folder:
        # A network that returns its input: `reconstruct` then prepares images as for real ones.
        file = Path(folder) / "same.onnx"
        file.write_bytes(chain([]))
        file.with_suffix(".json").write_text(json.dumps({**card(None, rest), "output_mm": 1.0}))
        for start in range(0, len(names), _AT_ONCE):
            some = names[start : start + _AT_ONCE]
            asked = [sim.Asked(name, seed=seed + start + k) for k, name in enumerate(some)]
            many = sensor.press_all(asked)
            darkness, _ = sensor.reconstruct(many.image, rest.image, network=file)
            depth_mm = np.nan_to_num(many.depth_mm).clip(0, OUTPUT_MM).astype(np.float32)
            for k in range(len(some)):
                yield Maps(darkness[k], depth_mm[k], many.contact[k], many.image[k])


def _squares(
    seen: Maps, side: int, count: int, random: np.random.Generator
) -> tuple[NDArray[np.float16], NDArray[np.float32]]:
    """Draw pixels with contact; return the squares around them and their indentation."""
    reach = side // 2
    windows: NDArray[Any] = np.lib.stride_tricks.sliding_window_view(
        np.pad(seen.darkness, reach), (side, side)
    )
    places = np.flatnonzero(seen.darkness)
    places = random.choice(places, size=min(count, len(places)), replace=False)
    row, column = np.unravel_index(np.sort(places), seen.darkness.shape)
    return windows[row, column].astype(np.float16), seen.depth_mm[row, column] / OUTPUT_MM


def train(
    design: Design,
    *,
    seed: int = 0,
    pixels: int = 1500,
    epochs: int = 36,
    rate: float = RATE,
    is_paper: bool = False,
    tell: Callable[[str], None] | None = None,
) -> tuple[Small, dict[str, Any]]:
    """Train a network and measure its errors on held-out presses.

    Parameters
    ----------
    design
        A sensor with semi-domes.
    seed
        Seed of patterns, noise, pixels and initial weights.
    pixels
        Number of training pixels of each press.
    epochs
        Number of epochs.
    rate
        Initial learning rate.
    is_paper
        Use the form of R-Tac0's published network, with 413,057 weights, instead of the small one.
    tell
        Function that is called with a text at each stage.

    Returns
    -------
    The network, and its card with input, output and errors.
    """
    tell = tell or (lambda _: None)
    form = PAPER if is_paper else SMALL
    random = np.random.default_rng([seed, 1])
    learned, held_out = presses(design, seed)
    sensor = sim.Sensor(design, spacing_mm=0.3)
    rest = sensor.press(seed=seed)
    tell(f"pressing {len(learned)} times")
    drawn = [
        _squares(one, form.side_px, pixels, random)
        for one in maps(sensor, learned, rest, 1000 + seed)
        if one.darkness.any()
    ]
    squares = np.concatenate([one[0] for one in drawn])
    targets = np.concatenate([one[1] for one in drawn])
    tell(f"learning from {len(targets)} pixels")
    network = Small(form, seed)
    with one_thread():
        network.fit(squares, targets, epochs=epochs, rate=rate, tell=tell)
    words = f"{len(learned)} simulated presses, {len(targets)} pixels: semi-domes, pins, balls"
    about = card(design, rest) | {"training": f"{words}; seed {seed}, {epochs} epochs"}
    tell("trying what was held out")
    with tempfile.TemporaryDirectory() as folder:
        file = _save(Path(folder) / "network.onnx", network, about)
        scores: list[list[float]] = []
        for one in maps(sensor, held_out, rest, 5000 + seed):
            depth_mm, touched = sensor.reconstruct(one.image, rest.image, network=file)
            error = np.abs(depth_mm - one.depth_mm)
            scores.append([float(error[touched].mean()), float(error[one.contact].mean())])
        l1_touched, l1_contact = np.mean(scores, axis=0)
    about["held_out"] = {
        "presses": f"{len(held_out)} of semi-domes that it has not seen, simulated",
        "l1_touched_mm": round(float(l1_touched), 4),
        "l1_contact_mm": round(float(l1_contact), 4),
    }
    return network, about


def card(design: Design | None, rest: sim.Felt) -> dict[str, Any]:
    """Return a card with input and output of such networks; the mask is the visible surface."""
    about: dict[str, Any] = {"format": "fabkit-network-card", "version": 1}
    if design is not None:
        about |= {"sensor": design.name, "design_hash": design.design_hash}
    row, column = np.nonzero(np.isfinite(rest.depth_mm))
    away_px = np.hypot(row - row.mean(), column - column.mean())
    radius_px = float(np.ceil(away_px.max()))
    mask = {"center_px": None, "radius_px": radius_px}
    return about | {"input": INPUT, "output_mm": OUTPUT_MM, "mask": mask}


def _save(file: Path, network: Small, about: dict[str, Any]) -> Path:
    file.write_bytes(network.onnx())
    file.with_suffix(".json").write_text(json.dumps(about, indent=2) + "\n")
    return file


def main(arguments: list[str] | None = None) -> int:
    """Run the command and return its exit code: 0, or that of the error."""
    parser = argparse.ArgumentParser(
        prog="python -m fabkit_bench.network",
        description="Train a small depth network on simulated presses; write it with its card.",
    )
    parser.add_argument("sensor", help="a built-in sensor, or a YAML file")
    parser.add_argument("-o", "--output", required=True, metavar="FILE.onnx")
    parser.add_argument("--seed", type=int, default=0, help="of patterns, noise and numbers")
    parser.add_argument("--pixels", type=int, default=1500, help="to learn from, of each press")
    parser.add_argument("--epochs", type=int, default=36, help="how often each is looked at")
    parser.add_argument("--rate", type=float, default=RATE, help="how fast it learns at first")
    parser.add_argument("--paper", action="store_true", help="in the form of the published one")
    asked = parser.parse_args(arguments)
    try:
        network, about = train(
            load(asked.sensor),
            seed=asked.seed,
            pixels=asked.pixels,
            epochs=asked.epochs,
            rate=asked.rate,
            is_paper=asked.paper,
            tell=lambda what: print(what, file=sys.stderr, flush=True),
        )
        file = _save(Path(asked.output), network, about)
    except FabkitError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    print(json.dumps(about["held_out"], indent=2))
    print(f"wrote {file} and {file.with_suffix('.json')}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
