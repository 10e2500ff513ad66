"""Experiments of the fluidic sensor: markers below the skin, predicted from liquid columns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit import sim
from fabkit.errors import FabkitError, invalid
from fabkit_bench import _models, _torch_networks
from fabkit_bench._bench import Family, first_line
from fabkit_bench._networks import Card, HeldOut, Numbers
from fabkit_bench._report import Row
from fabkit_bench._similarity import Code, draw_discs, ssim
from fabkit_bench.families.half_ellipsoid import folds

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from fabkit_bench._bench import Bench
    from fabkit_bench._onnx import OnnxNetwork


@dataclass(frozen=True)
class Size:
    """Numbers of presses and sizes of training."""

    places: int = 60
    depths: int = 8
    deepest_mm: float = 4.0
    reach_mm: float = 18.0
    """Half side of the square that contains the press positions."""
    spacing_mm: float = 2.0
    folds: int = 5
    network_folds: int = 3
    recurrent_epochs: int = 40
    """Epochs of the LSTM; 100 in the paper."""
    code_epochs: int = 60
    """Epochs of the autoencoder; 300 in the published losses."""


# From the published arrays: ridge regression from ten lags of columns to markers, last fifth.
_RIDGE_R2 = 0.48
_READ = "columns of the published series move 3 to 15 px, in pictures of another display"
# Published similarity (SSIM) of predicted images, and that of the constant mean image.
_SSIM = (0.9045, 0.8920)
# Side of the paper's images, and number of values in its encoder's code.
_PICTURE_PX, _CODE = 68, 324
# R2 of encoded features, predicted by the paper's LSTM from ten steps: from its published arrays.
_ENCODED_R2 = 0.230
_STEPS = 10
_DRAWN = Numbers(
    f"picture of markers, {_PICTURE_PX} rows of {_PICTURE_PX} pixels: white discs on black, cut to "
    "the markers and half a pitch around them",
    "share of white",
)
_NUMBERS = Numbers("what the autoencoder of this fold makes of such a picture", "")
_LSTM = "LSTM, three layers of 256, and linear sums of the last step"


@dataclass(frozen=True, eq=False)
class PressResults:
    """Results of n presses, one in each row."""

    column_mm: NDArray[np.float64]
    """Displacement of each liquid column, mm: n x channels."""
    column_px: NDArray[np.float64]
    """Displacement of each column's end in the display's image, from the mean: n x 2 channels."""
    marker_px: NDArray[np.float64]
    """Displacement of each marker in the image, from the mean: n x 2 m."""
    marker_at_px: NDArray[np.float64]
    """Mean position of each marker in the image: m x 2."""
    seen: dict[str, Any]
    """Names and mean positions of the columns and markers in these arrays, for cards."""
    place: NDArray[np.int64]
    """Number of the press position: n."""


def _press_results(bench: Bench) -> PressResults:
    size: Size = bench.size
    skin = sim.Skin(bench.design, spacing_mm=size.spacing_mm)
    random = bench.random("places")
    places = random.uniform(-size.reach_mm, size.reach_mm, (size.places, 2))
    depths = np.linspace(size.deepest_mm / size.depths, size.deepest_mm, size.depths)
    columns: list[NDArray[np.float64]] = []
    ends: list[NDArray[np.float64]] = []
    markers: list[NDArray[np.float64]] = []
    at: list[int] = []
    bench.tell(f"  pressing {size.places} places, {size.depths} times each")
    for number, (x, y) in enumerate(places):
        names = [f"hemisphere@{x:.2f}mm,{y:.2f}mm,{depth:.3f}mm" for depth in depths]
        try:
            many = skin.press_all(names)
        except FabkitError as error:
            bench.notes.append(f"place {x:.1f} mm, {y:.1f} mm left out: {first_line(error)}")
            continue
        columns.append(many.column_mm)
        ends.append(many.column_px)
        markers.append(many.mark_px)
        at += [number] * len(names)
    if not columns:
        raise invalid("no place of the skin could be pressed")
    ends_px, ends_at_px, which = _moved(np.concatenate(ends))
    seen: dict[str, Any] = {
        "channels": list(skin.column_names),
        "columns": [skin.column_names[k] for k in which],
        "columns_at_px": ends_at_px.round(3).tolist(),
    }
    markers_px, at_px, which = _moved(np.concatenate(markers))
    seen["markers"] = [skin.mark_names[k] for k in which]
    seen["markers_at_px"] = at_px.round(3).tolist()
    return PressResults(np.concatenate(columns), ends_px, markers_px, at_px, seen, np.array(at))


def _moved(
    pixels: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """Compute displacements from the mean position, of points that are seen in all n images.

    Returns displacements (n, 2 m), mean positions (m, 2), and indices of the points (m,).
    """
    is_seen = np.isfinite(pixels).all(axis=(0, 2))
    seen = pixels[:, is_seen]
    # The models have an offset, so the mean serves as well as the reference image.
    mean: NDArray[np.float64] = seen.mean(axis=0)
    return (seen - mean).reshape(len(seen), -1), mean, np.flatnonzero(is_seen)


def _keep(
    bench: Bench,
    name: str,
    written: OnnxNetwork,
    takes: Numbers,
    gives: Numbers,
    test: NDArray[np.bool_],
    error: tuple[str, float, str],
) -> None:
    what, value, unit = error
    held_out = HeldOut(f"{name}, first fold: {what}", value, unit, int(test.sum()))
    mask = "columns and markers that are seen in all presses, by their names"
    training = (int((~test).sum()), "presses at rest by a hemisphere")
    bench.keep(name, written, Card(takes, gives, mask, training, [held_out]))


def _columns_of(touches: PressResults, *, exact: bool = False, steps: bool = False) -> Numbers:
    """Describe the networks' input."""
    if exact:
        what = "how far the liquid of each channel moves in its tube"
        return Numbers(what, "mm", {"channels": touches.seen["channels"]})
    what = (
        "how far each column ends from where it ends in the mean picture, x and y, rounded to "
        "whole pixels; places are those of the mean picture"
    )
    if steps:
        what += f"; of {_STEPS} ever deeper presses at one place, of which the last is asked for"
    return Numbers(what, "px", {name: touches.seen[name] for name in ("columns", "columns_at_px")})


def _markers_of(touches: PressResults) -> Numbers:
    """Describe the networks' output."""
    what = (
        "how far each marker is from where it is in the mean picture of the camera below, x and y; "
        "places are those of the mean picture"
    )
    return Numbers(what, "px", {name: touches.seen[name] for name in ("markers", "markers_at_px")})


@dataclass(frozen=True)
class MarkerAccuracy:
    """Accuracy of predicted marker positions."""

    r2: float
    """R2 over all markers together: 0 for the mean."""
    rms_px: float
    blind_r2: float
    """R2 of the training mean as a guess: at most 0."""
    blind_px: float
    """Root mean square error of the training mean as a guess."""


def _marker_accuracy(
    bench: Bench, split: str, touches: PressResults, groups: NDArray[np.int64]
) -> MarkerAccuracy:
    size: Size = bench.size
    is_exact = split.endswith("exact columns")
    # An image shows a column's end to a pixel: the paper takes the first black pixel.
    columns = touches.column_mm if is_exact else np.round(touches.column_px)
    truth = touches.marker_px
    found, blind = np.zeros_like(truth), np.zeros_like(truth)
    for test in folds(groups, size.folds, bench.random("folds")):
        ridge = _models.Ridge().fit(columns[~test], truth[~test])
        found[test] = ridge.predict(columns[test])
        blind[test] = truth[~test].mean(axis=0)
        takes, gives = _columns_of(touches, exact=is_exact), _markers_of(touches)
        error = ("rms error", _rms(found[test], truth[test]), "px")
        _keep(bench, f"markers, {split}", ridge.to_onnx(), takes, gives, test, error)
    rms_px, blind_px = (_rms(one, truth) for one in (found, blind))
    return MarkerAccuracy(_r2(found, truth), rms_px, _r2(blind, truth), blind_px)


def _markers(bench: Bench) -> list[Row]:
    touches = bench.once("touches", lambda: _press_results(bench))
    count = len(touches.place)
    said = (
        "ridge from columns to markers, of presses at rest by a hemisphere; the paper: an LSTM on "
        "ten steps of a finger's strokes. From its published arrays a ridge on ten steps of raw "
        "pixels has R2 0.48; trivial guess: the mean picture"
    )
    apart = "no place is in training and test"
    shared = "the same place at another depth is in training"
    places, single = touches.place, np.arange(count)
    cases = {
        "split by place": (places, _RIDGE_R2, f"; columns to a pixel; {apart}"),
        "split at random": (single, None, f"; columns to a pixel; {shared}"),
        "split by place, exact columns": (places, None, f"; {apart}"),
    }
    rows: list[Row] = []
    for name, (groups, paper, note) in cases.items():
        found = _marker_accuracy(bench, name, touches, groups)
        figures = (paper, found.r2, found.blind_r2)
        rows.append(Row(f"markers from columns, {name}: R2", "", *figures, count, said + note))
        figures = (None, found.rms_px, found.blind_px)
        label = f"markers from columns, {name}: rms error"
        rows.append(Row(label, "px", *figures, count, said + note))
    return rows


def _amplitudes(bench: Bench) -> list[Row]:
    touches = bench.once("touches", lambda: _press_results(bench))
    pairs = touches.marker_px.reshape(len(touches.place), -1, 2)
    ways = np.linalg.norm(pairs - pairs[:: bench.size.depths].mean(axis=0), axis=2)
    note = (
        "from the mean of the shallowest presses; the paper's pictures are cut to 340 px with "
        "markers 34 px apart, and a finger's path and force are unknown"
    )
    columns_mm = np.abs(touches.column_mm).max(axis=1)
    ends = touches.column_px.reshape(len(touches.place), -1, 2)
    columns_px = float(np.linalg.norm(np.ptp(ends, axis=0), axis=1).max())
    count = len(ways)
    rows = [
        Row("largest way of a marker", "px", 18.0, float(ways.max()), None, count, note),
        Row("largest way of a column", "px", 15.0, columns_px, None, count, _READ),
    ]
    largest = float(np.median(columns_mm))
    name = "way of the column that moves most, median press"
    return [*rows, Row(name, "mm", None, largest, None, count, "the paper states no lengths")]


def _images(bench: Bench) -> list[Row]:
    """Measure the similarity of marker images that are predicted from columns via a linear code."""
    touches = bench.once("touches", lambda: _press_results(bench))
    pictures = _pictures(bench, touches)
    count = len(pictures)
    said = (
        f"pictures of {_PICTURE_PX} px are drawn from where markers are, without noise; instead of "
        f"the paper's autoencoder the {_CODE} principal components, or as many as there are "
        "pictures to learn from, and a ridge from columns to a pixel instead of its LSTM; decoded "
        "against decoded, as in the paper; trivial guess: the constant mean picture, which from "
        f"the published arrays reaches {_SSIM[1]}"
    )
    rows: list[Row] = []
    cases = {
        "split by place": (touches.place, _SSIM[0]),
        "split at random": (np.arange(count), None),
    }
    for name, (groups, paper) in cases.items():
        alike, blind, told = np.zeros(count), np.zeros(count), np.zeros(count)
        for test in folds(groups, bench.size.folds, bench.random("folds")):
            code = Code(pictures[~test], _CODE)
            numbers = code.encode(pictures)
            columns = np.round(touches.column_px)
            ridge = _models.Ridge().fit(columns[~test], numbers[~test])
            truth = code.decode(numbers[test])
            constant = np.broadcast_to(code.decode(np.zeros_like(numbers[:1])), truth.shape)
            alike[test] = ssim(code.decode(ridge.predict(columns[test])), truth)
            blind[test] = ssim(constant, truth)
            told[test] = ssim(truth, pictures[test])
            written, takes = ridge.to_onnx(into=code, within=(0, 1)), _columns_of(touches)
            error = ("SSIM to what the code keeps", float(alike[test].mean()), "")
            _keep(bench, f"images, {name}", written, takes, _DRAWN, test, error)
        label = f"likeness of predicted images, {name}: SSIM"
        note = f"{said}; the code itself keeps {told.mean():.3f} of the drawn pictures"
        figures = (paper, float(alike.mean()), float(blind.mean()))
        rows.append(Row(label, "", *figures, count, note))
    return rows


def _series(columns: NDArray[np.float64], depths: int) -> NDArray[np.float64]:
    """Collect for each press the ten presses up to it, ever deeper at one place: n x 10 x f.

    The shallowest press is repeated in place of missing earlier ones.
    """
    number = np.arange(len(columns))
    first = number - number % depths
    # Presses of one place follow each other, the shallowest first.
    before = np.maximum(number[:, None] - np.arange(_STEPS - 1, -1, -1), first[:, None])
    return columns[before]


def _networks(bench: Bench) -> list[Row]:
    """Predict markers and their images with the paper's LSTM and autoencoder."""
    _torch_networks.require()
    size: Size = bench.size
    touches = bench.once("touches", lambda: _press_results(bench))
    pictures = _pictures(bench, touches)
    series = _series(np.round(touches.column_px), size.depths)
    truth = touches.marker_px
    count, markers = len(pictures), truth.shape[1]
    split = "split by place"
    name = f"by LSTM, {split}"
    steps, markers_of = _columns_of(touches, steps=True), _markers_of(touches)

    def learned(told: NDArray[np.float64], test: NDArray[np.bool_]) -> _torch_networks.Network:
        network = _torch_networks.Network(
            lambda: _torch_networks.recurrent(series.shape[2], told.shape[1]),
            seed=bench.seed,
            epochs=size.recurrent_epochs,
            rate=1e-3,
            batch=50,
        )
        return network.fit(series[~test], told[~test])

    moved = np.zeros((count, markers))
    mean = np.zeros((count, markers))
    numbers, encoded, constant = (np.zeros((count, _CODE)) for _ in range(3))
    alike, blind, kept = np.zeros(count), np.zeros(count), np.zeros(count)
    dealt = folds(touches.place, size.network_folds, bench.random("folds"))
    for fold, test in enumerate(dealt):
        bench.tell(f"  LSTM and autoencoder, fold {fold + 1} of {size.network_folds}")
        to_markers = learned(truth, test)
        moved[test] = to_markers.predict(series[test])
        mean[test] = truth[~test].mean(axis=0)
        code = _torch_networks.Autoencoder(
            pictures[~test], seed=bench.seed, epochs=size.code_epochs
        )
        numbers_of = code.encode(pictures[~test])
        encoded[test] = code.encode(pictures[test])
        constant[test] = numbers_of.mean(axis=0)
        all_numbers = np.zeros((count, _CODE))
        all_numbers[~test] = numbers_of
        to_code = learned(all_numbers, test)
        numbers[test] = to_code.predict(series[test])
        decoded = code.decode(encoded[test])
        alike[test] = ssim(code.decode(numbers[test]), decoded)
        of_mean = np.broadcast_to(code.decode(constant[test][:1]), decoded.shape)
        blind[test] = ssim(of_mean, decoded)
        kept[test] = ssim(decoded, pictures[test])
        encoder, decoder = code.to_onnx()
        ways = ("rms error", _rms(moved[test], truth[test]), "px")
        foretold = ("SSIM of what is decoded of it", float(alike[test].mean()), "")
        coded = ("SSIM of decoded pictures", float(kept[test].mean()), "")
        _keep(bench, f"markers {name}", to_markers.to_onnx(_LSTM), steps, markers_of, test, ways)
        _keep(bench, f"code {name}", to_code.to_onnx(_LSTM), steps, _NUMBERS, test, foretold)
        _keep(bench, f"code, encoder, {split}", encoder, _DRAWN, _NUMBERS, test, coded)
        _keep(bench, f"code, decoder, {split}", decoder, _NUMBERS, _DRAWN, test, coded)
    said = (
        f"three layers of 256 on {_STEPS} steps of columns to a pixel, {size.recurrent_epochs} "
        "epochs of the paper's 100 (the published scripts differ); a step is a deeper press at "
        "rest at the same place; no place is in training and test"
    )
    drawn_of = (
        f"; the paper's autoencoder of {_CODE} numbers, {size.code_epochs} epochs, its encoder a "
        "mirror image of the published decoder; pictures are drawn from where markers are; it "
        f"keeps {kept.mean():.3f} of them"
    )
    figures = (None, _r2(moved, truth), _r2(mean, truth))
    rows = [Row(f"markers from columns {name}: R2", "", *figures, count, said)]
    # Each fold has its own code, so codes cannot be averaged over folds: compare within each fold.
    left, guessed = (float(((one - encoded) ** 2).sum()) for one in (numbers, constant))
    note = f"{said}{drawn_of}; about the mean code in training, which is the trivial guess"
    figures = (_ENCODED_R2, 1 - left / guessed, 0.0)
    rows.append(Row(f"encoded pictures {name}: R2", "", *figures, count, note))
    figures = (_SSIM[0], float(alike.mean()), float(blind.mean()))
    note = f"{said}{drawn_of}; decoded against decoded; trivial guess: the mean code, decoded"
    rows.append(Row(f"likeness of images {name}: SSIM", "", *figures, count, note))
    return rows


def _rms(found: NDArray[np.float64], truth: NDArray[np.float64]) -> float:
    return float(np.sqrt(((found - truth) ** 2).mean()))


def _r2(found: NDArray[np.float64], truth: NDArray[np.float64]) -> float:
    """Compute R2 over all values together: 0 for the mean."""
    spread = float(((truth - truth.mean(axis=0)) ** 2).sum())
    return 1 - float(((found - truth) ** 2).sum()) / spread


def _pictures(bench: Bench, touches: PressResults) -> NDArray[np.float64]:
    """Draw the camera's images of the markers, cropped to them and half a pitch around."""
    at_px = touches.marker_at_px
    apart = np.linalg.norm(at_px[:, None] - at_px, axis=2) + np.diag(np.full(len(at_px), np.inf))
    pitch_px = float(np.median(apart.min(axis=1)))
    low = at_px.min(axis=0) - pitch_px / 2
    scale = _PICTURE_PX / float((np.ptp(at_px, axis=0) + pitch_px).max())
    parameters = bench.design.parameters
    wide, pitch = (float(parameters[f"markers.{name}"].value) for name in ("diameter", "pitch"))
    places = at_px + touches.marker_px.reshape(len(touches.place), -1, 2)
    return draw_discs((places - low) * scale, wide / pitch * pitch_px * scale / 2, _PICTURE_PX)


def _markers_rms_px(bench: Bench) -> float:
    touches = _press_results(bench)
    return _marker_accuracy(bench, "split by place, exact columns", touches, touches.place).rms_px


_EXPERIMENTS: dict[str, Callable[[Bench], list[Row]]] = {
    "markers": _markers,
    "amplitudes": _amplitudes,
    "images": _images,
    "networks": _networks,
}

FAMILY = Family(
    experiments=_EXPERIMENTS,
    figures={"markers_rms_px": _markers_rms_px},
    quick=Size(),
    full=Size(places=150, spacing_mm=1.0, folds=10, recurrent_epochs=100, code_epochs=300),
    small=Size(places=6, depths=3, spacing_mm=3.0, folds=3),
    choices=("places are drawn evenly over a square of the skin; the paper has one finger's path",),
    left_out=(
        "time: columns and markers are those at rest after each press",
        "strokes of a finger: what was before a press is shallower presses at its place",
    ),
    plain=frozenset({"amplitudes", "networks"}),
    deep=frozenset({"networks"}),
)
