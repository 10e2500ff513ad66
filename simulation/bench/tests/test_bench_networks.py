"""ONNX files of trained networks give the same outputs, and their cards are consistent."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace

import numpy as np
import pytest

import fabkit

pytest.importorskip("sklearn")

import fabkit_bench as bench
from fabkit_bench import (
    _models,
    _run,
    _similarity,
    _torch_networks,
    half_ellipsoid,
    pin_tip,
    sheet_mold,
)
from fabkit_bench._networks import Card, HeldOut, Numbers

onnxruntime = pytest.importorskip("onnxruntime")
RANDOM = np.random.default_rng(0)
# Features far from 0 and of different sizes, like pixels and intensities; one of them is constant.
FEATURES = RANDOM.normal([100.0, -3.0, 0.02, 7.0], [40.0, 0.5, 0.01, 0.0], (80, 4))
TARGETS = np.column_stack(
    [20 + 0.05 * FEATURES[:, 0], np.abs(FEATURES[:, 1]) + 30 * FEATURES[:, 2]]
)
TOUCHES = sheet_mold.Size(places=6, depths=3, spacing_mm=3.0, folds=3)


def answered(onnx: bytes, given: np.ndarray) -> np.ndarray:
    session = onnxruntime.InferenceSession(onnx, providers=["CPUExecutionProvider"])
    (taken,) = session.get_inputs()
    type = {"tensor(float)": np.float32, "tensor(double)": np.float64}[taken.type]
    return session.run(["y"], {taken.name: given.astype(type)})[0]


def bound(layers, given: np.ndarray) -> np.ndarray:
    """Compute the largest rounding error of layers in float32, compared with float64."""
    unit = 2.0**-24
    error = unit * np.abs(given)
    for i, layer in enumerate(layers):
        sizes = np.abs(layer.weights)
        # Rounding of a weight, of a product, and of all sums of an output.
        rounded = (len(sizes) + 2) * unit * (np.abs(given) @ sizes + np.abs(layer.bias))
        error = error @ sizes + rounded
        given = given @ layer.weights + layer.bias
        given = np.maximum(given, 0) if i + 1 < len(layers) else given
    # Allows for terms of second order, which are left out above.
    return 1.01 * error


def agree(onnx: bytes, layers, given: np.ndarray, wanted: np.ndarray) -> None:
    found = answered(onnx, given)
    wanted = wanted.reshape(found.shape)
    within = bound(layers, given)
    assert (np.abs(found - wanted) <= within).all()
    # The bound is meaningful only if it is small.
    assert within.max() < 1e-3 * np.ptp(wanted)


@pytest.mark.parametrize("targets", [TARGETS, TARGETS[:, 1]])
def test_a_perceptron_answers_the_same(targets) -> None:
    network = _models.Network((16, 8), seed=1, epochs=20, batch=20).fit(FEATURES, targets)
    wanted = network.predict(FEATURES)
    written = network.to_onnx()
    agree(written.onnx, network.layers(), FEATURES, wanted)
    assert written.form.startswith(f"perceptron 4-16-8-{written.gives[1]},")
    low, high = float(np.quantile(wanted, 0.3)), float(np.quantile(wanted, 0.7))
    cut = network.to_onnx(within=(low, high))
    agree(cut.onnx, network.layers(), FEATURES, np.clip(wanted, low, high))


@pytest.mark.parametrize("targets", [TARGETS, TARGETS[:, 1]])
def test_a_ridge_answers_the_same(targets) -> None:
    ridge = _models.Ridge().fit(FEATURES, targets)
    agree(ridge.to_onnx().onnx, ridge.layers(), FEATURES, ridge.predict(FEATURES))


def test_components_are_folded_into_the_first_layer() -> None:
    samples = RANDOM.normal(size=(60, 5)) @ RANDOM.normal(size=(5, 30)) + 2.0
    components = _models.Components(4).fit(samples)
    network = _models.Network((8,), seed=2, epochs=20, batch=20)
    network.fit(components(samples), samples[:, 0])
    wanted = network.predict(components(samples))
    written = network.to_onnx(of=components)
    assert written.takes == ("n", 30)
    agree(written.onnx, network.layers(components), samples, wanted)


def test_decoding_is_folded_into_the_last_layer() -> None:
    pictures = _similarity.draw_discs(RANDOM.uniform(3, 13, (20, 4, 2)), 1.5, 16)
    code = _similarity.Code(pictures, 6)
    numbers = code.encode(pictures)
    features = numbers @ RANDOM.normal(size=(6, 3))
    ridge = _models.Ridge().fit(features, numbers)
    written = ridge.to_onnx(into=code, within=(0, 1))
    wanted = code.decode(ridge.predict(features))
    agree(written.onnx, ridge.layers(code), features, wanted)


def test_a_gaussian_process_answers_the_same() -> None:
    for features in (FEATURES[:40, :1], FEATURES[:40, :3]):
        process = _models.Process(3).fit(features, TARGETS[:40, 1])
        beside = features + 0.3 * FEATURES.std(axis=0)[: features.shape[1]]
        written = process.to_onnx()
        found = answered(written.onnx, beside)
        # Rounding in float64: weights of both signs times numbers up to 1.
        weights = np.abs(process._model.alpha_).sum() * process._model.kernel_.k1.k1.constant_value
        within = 100 * 2.0**-53 * (1 + weights) * (TARGETS[:, 1].max() + 1)
        assert np.abs(found[:, 0] - process.predict(beside)).max() <= within < 1e-6


def test_histograms_find_the_same_class() -> None:
    steps = RANDOM.integers(0, 64, (5, 6, 4, 3)) // np.array([1, 2, 3, 4, 5])[:, None, None, None]
    train = steps[:, :4].reshape(5, 4, 12)
    counts = (train[..., None] == np.arange(64)).sum(axis=1)
    likelihood = np.log(counts / 4 + pin_tip._EPSILON)
    classes = np.array([(a, r) for r, a in enumerate([-40.0, -20.0, 0.0, 20.0, 40.0])])
    small = counts.astype(np.uint8)
    taught = pin_tip.EdgeClassifier(classes, small, 4, (4, 3), likelihood, train[:, :0])
    # All 8-bit intensities, including all that map to the same step of the chip.
    pictures = RANDOM.integers(0, 256, (40, 4, 3)).astype(np.uint8)
    pictures[0] = 0
    pictures[1] = 255
    read = pin_tip._chip(pictures).reshape(40, -1)
    wanted = [taught.classes[taught.find(one)] for one in read]
    assert (answered(taught.to_onnx().onnx, pictures) == np.array(wanted)).all()


def test_papers_networks_answer_the_same() -> None:
    pytest.importorskip("torch")

    def near(onnx, given, wanted) -> None:
        found = answered(onnx, given).reshape(wanted.shape)
        # Rounding: sums of hundreds of numbers in float32 in each layer.
        assert np.abs(found - wanted).max() < 1e-5 * max(1.0, np.abs(wanted).max())

    pictures, forces = RANDOM.normal(3, 20, (8, 1, 30, 41)), RANDOM.normal(1, 2, (8, 3))
    form = {"seed": 1, "epochs": 1, "rate": 1e-3, "batch": 4}
    deep = _torch_networks.Network(lambda: _torch_networks.resnet_18(3), loss="L1Loss", **form).fit(
        pictures, forces
    )
    near(deep.to_onnx("").onnx, pictures, deep.predict(pictures))
    series, ways = RANDOM.normal(2, 1, (20, 10, 4)), RANDOM.normal(5, 2, (20, 3))
    of = lambda: _torch_networks.recurrent(4, 3, layers=3, width=16)  # noqa: E731
    last = _torch_networks.Network(of, **form).fit(series, ways)
    near(last.to_onnx("").onnx, series, last.predict(series))
    dots = (RANDOM.uniform(size=(6, 68, 68)) > 0.9).astype(float)
    code = _torch_networks.Autoencoder(dots, seed=1, epochs=1)
    encoder, decoder = code.to_onnx()
    numbers = code.encode(dots)
    near(encoder.onnx, dots[:, None], numbers)
    near(decoder.onnx, numbers, code.decode(numbers))


@pytest.fixture(scope="module")
def report() -> bench.Report:
    return bench.run("fluidic", seed=2, size=TOUCHES, rows=["markers", "images"])


def test_cards_describe_inputs_and_outputs(report, tmp_path) -> None:
    written = report.save(tmp_path)
    document = json.loads((tmp_path / "bench.json").read_text())
    assert [one["name"] for one in document["networks"]] == list(report.networks)
    assert "markers-split-by-place" in report.networks
    assert len(written) == 2 + 2 * len(report.networks)
    for one in document["networks"]:
        onnx = (tmp_path / "networks" / f"{one['name']}.onnx").read_bytes()
        text = (tmp_path / "networks" / f"{one['name']}.json").read_text()
        card = json.loads(text)
        assert card == report.networks[one["name"]].card
        json.dumps(card, allow_nan=False)
        assert card["sha256"] == one["sha256"] == hashlib.sha256(onnx).hexdigest()
        assert (card["format"], card["version"]) == ("fabkit-bench-network", 1)
        assert card["is_simulated"] is True
        assert card["design_hash"] == fabkit.load("fluidic").design_hash
        assert card["seed"] == 2
        assert card["training"]["samples"] + card["held_out"][0]["samples"] == 18
        session = onnxruntime.InferenceSession(onnx, providers=["CPUExecutionProvider"])
        for told, (found,) in (
            (card["takes"], session.get_inputs()),
            (card["gives"], session.get_outputs()),
        ):
            assert (told["name"], told["shape"]) == (found.name, found.shape)
            assert told["what"]
        size = card["takes"]["shape"][1:]
        assert answered(onnx, np.zeros((5, *size))).shape == (5, *card["gives"]["shape"][1:])
    assert "Trained networks" in (tmp_path / "bench.html").read_text()


def test_the_error_of_a_card_is_that_of_its_file(report) -> None:
    again, _ = _run._ready("fluidic", 2, True, TOUCHES, None)
    touches = sheet_mold._press_results(again)
    network = report.networks["markers-split-by-place"]
    test = next(half_ellipsoid.folds(touches.place, TOUCHES.folds, again.random("folds")))
    found = answered(network.onnx, np.round(touches.column_px)[test])
    (told,) = network.card["held_out"]
    rms_px = float(np.sqrt(((found - touches.marker_px[test]) ** 2).mean()))
    assert told["samples"] == test.sum()
    assert told["value"] == pytest.approx(rms_px, rel=1e-6)
    assert len(network.card["takes"]["columns"]) * 2 == network.card["takes"]["shape"][1]
    assert len(network.card["gives"]["markers"]) * 2 == network.card["gives"]["shape"][1]


def test_networks_of_an_earlier_run_are_not_left_there(report, tmp_path) -> None:
    report.save(tmp_path)
    folder = tmp_path / "networks"
    changed, *_, last = sorted(report.networks)
    # Foreign files, and one of these files after a change.
    (folder / "mine.json").write_text('{"format": "mine"}')
    (folder / "odd.json").write_text("no JSON")
    (folder / "list.json").write_text("[1]")
    (folder / "mine.onnx").write_bytes(b"mine")
    (folder / f"{changed}.onnx").write_bytes(b"trained on")
    one = replace(report, networks={last: report.networks[last]})
    one.save(tmp_path)
    left = {path.name for path in folder.iterdir()}
    others = {"mine.json", "mine.onnx", "odd.json", "list.json", f"{changed}.onnx"}
    assert left == others | {f"{last}.onnx", f"{last}.json"}
    replace(report, networks={}).save(tmp_path)
    assert {path.name for path in folder.iterdir()} == others
    assert json.loads((tmp_path / "bench.json").read_text())["networks"] == []


def test_nothing_is_replaced_where_networks_cannot_be_written(report, tmp_path) -> None:
    (tmp_path / "networks").write_text("a file")
    (tmp_path / "bench.json").write_text("before")
    with pytest.raises(fabkit.FabkitError) as caught:
        report.save(tmp_path)
    assert caught.value.exit_code == 4
    assert {path.name for path in tmp_path.iterdir()} == {"networks", "bench.json"}
    assert (tmp_path / "bench.json").read_text() == "before"


def test_the_first_of_a_name_is_kept_and_sweeps_keep_none() -> None:
    ridge = _models.Ridge().fit(FEATURES, TARGETS)
    numbers = Numbers("numbers", "")
    for small, kept in ((False, 1), (True, 0)):
        made, _ = _run._ready("fluidic", 0, True, None, None, small=small)
        for value in (float("nan"), 1.0):
            held_out = [HeldOut("error", value, "mm", 3)]
            card = Card(numbers, numbers, "all", (5, "numbers"), held_out)
            made.keep("Markers, all of 2 mm", ridge.to_onnx(), card)
        assert len(made.networks) == kept
        for name, network in made.networks.items():
            assert name == "markers-all-of-2-mm"
            assert network.card["held_out"][0]["value"] is None
