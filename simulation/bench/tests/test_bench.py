"""Benches: reproducible figures, reports that work offline, helpful errors."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import fabkit

pytest.importorskip("sklearn")

import fabkit_bench as bench
from fabkit_bench import (
    _depth,
    _images,
    _models,
    _occlusion,
    _run,
    _similarity,
    _torch_networks,
    dome,
    flat_gel,
    half_ellipsoid,
    pin_tip,
    sheet_mold,
)
from fabkit_bench.__main__ import main

DOME = dome.Size(
    size_px=(64, 48),
    spacing_mm=0.9,
    train_patterns=8,
    test_patterns=3,
    pixels=100,
    epochs=15,
    units=1,
    tuning_patterns=2,
    tuning_epochs=2,
    trials=2,
    direct=False,
)


def at_rest(_: object) -> list[bench.Row]:
    """Return a row without a press, for what is the same for all experiments."""
    return [bench.Row("light at rest", "", 0.5, 0.4, None, 0, "for tests")]


@pytest.fixture(scope="module")
def report() -> bench.Report:
    return bench.run("rtac0", seed=3, size=DOME)


def test_the_same_seed_gives_the_same_figures() -> None:
    size = replace(DOME, train_patterns=4, epochs=2)
    first, again, other = (
        bench.run("rtac0", seed=seed, size=size, rows=["depth"]).rows for seed in (3, 3, 4)
    )
    assert again == first
    assert other != first


def test_a_report_is_json(report: bench.Report) -> None:
    document = json.loads(json.dumps(report.document(), allow_nan=False))
    assert (document["format"], document["version"]) == ("fabkit-bench", 1)
    assert document["is_simulated"] is True
    assert document["design_hash"] == fabkit.load("rtac0").design_hash
    assert document["constants"]
    assert document["left_out"]
    assert {"name", "unit", "paper", "simulated", "baseline", "samples", "note"} <= set(
        document["rows"][0]
    )


def test_a_page_needs_no_network(report: bench.Report) -> None:
    page = report.html()
    assert page.startswith("<!DOCTYPE html>")
    assert "prefers-color-scheme: dark" in page
    assert not any(word in page for word in ("http:", "https:", "src=", "url(", "@import", "<link"))
    for row in report.rows:
        assert row.name.replace("<", "&lt;") in page


def test_learning_beats_a_guess(report: bench.Report) -> None:
    rows = {row.name: row for row in report.rows}
    row = rows["trained unit, unseen patterns: mean error, contact"]
    assert row.simulated is not None
    assert row.baseline is not None
    assert row.simulated < 0.8 * row.baseline


def test_impossible_presses_are_reported(report: bench.Report) -> None:
    row = next(row for row in report.rows if "0 deg, 2 mm pressed" in row.name)
    assert row.simulated is None
    assert row.paper is not None
    assert "at most 1.5 mm" in row.note


def test_files_are_written_whole(report: bench.Report, tmp_path) -> None:
    folder = tmp_path / "deep" / "bench"
    report.save(folder)
    names = [".written-by-fabkit.json", "bench.html", "bench.json", "networks"]
    assert sorted(path.name for path in folder.iterdir()) == names
    assert sorted(report.networks) == ["depth", "depth-wider-view"]
    assert json.loads((folder / "bench.json").read_text()) == report.document()
    # The next report replaces them, but nothing that somebody else wrote.
    report.save(folder)
    (folder / "bench.html").write_text("mine")
    with pytest.raises(fabkit.FabkitError, match="fabkit did not write it") as caught:
        report.save(folder)
    assert caught.value.exit_code == 2
    assert (folder / "bench.html").read_text() == "mine"
    (tmp_path / "file").write_text("")
    with pytest.raises(fabkit.FabkitError) as caught:
        report.save(tmp_path / "file")
    assert caught.value.exit_code == 4


def test_columns_predict_markers() -> None:
    size = sheet_mold.Size(places=6, depths=3, spacing_mm=3.0, folds=3)
    rows = {row.name: row for row in bench.run("fluidic", size=size).rows}
    row = rows["markers from columns, split at random: rms error"]
    assert row.samples == 18
    assert row.simulated < row.baseline
    alike = rows["likeness of predicted images, split at random: SSIM"]
    assert alike.baseline < alike.simulated < 1


def test_ssim_follows_its_formula() -> None:
    random = np.random.default_rng(5)
    one, other = random.uniform(size=(2, 3, 16, 16))
    same = _similarity.ssim(one, one)
    assert np.allclose(same, 1, rtol=0, atol=1e-12)
    assert np.array_equal(_similarity.ssim(one, other), _similarity.ssim(other, one))
    # Constant images have no structure: only the luminance term of SSIM remains.
    dark, light = np.full((1, 16, 16), 0.2), np.full((1, 16, 16), 0.7)
    expected = (2 * 0.2 * 0.7 + 1e-4) / (0.2**2 + 0.7**2 + 1e-4)
    assert abs(_similarity.ssim(dark, light)[0] - expected) < 1e-9
    # A single window: means and sample variances by numpy.
    a, b = one[:, :7, :7], other[:, :7, :7]
    for x, y, found in zip(a, b, _similarity.ssim(a, b), strict=True):
        (xx, xy), (_, yy) = np.cov(x.ravel(), y.ravel())
        mx, my = x.mean(), y.mean()
        light_part = (2 * mx * my + 1e-4) / (mx**2 + my**2 + 1e-4)
        assert abs(found - light_part * (2 * xy + 9e-4) / (xx + yy + 9e-4)) < 1e-12


def test_a_code_reproduces_its_training_images() -> None:
    places = np.random.default_rng(6).uniform(4, 20, (12, 5, 2))
    pictures = _similarity.draw_discs(places, 2.0, 24)
    assert pictures.min() == 0
    assert pictures.max() == 1
    # Upper bound: the area of five discs without overlap.
    assert pictures.sum(axis=(1, 2)).max() < 5 * np.pi * 2.5**2
    code = _similarity.Code(pictures, 11)
    assert np.allclose(code.decode(code.encode(pictures)), pictures, rtol=0, atol=1e-9)
    short = _similarity.Code(pictures, 2)
    assert short.encode(pictures).shape == (12, 2)


def test_figures_are_finite_and_reproducible() -> None:
    size = flat_gel.Size(size_px=(48, 36), spacing_mm=1.0, train=20, test=3, pixels=60, epochs=3)
    first, again = (bench.figures("digit-like", size=size) for _ in range(2))
    assert first == again
    assert first["depth_mae_mm"] > 0


@pytest.mark.parametrize("seed", [-1, 2**31, 0.5, True])
def test_invalid_seed_is_an_error(seed) -> None:
    with pytest.raises(fabkit.FabkitError, match="the seed is"):
        bench.run("rtac0", seed=seed, rows=["depth"])


def test_unknown_experiments_and_families(monkeypatch) -> None:
    with pytest.raises(fabkit.FabkitError) as caught:
        bench.run("rtac0", rows=["depths"])
    assert caught.value.hint == "did you mean `depth`?"
    monkeypatch.setattr(_run, "families", lambda: ["ring"])
    with pytest.raises(fabkit.FabkitError, match="family dome, which has no experiment"):
        bench.run("rtac0")


def test_without_scikit_learn(monkeypatch) -> None:
    def missing(name: str):
        raise ImportError(name)

    bench.experiments("rtac0")
    experiments = {**dome.FAMILY.experiments, "light": at_rest}
    family = replace(dome.FAMILY, experiments=experiments, plain=frozenset({"light"}))
    monkeypatch.setattr(_models.importlib, "import_module", missing)
    monkeypatch.setattr(_run, "_family", lambda _: family)
    assert len(bench.run("rtac0", rows=["light"]).rows) == 1
    with pytest.raises(fabkit.FabkitError, match="scikit-learn") as caught:
        bench.run("rtac0", rows=["depth"])
    assert "fabkit-cad[bench]" in (caught.value.hint or "")


def test_papers_networks_need_pytorch_and_say_so(monkeypatch) -> None:
    def missing(name: str):
        raise ImportError(name)

    family = sheet_mold.FAMILY
    asked = family.experiments["networks"]
    # A quick run neither runs them nor complains that PyTorch is missing.
    quick = {name: lambda _: [] for name in family.experiments if name not in family.deep}
    monkeypatch.setattr(_run, "_family", lambda _: replace(family, experiments={**quick}))
    assert bench.run("fluidic").rows == []
    both = replace(family, experiments={**quick, "networks": asked})
    monkeypatch.setattr(_run, "_family", lambda _: both)
    assert bench.run("fluidic").rows == []
    monkeypatch.setattr(_models, "require", lambda: None)
    monkeypatch.setattr(_torch_networks.importlib, "import_module", missing)
    (row,) = bench.run("fluidic", quick=False).rows
    assert (row.experiment, row.simulated) == ("networks", None)
    assert "PyTorch" in row.note
    with pytest.raises(fabkit.FabkitError, match="PyTorch") as caught:
        bench.run("fluidic", rows=["networks"])
    assert "fabkit-cad[torch]" in (caught.value.hint or "")


def test_a_press_remembers_the_shallower_ones_at_its_place() -> None:
    # Two places, four depths each.
    series = sheet_mold._series(np.arange(8.0)[:, None], 4)[..., 0]
    assert series.shape == (8, 10)
    assert series[0].tolist() == [0.0] * 10
    assert series[6].tolist() == [4.0] * 8 + [5.0, 6.0]


def test_papers_networks_learn_reproducibly() -> None:
    torch = pytest.importorskip("torch")
    random = np.random.default_rng(0)
    series = random.normal(size=(120, 10, 4))
    truth = series[:, -3:, :2].sum(axis=1)
    threads = torch.get_num_threads()

    def learned() -> np.ndarray:
        form = lambda: _torch_networks.recurrent(4, 2, layers=1, width=32)  # noqa: E731
        network = _torch_networks.Network(form, seed=1, epochs=40, rate=1e-2, batch=20)
        return network.fit(series, truth).predict(series)

    found = learned()
    assert np.abs(found - truth).mean() < 0.3 * np.abs(truth - truth.mean(axis=0)).mean()
    assert (learned() == found).all()
    assert torch.get_num_threads() == threads
    pictures = random.uniform(size=(6, 1, 40, 50))
    network = _torch_networks.Network(
        lambda: _torch_networks.resnet_18(3), seed=1, epochs=1, rate=1e-4, batch=3, loss="L1Loss"
    )
    assert network.fit(pictures, random.normal(size=(6, 3))).predict(pictures).shape == (6, 3)
    dots = (random.uniform(size=(8, 68, 68)) > 0.9).astype(float)
    code = _torch_networks.Autoencoder(dots, seed=1, epochs=2)
    numbers = code.encode(dots)
    assert numbers.shape == (8, sheet_mold._CODE)
    assert code.decode(numbers).shape == dots.shape


def test_an_edge_is_followed() -> None:
    size = pin_tip.Size(
        # Only the sensor's own pin layout.
        tips=(),
        angles_deg=(-40, 0, 40),
        radii_mm=(-4, 0, 4),
        train=1,
        test=1,
        contour=4,
        samples=1,
        spacing_mm=1.0,
    )
    rows = bench.run("tactip", rows=["contour"], size=size).rows
    assert [row.unit for row in rows] == ["deg", "mm"]
    for row in rows:
        assert 1 <= row.samples <= 4
        assert row.simulated is not None
        # It starts on the edge: the error is at most the distance of classes.
        assert row.simulated < {"deg": 60.0, "mm": 6.0}[row.unit]


def test_extended_sensor_runs_the_same_experiments(monkeypatch, tmp_path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("format: 1\nextends: rtac0\nname: mine\ncamera: {frame_rate: 200}\n")
    assert bench.experiments(str(path)) == bench.experiments("rtac0")
    monkeypatch.setitem(_run._family(fabkit.load("rtac0")).experiments, "light", at_rest)
    report = bench.run(str(path), rows=["light"])
    assert report.sensor == "mine"
    assert [row.paper for row in report.rows] == [0.5]


def test_the_command(capsys, monkeypatch, tmp_path) -> None:
    monkeypatch.setitem(_run._family(fabkit.load("rtac0")).experiments, "light", at_rest)
    asked = ["rtac0", "--rows", "light", "--quiet"]
    assert main([*asked, "--json", "-o", str(tmp_path)]) == 0
    assert json.loads(capsys.readouterr().out)["sensor"] == "rtac0"
    assert (tmp_path / "bench.html").exists()
    assert main(asked) == 0
    assert "simulated, seed 0, quick" in capsys.readouterr().out
    assert main(["rtac1"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    assert "help: did you mean `rtac0`?" in said
    assert main(["rtac0", "--set", "coat"]) == 2


def test_folds_test_each_sample_once_and_keep_groups() -> None:
    groups = np.repeat(np.arange(7), 3)
    masks = list(half_ellipsoid.folds(groups, 3, np.random.default_rng(0)))
    assert (np.sum(masks, axis=0) == 1).all()
    for mask in masks:
        assert not set(groups[mask]) & set(groups[~mask])


def test_slopes_are_integrated_to_heights() -> None:
    rows, columns = np.mgrid[0:40, 0:50]
    heights = np.exp(-((rows - 18) ** 2 + (columns - 27) ** 2) / 50.0)
    down, across = np.gradient(heights)
    assert np.abs(flat_gel._integrate_slopes(down, across) - heights).max() < 0.05


def test_blur_and_neighbours() -> None:
    picture = np.zeros((1, 21, 21), dtype=np.float32)
    picture[0, 10, 10] = 1.0
    soft = _images.blurred(picture, 1.5)
    assert soft.sum() == pytest.approx(1.0, abs=1e-5)
    assert soft[0, 10, 10] == soft.max()
    assert _images.neighbourhoods(picture, 3)[0, 9, 11].tolist() == [0, 0, 0, 0, 0, 0, 1, 0, 0]


def test_scores_are_over_their_mask() -> None:
    mask = np.array([[[True, False]]])
    seen = _depth.PixelData(
        darkness=mask.astype(np.float32),
        depth_mm=np.array([[[1.0, 9.0]]], dtype=np.float32),
        masks={"all": mask},
    )
    found = _depth.score(np.array([[[1.05, 0.0]]], dtype=np.float32), seen, "all")
    assert found.mean_mm == pytest.approx(0.05, abs=1e-6)
    assert found.near == 100.0


def test_components_and_ridge_find_a_plane() -> None:
    random = np.random.default_rng(0)
    features = random.normal(size=(60, 4))
    targets = features @ np.array([1.0, -2.0, 0.5, 3.0]) + 1.0
    kept = _models.Components(4).fit(features)(features)
    with _models.one_thread():
        assert np.abs(_models.Ridge().fit(kept, targets).predict(kept) - targets).max() < 0.01


def test_the_command_asks_this_interpreter(tmp_path):
    folder = str(tmp_path / "bench")
    words = ["bench", "shadowtac", "--rows", "linear", "--seed", "3", "-o", folder, "--json"]
    done = subprocess.run(
        [sys.executable, "-m", "fabkit", *words], capture_output=True, text=True, check=True
    )
    document = json.loads(done.stdout)
    assert document["format"] == "fabkit-bench"
    assert document["seed"] == 3
    assert [row["paper"] for row in document["rows"]] == [0.997, 0.0014, 0.988, 0.0185]
    written = json.loads((tmp_path / "bench" / "bench.json").read_text())
    assert written["rows"] == document["rows"]
    words[3] = "nothing"
    command = [sys.executable, "-m", "fabkit", *words]
    failed = subprocess.run(command, capture_output=True, text=True)
    assert failed.returncode == 2
    assert "linear" in json.loads(failed.stdout)["problems"][0]["hint"]


_DOTS_MM = np.stack(np.meshgrid(*2 * [np.arange(-4.2, 4.3, 1.4)]), axis=-1).reshape(-1, 2)
_PIXEL_MM = 0.08


def _covered(diameter_mm: float) -> np.ndarray:
    """Cover a plane surface with dots 1.4 mm apart: 120 x 120 pixels of 0.08 mm."""
    rows, columns = (np.mgrid[:120, :120] - 59.5) * _PIXEL_MM
    points_mm = np.stack([columns, rows, np.zeros((120, 120))], axis=-1)
    # Tracked middles may be slightly off the surface.
    middles_mm = np.column_stack([_DOTS_MM, np.full(len(_DOTS_MM), 0.1)])
    return _occlusion.covered(points_mm, middles_mm, _DOTS_MM / _PIXEL_MM + 59.5, diameter_mm)


@pytest.mark.parametrize("diameter_mm", [0.5, 0.7])
def test_opaque_markers_cover_their_area(diameter_mm) -> None:
    area_mm2 = _covered(diameter_mm).sum() * _PIXEL_MM**2
    # Discretisation: dots of a few pixels; 3 % of the area is a tenth of a pixel in radius.
    assert area_mm2 == pytest.approx(len(_DOTS_MM) * np.pi * diameter_mm**2 / 4, rel=0.03)


def test_larger_opaque_markers_hide_more_of_a_bump() -> None:
    # Three light sources at 120 degrees illuminate a plane with a bump, 1 mm high, 6 mm wide.
    rows, columns = (np.mgrid[:120, :120] - 59.5) * _PIXEL_MM
    height_mm = np.maximum(1 - (rows**2 + columns**2) / 9, 0) ** 2
    down, across = np.gradient(height_mm, _PIXEL_MM)
    angles = np.deg2rad([90, 210, 330])
    # Each light is slightly brighter on its own side, like light sources at the rim.
    lit = [1 - across * np.cos(a) - down * np.sin(a) for a in angles]
    near = [1 + 0.02 * (columns * np.cos(a) + rows * np.sin(a)) for a in angles]
    bump, level = 80 * np.stack(lit, axis=-1), 80 * np.stack(near, axis=-1)
    stereo = _occlusion.Stereo(level)
    ground = np.full_like(level, 80.0)
    shares = [np.zeros((120, 120)), _covered(0.5), _covered(0.7)]
    dark = [1 - 0.9 * share[..., None] for share in shares]
    # Ink that reflects like the coat shows the same slopes, however dark it is.
    as_lit = [stereo.largest(bump * one, ground * one) for one in dark]
    assert as_lit == pytest.approx([as_lit[0]] * 3, rel=1e-6)
    # Heights are in pixels with mean 0. Curvature between pixels: 1 %.
    assert as_lit[0] * _PIXEL_MM == pytest.approx(1 - height_mm.mean(), rel=0.01)
    bare, small, large = (
        stereo.largest(bump * one, ground * one, (share, share))
        for one, share in zip(dark, shares, strict=True)
    )
    assert bare == pytest.approx(as_lit[0], rel=1e-12)
    assert bare > small > large
