"""Messages and hints name arguments of functions, never options of the command."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

import fabkit
from fabkit import _fabkit

OPTION = re.compile(r"(?:^|[\s`(\"'])(--?[a-zA-Z][\w-]*)")
"""Matches an option of a command anywhere in a text, but not the arrow before a place."""

PRINTER = """\
format: 1
name: printer
process: {process}
material: "{material}"
shrinkage_percent: {{x: 0.4, y: 0.4, z: 0.4}}
holes: {{offset: -0.2 mm, gain: 0.996, smallest: 2 mm, largest: 12 mm}}
pins: {{offset: 0 mm, gain: 0.996, smallest: 2 mm, largest: 8 mm}}
elephant_foot: 0 mm
"""
PLAN = "format: 1\nsensor: rtac0\naxes:\n  {axis}: [{values}]\n"
SMALL = {"camera.width_px": "64", "camera.height_px": "48", "fixtures.semi_domes.count": "2"}


def hold(*calls: tuple[str, Callable[[], object]]) -> None:
    """Assert that each call raises an error whose text contains a word and no option."""
    wrong: list[str] = []
    for word, call in calls:
        try:
            call()
        except fabkit.FabkitError as error:
            texts = [str(error)]
            for problem in error.problems:
                texts += filter(None, (problem.message, problem.hint, problem.file))
            if not any(word in text for text in texts):
                wrong.append(f"without `{word}`: {error}")
            wrong += [f"names an option: {text}" for text in texts if OPTION.search(text)]
        else:
            wrong.append(f"`{word}`: no error")
    assert not wrong, "\n\n".join(wrong)


@pytest.fixture(scope="module")
def small() -> fabkit.Sensor:
    return fabkit.load("rtac0", SMALL)


def test_sensors_and_fixtures(tmp_path: Path) -> None:
    broken = tmp_path / "broken.yaml"
    broken.write_text("format: 1\nextends: rtac0\nname: mine\ncoat:\n  thicknes: 0.1 mm\n")
    load = fabkit.load
    hold(
        ("rtac1", lambda: load("rtac1")),
        ("presets", lambda: load("uvdtact", preset="published")),
        ("did you mean", lambda: load("rtac0", coat__thicknes="1 mm")),
        ("overrides", lambda: load("rtac0", coat__thickness="4 mm")),
        ("section", lambda: load("rtac0", {"coat": "1 mm"})),
        # Two parameters contradict each other: the error names both.
        ("overrides", lambda: load("rtac0", surface__radius="8 mm")),
        ("thickness", lambda: load(broken)),
        ("No such file", lambda: load(tmp_path / "none.yaml")),
        ("pin-dome", lambda: load("rtac0").fixtures["pin-domes"]),
    )


def test_exports(tmp_path: Path, rtac0: fabkit.Sensor) -> None:
    def profile(name: str, process: str, material: str) -> Path:
        path = tmp_path / name
        path.write_text(PRINTER.format(process=process, material=material))
        return path

    mine = profile("mine.yaml", "fdm", "PLA")
    other = profile("other.yaml", "fdm", "TPU")
    resin = profile("resin.yaml", "sla", "resin")
    out = tmp_path / "out"
    rtac0.export(out, parts=["base"], formats=["stl"])
    changed = tmp_path / "changed"
    rtac0.export(changed, parts=["base"], formats=["stl"])
    (changed / "base.stl").write_text("mine")
    coupon = rtac0.fixtures["coupon"]

    def export(**options: object) -> Callable[[], object]:
        return lambda: rtac0.export(tmp_path / "new", **options)  # type: ignore[arg-type]

    hold(
        ("shel", export(parts=["shel"])),
        ("stlx", export(formats=["stlx"])),
        ("tolerance", export(parts=["shell"], tolerance_mm=1e-6)),
        ("tolerance", export(parts=["shell"], tolerance_mm=float("nan"))),
        ("bed", export(bed_mm=(10.0, 10.0), formats=["3mf"])),
        ("stock", export(stock_mm=(10.0, 10.0), formats=["dxf"])),
        ("kerf", export(kerf_mm=40.0, formats=["dxf"])),
        ("limits", export(kerf_mm=1e9, formats=["dxf"])),
        ("3mf", export(parts=["shell"], formats=["dxf"])),
        ("process", export(parts=["shell"], formats=["tree"], process=mine)),
        ("process", export(parts=["shell"], process=other)),
        ("process", export(parts=["shell"], process=resin)),
        ("cannot read", export(process=tmp_path / "none.yaml")),
        ("clean", lambda: coupon.export(out, formats=["stl"])),
        ("force", lambda: rtac0.export(changed, parts=["base"], formats=["stl"])),
        ("folder", lambda: rtac0.export(mine / "below", parts=["base"], formats=["stl"])),
        ("ending", lambda: rtac0.parts["shell"].export("shell.obj")),
        ("printed", lambda: rtac0.parts["shell"].export("shell.dxf")),
    )


def test_pictures_and_ground_truth(rtac0: fabkit.Sensor, tmp_path: Path) -> None:
    cast = fabkit.depth.cast
    aside = tmp_path / "aside.yaml"
    aside.write_text("camera_from_sensor: [[1, 0], [0, 1]]\n")
    huge = fabkit.load("rtac0", {"camera.width_px": "8000", "camera.height_px": "8000"})
    away = np.diag([1.0, -1.0, -1.0, 1.0])
    deep = fabkit.load("rtac0", {"fixtures.semi_domes.depth.deepest": "1.6 mm"})

    def lengths(given: str) -> fabkit.Sensor:
        return fabkit.load("rtac0", {"fixtures.pin_dome.pins.lengths": given})

    hold(
        ("smaller", lambda: rtac0.picture(size_px=(100_000, 100_000))),
        ("sensr", lambda: rtac0.picture(assembly="sensr")),
        ("semi-dome-999", lambda: cast(rtac0, "semi-dome-999")),
        ("polar", lambda: cast(rtac0, "hemisphere@30deg")),
        ("margin", lambda: cast(deep, "semi-dome-001")),
        ("less deep", lambda: cast(lengths("[5 mm, 6.4 mm]"), "pin-1-long")),
        ("9 mm", lambda: cast(rtac0, "hemisphere@30deg,0deg,9mm")),
        ("allow_no_contact", lambda: cast(lengths("[4 mm, 6 mm]"), "pin-1-short")),
        ("allow_no_contact", lambda: cast(rtac0, "hemisphere@89deg,0deg,0.2mm", pose=np.eye(4))),
        ("samples", lambda: cast(rtac0, samples=0)),
        ("samples", lambda: cast(huge, samples=8)),
        ("membrane", lambda: cast(rtac0, membrane_mm=11.0)),
        ("linear", lambda: cast(rtac0, contact="liner")),
        ("linear", lambda: cast(rtac0, "ball@30deg,0deg,1mm", shear_mm=(1, 0))),
        ("distance", lambda: cast(rtac0, contact="membrane")),
        ("friction", lambda: cast(rtac0, friction=1.0)),
        ("1.5 mm", lambda: fabkit.press(rtac0, "ball@0deg,0deg", 3.0)),
        ("print sigma", lambda: cast(rtac0, print_sigma_mm=2.0)),
        ("camera", lambda: cast(rtac0, camera=aside)),
        ("camera_from_sensor", lambda: cast(rtac0, pose=away)),
        ("aside.yaml", lambda: cast(rtac0, pose=aside)),
    )


def test_data_sets(small: fabkit.Sensor, tmp_path: Path) -> None:
    write, out = fabkit.dataset.write, tmp_path / "out"
    listed = tmp_path / "list.txt"
    listed.write_text("nonsense\n")
    full = tmp_path / "full"
    full.mkdir()
    (full / "mine").write_text("mine")
    done = tmp_path / "done"
    write(small, done)
    more = fabkit.load("rtac0", SMALL | {"fixtures.semi_domes.count": "3"})
    begun = tmp_path / "begun" / "dataset.partial"
    begun.mkdir(parents=True)
    (begun / "plan.json").write_text("")
    bad = tmp_path / "bad"
    write(small, bad)
    shards = sorted(bad.glob("halves/indentation_mm/c/**/*"))
    shard = next(path for path in shards if path.is_file())
    shard.write_bytes(b"x" + shard.read_bytes()[1:])

    def sample() -> object:
        return fabkit.dataset.open(bad)[0]

    hold(
        ("margin", lambda: write(small, out, seam_margin_mm=11.0)),
        ("membrane", lambda: write(small, out, membrane_mm=-1.0)),
        ("surface", lambda: write(fabkit.load("fluidic"), out)),
        ("semi-dome-001", lambda: write(small, out, presses=listed)),
        ("cannot read", lambda: write(small, out, presses=tmp_path / "none.txt")),
        ("left.png", lambda: write(small, out, captures=full)),
        ("resume", lambda: write(small, full)),
        ("resume", lambda: write(more, done, resume=True)),
        ("resume", lambda: fabkit.dataset.open(tmp_path / "begun")),
        ("write", lambda: fabkit.dataset.open(tmp_path / "none")),
        ("damaged", sample),
    )


def test_calibration(rtac0: fabkit.Sensor, tmp_path: Path) -> None:
    board = fabkit.calibrate.boards(rtac0)["charuco"]
    lens, pose = fabkit.calibrate.intrinsics, fabkit.calibrate.extrinsics
    (tmp_path / "board.json").write_text("{}")
    (tmp_path / "lm.json").write_text('{"1": [0, 0]}')
    white = np.ones((480, 640), dtype=np.float32)
    corners = fabkit.calibrate.Corners(np.array([0, 0], dtype=np.uint32), np.zeros((2, 2)))
    beyond = fabkit.calibrate.Corners(np.array([9999], dtype=np.uint32), np.zeros((1, 2)))
    pins = fabkit.calibrate.Pins(np.zeros((1, 2)), holes=[1])
    nowhere = fabkit.calibrate.Pins(np.zeros((1, 2)), holes=[999])
    captures = tmp_path / "captures"
    captures.mkdir()
    empty = tmp_path / "empty"
    empty.mkdir()
    (captures / "01.png").write_bytes(rtac0.picture(size_px=(64, 64)))
    camera = rtac0.camera
    shadow = fabkit.load("rtac0").fixtures["coupon"]
    hold(
        ("boards", lambda: lens(rtac0, tmp_path / "board.json", [white])),
        ("px", lambda: lens(rtac0, board, [white[:100, :100]], detector="fabkit")),
        ("same image", lambda: lens(rtac0, board, [white, white], detector="fabkit")),
        ("10 to 20", lambda: lens(rtac0, board, [white], detector="fabkit")),
        ("twice", lambda: lens(rtac0, board, [corners])),
        ("9999", lambda: lens(rtac0, board, [beyond])),
        ("pinhol", lambda: lens(rtac0, board, [corners], models=["pinhol"])),
        ("`pin`", lambda: pose(rtac0, camera, [pins])),
        ("999", lambda: pose(rtac0, camera, [nowhere], pin="long")),
        ("kinds", lambda: pose(rtac0, camera, [pins], pin="none")),
        ("hole 1", lambda: pose(rtac0, camera, [pins], landmarks=tmp_path / "lm.json")),
        ("no pins", lambda: pose(rtac0, camera, [pins], landmarks=shadow)),
        ("reference", lambda: pose(rtac0, camera, captures, pin="long")),
        ("no captures", lambda: pose(rtac0, camera, empty, pin="long")),
        ("cannot read", lambda: pose(rtac0, camera, tmp_path / "none", pin="long")),
        ("camera", lambda: fabkit.Camera.load(tmp_path / "lm.json")),
    )


def test_sweeps(tmp_path: Path) -> None:
    def plan(name: str, values: str, axis: str = "coat.thickness") -> Path:
        (tmp_path / name).write_text(PLAN.format(axis=axis, values=values))
        return tmp_path / name

    one, two = plan("one.yaml", "0.1 mm"), plan("two.yaml", "0.1 mm, 0.12 mm")
    wrong = plan("wrong.yaml", "0.1 mm", "coat.thicknes")
    full, done = tmp_path / "full", tmp_path / "done"
    full.mkdir()
    (full / "mine").write_text("mine")
    native = fabkit.sweep.load(two)._native  # pyright: ignore[reportPrivateUsage]
    with closing(_fabkit.SweepStore.open(str(done), native, False)) as store:
        hold(("version", lambda: store.put(["x"])))
    hold(
        ("coat.thicknes", lambda: fabkit.sweep.run(wrong, full)),
        ("cannot read", lambda: fabkit.sweep.run(tmp_path / "none.yaml", full)),
        ("resume", lambda: fabkit.sweep.run(one, full)),
        ("resume", lambda: fabkit.sweep.run(one, done, resume=True)),
    )
