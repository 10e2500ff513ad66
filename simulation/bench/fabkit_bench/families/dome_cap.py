"""Experiments of ShadowTac: force from displacement, margin to slip, height under markers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit import sim
from fabkit.errors import FabkitError
from fabkit_bench import _models, _occlusion
from fabkit_bench._bench import Family
from fabkit_bench._networks import Card, HeldOut, Numbers
from fabkit_bench._places import places
from fabkit_bench._report import Row

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from fabkit_bench._bench import Bench


@dataclass(frozen=True)
class Size:
    """Numbers of presses and sizes of training."""

    size_px: tuple[int, int] = (96, 60)
    """Image size where images are not used: markers are tracked without error."""
    spacing_mm: float = 0.9
    normal_steps: int = 20
    lateral_steps: int = 14
    trial_steps: int = 12
    """Number of steps of each slip trial."""
    trials: int = 14
    epochs: int = 150
    presses: int = 24
    """Number of presses that are imaged with opaque markers and without."""
    picture_px: tuple[int, int] = (480, 300)
    picture_spacing_mm: float = 0.7


# Coefficients of friction, as the paper states them.
_DRY, _WET = 0.35, 0.25
# The paper's fourteen trials: shape, diameter in mm, depth in mm, friction. It holds out the last.
_TRIALS = (
    ("cylinder", 40.0, 1.0, _DRY),
    ("cylinder", 40.0, 2.0, _DRY),
    ("cylinder", 40.0, 3.0, _DRY),
    ("cylinder", 40.0, 2.0, _WET),
    ("cylinder", 40.0, 3.0, _WET),
    ("sphere", 50.0, 2.0, _DRY),
    ("sphere", 50.0, 4.0, _DRY),
    ("sphere", 50.0, 3.0, _WET),
    ("sphere", 20.0, 2.0, _DRY),
    ("sphere", 20.0, 3.0, _DRY),
    ("sphere", 20.0, 4.0, _DRY),
    ("sphere", 20.0, 3.0, _WET),
    ("sphere", 20.0, 4.0, _WET),
    ("sphere", 50.0, 3.0, _DRY),
)
# Length of the cylinder.
_LENGTH_MM = 40.0
_DEEPEST_MM = 3.0
# Published mean error of the margin to slip.
_GAMMA = 0.014


def _sensor(bench: Bench) -> sim.Sensor:
    size: Size = bench.size
    return bench.once(
        "sensor", lambda: bench.sensor(size_px=size.size_px, spacing_mm=size.spacing_mm)
    )


def _body(bench: Bench, kind: str, diameter_mm: float, depth_mm: float) -> sim.Body:
    """Place a sphere, or a cylinder along y, ``depth_mm`` deep in the middle of the skin."""
    radius = diameter_mm / 2

    def top() -> float:
        drawn = places(_sensor(bench), bench.random("top"), 2000, margin_mm=0.0)
        return float(drawn.points_mm[:, 2].max())

    at_mm = bench.once("top", top) + radius - depth_mm
    if kind == "sphere":
        return sim.ball(radius).at(0.0, 0.0, at_mm)
    pose = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, at_mm], [0, 0, 0, 1]], dtype=float)
    return sim.cylinder(radius, _LENGTH_MM).placed(pose)


def _fit(force_n: NDArray[Any], moved_mm: NDArray[Any]) -> tuple[float, float, float]:
    """Fit a line to displacement by force.

    Returns R2, the mean absolute error, mm, and that of the mean displacement as a guess, mm.
    """
    slope, offset = np.polyfit(force_n, moved_mm, 1)
    left = moved_mm - (slope * force_n + offset)
    spread = moved_mm - moved_mm.mean()
    r2 = 1 - float((left**2).sum() / (spread**2).sum())
    return r2, float(np.abs(left).mean()), float(np.abs(spread).mean())


def _press_until_slip(
    sensor: sim.Sensor, body: sim.Body, friction: float, steps: int
) -> tuple[NDArray[np.float64], sim.Many]:
    """Press, then move along x until the whole contact slips.

    Returns the tangential motions, mm, and the result at each.
    """
    probe = sensor.press(body, shear_mm=(0.3, 0.0), friction=friction, seed=None)
    pressed, along = abs(float(probe.force_n[2])), abs(float(probe.force_n[0]))
    # A linear spring slips at friction times force; partial slip needs about twice the motion.
    farthest = 0.3 * friction * pressed / max(along, 1e-9) * 2.2
    ways = np.linspace(0.0, min(farthest, 8.0), steps)
    asked = [sim.Asked(body, (float(way), 0.0), friction, None) for way in ways]
    return ways, sensor.press_all(asked)


def _linear(bench: Bench) -> list[Row]:
    size: Size = bench.size
    sensor = _sensor(bench)
    bench.tell("  pressing a sphere of 20 mm")
    depths = np.linspace(_DEEPEST_MM / size.normal_steps, _DEEPEST_MM, size.normal_steps)
    asked = [
        sim.Asked(_body(bench, "sphere", 20.0, float(d)), friction=_DRY, seed=None) for d in depths
    ]
    many = sensor.press_all(asked)
    down = -np.nanmean(many.mark_displacement_mm[:, :, 2], axis=1)
    normal = _fit(-many.force_n[:, 2], down)
    ball = _body(bench, "sphere", 20.0, _DEEPEST_MM)
    ways, many = _press_until_slip(sensor, ball, _DRY, size.lateral_steps)
    along = np.nanmean(many.mark_displacement_mm[:, :, 0], axis=1)
    # Leave out full slip: there force and markers stay the same.
    tangential = np.abs(many.force_n[:, 0])
    held = tangential < 0.98 * tangential.max()
    share = tangential / (_DRY * np.abs(many.force_n[:, 2]))
    lateral = _fit(np.abs(many.force_n[held, 0]), along[held])
    bench.notes.append(
        f"the sphere of 20 mm, 3 mm deep, bears {100 * share.max():.0f} % of friction times the "
        f"axial force within {ways[-1]:.2f} mm along: the skin is round, so that its normal turns"
    )
    said = (
        "mean over all dimples, followed without error or force noise; one run (the paper has "
        "eight), at small strain; trivial guess: the mean displacement, of R2 0"
    )
    cases = (("normal", normal, 0.997, 1.4e-3, size.normal_steps),)
    cases += (("lateral", lateral, 0.988, 1.85e-2, int(held.sum())),)
    rows: list[Row] = []
    for name, (r2, error, blind), paper_r2, paper_mm, samples in cases:
        name = f"{name} displacement by force"
        rows.append(Row(f"{name}: R2 of a line", "", paper_r2, r2, 0.0, samples, said))
        rows.append(Row(f"{name}: mean error", "mm", paper_mm, error, blind, samples, said))
    return rows


@dataclass(frozen=True, eq=False)
class Frames:
    """Steps of slip trials, with five rotated copies of each."""

    features: NDArray[np.float64]
    """Displacement of each visible dimple, mm: n x 3 m."""
    margin: NDArray[np.float64]
    """Margin to slip, Gamma: 1 without shear, 0 at full slip: n."""
    trial: NDArray[np.int64]
    """Number of the trial: n."""
    dimples: list[str]
    """Names of the visible dimples: m."""


def _frames(bench: Bench) -> Frames:
    size: Size = bench.size
    sensor = _sensor(bench)
    at_rest = sensor.press(seed=None)
    width, height = size.size_px
    px = at_rest.mark_px
    seen = np.isfinite(px).all(axis=1)
    seen &= (px >= 0).all(axis=1) & (px[:, 0] < width) & (px[:, 1] < height)
    turned = [_turned(sensor.mark_place_mm[seen], 60.0 * k) for k in range(6)]
    features: list[NDArray[Any]] = []
    margins: list[NDArray[Any]] = []
    trials: list[int] = []
    # The last trial is the held-out one: keep it if only some trials are run.
    chosen = _TRIALS[-size.trials :]
    for number, (kind, diameter, depth, friction) in enumerate(chosen):
        bench.tell(f"  slip trial {number + 1} of {len(chosen)}: {kind} {diameter:g} mm")
        body = _body(bench, kind, diameter, depth)
        try:
            _, many = _press_until_slip(sensor, body, friction, size.trial_steps)
        except FabkitError as error:
            what = f"{kind} {diameter:g} mm, {depth:g} mm deep"
            bench.notes.append(f"slip trial left out, {what}: {str(error).splitlines()[0]}")
            continue
        moved = np.nan_to_num(many.mark_displacement_mm[:, seen])
        tangential = np.abs(many.force_n[:, 0])
        margin = 1 - tangential / tangential.max()
        for turn, order in turned:
            copy: NDArray[np.float64] = np.einsum("nmi,ji->nmj", moved, turn)
            features.append(copy[:, order].reshape(len(moved), -1))
            margins.append(margin)
            trials += [number] * len(moved)
    dimples = [name for name, is_seen in zip(sensor.mark_names, seen, strict=True) if is_seen]
    return Frames(np.concatenate(features), np.concatenate(margins), np.array(trials), dimples)


def _turned(
    place_mm: NDArray[np.float64], angle_deg: float
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Rotate dimples about the axis.

    Returns the rotation, (3, 3), and for each dimple the index of the rotated one nearest to it.
    """
    cos, sin = np.cos(np.deg2rad(angle_deg)), np.sin(np.deg2rad(angle_deg))
    turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    turned: NDArray[np.float64] = np.einsum("mi,ji->mj", place_mm, turn)
    apart = np.linalg.norm(place_mm[:, None] - turned[None], axis=2)
    return turn, apart.argmin(axis=1)


def _margin_errors(
    bench: Bench,
    split: str,
    frames: Frames,
    tests: list[NDArray[np.bool_]],
    among: NDArray[np.bool_],
) -> tuple[float, float, int]:
    """Compute mean absolute errors of Gamma over tests.

    Returns the error of a network, that of the training mean as a guess, and the number of samples.
    """
    size: Size = bench.size
    errors: list[NDArray[Any]] = []
    blind: list[NDArray[Any]] = []
    for test in tests:
        train = among & ~test
        components = _models.Components(60).fit(frames.features[train])
        network = _models.Network((256, 128, 32), seed=bench.seed, epochs=size.epochs, batch=32)
        network.fit(components(frames.features[train]), frames.margin[train])
        found = np.clip(network.predict(components(frames.features[test])), 0.0, 1.0)
        errors.append(np.abs(found - frames.margin[test]))
        blind.append(np.abs(frames.margin[train].mean() - frames.margin[test]))
        card = Card(
            takes=Numbers(
                "how each dimple has moved since rest, x, y and z, one dimple after the other",
                "mm",
                {"frame": "sensor"},
            ),
            gives=Numbers("margin to slip: 1 without shear, 0 where all slips", ""),
            mask={"dimples": frames.dimples},
            training=(int(train.sum()), "pictures of slip trials and copies turned by 60 degrees"),
            held_out=[
                HeldOut(
                    f"{split}, first test: mean error",
                    float(errors[-1].mean()),
                    "",
                    int(test.sum()),
                )
            ],
        )
        written = network.to_onnx(of=components, within=(0, 1))
        bench.keep(f"margin to slip, {split}", written, card)
    joined, guessed = np.concatenate(errors), np.concatenate(blind)
    return float(joined.mean()), float(guessed.mean()), len(joined)


def _slip(bench: Bench) -> list[Row]:
    frames = bench.once("frames", lambda: _frames(bench))
    last = frames.trial.max()
    held = frames.trial == last
    random = bench.random("slip split")
    is_test = (random.random(len(held)) < 0.2) & ~held
    numbers = [n for n in np.unique(frames.trial) if n != last]
    groups = np.array_split(random.permutation(numbers), min(4, len(numbers)))
    by_trial = [np.isin(frames.trial, group) for group in groups]
    everything = np.ones_like(held)
    said = (
        f"{bench.size.trial_steps} pictures of each of {last + 1} trials and six copies turned by "
        "60 degrees; displacements of dimples along 60 principal components, perceptron "
        "256-128-32, squared error (the paper: raw displacements, absolute error); no noise; "
        f"friction {_DRY} dry and {_WET} wet, as the paper says; trivial guess: the mean margin"
    )
    cases = {
        "split at random": ([is_test], ~held, _GAMMA, "; copies of one picture are in both parts"),
        "split by trial": (by_trial, ~held, None, "; no trial is in both parts"),
        "held-out trial": ([held], everything, _GAMMA, "; the sphere of 50 mm, 3 mm deep, dry"),
    }
    rows: list[Row] = []
    for name, (tests, among, paper, note) in cases.items():
        found, blind, samples = _margin_errors(bench, name, frames, tests, among)
        name = f"margin to slip, {name}: mean error"
        rows.append(Row(name, "", paper, found, blind, samples, said + note))
    return rows


def _r2(bench: Bench, way: str) -> float:
    rows = bench.once("lines", lambda: {row.name: row.simulated for row in _linear(bench)})
    return float(rows[f"{way} displacement by force: R2 of a line"] or 0.0)


def _slip_margin_mae(bench: Bench) -> float:
    frames = _frames(bench)
    everything = np.ones(len(frames.trial), dtype=bool)
    tests = [frames.trial == number for number in np.unique(frames.trial)]
    return _margin_errors(bench, "split by trial", frames, tests, everything)[0]


_EXPERIMENTS: dict[str, Callable[[Bench], list[Row]]] = {
    "linear": _linear,
    "slip": _slip,
    "occlusion": _occlusion.heights_lost,
}

FAMILY = Family(
    experiments=_EXPERIMENTS,
    figures={
        "normal_r2": lambda bench: _r2(bench, "normal"),
        "lateral_r2": lambda bench: _r2(bench, "lateral"),
        "slip_margin_mae": _slip_margin_mae,
    },
    quick=Size(),
    full=Size(spacing_mm=0.6, normal_steps=60, lateral_steps=40, trial_steps=40, epochs=400),
    small=Size(spacing_mm=1.4, normal_steps=8, lateral_steps=6, trials=6, trial_steps=5, epochs=80),
    choices=(
        "Gamma is measured against the largest tangential force of each trial, which goes 2.2 "
        "times as far as a spring of its stiffness would until it slips",
        "the cylinder lies along y and is moved along x; the paper does not say how",
        *_occlusion.CHOICES,
    ),
    left_out=(
        "what the camera makes of dimples: displacements are those of the layers, without error",
    ),
    plain=frozenset({"linear", "occlusion"}),
)
