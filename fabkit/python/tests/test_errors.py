"""Errors have the command's codes and messages, and name the wrong value."""

import json
import pickle

import numpy as np
import pytest

import fabkit
import fabkit.sim

BAD_FILE = "format: 1\nextends: rtac0\nname: mine\ncoat:\n  thicknes: 0.1 mm\nsurface:\n  wall: 3\n"


def test_a_file_with_problems_gives_all_of_them_with_lines(command, tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(BAD_FILE)
    done = command("show", path, "--json", check=False)
    with pytest.raises(fabkit.FabkitError) as caught:
        fabkit.load(path)
    error = caught.value
    document = json.loads(done.stdout)
    assert (error.code, error.exit_code) == ("bad-input", done.returncode)
    # Python has the value as written; the command has it as a number too.
    told = [{**problem, "value": problem["written"]} for problem in document["problems"]]
    for problem, one in zip(error.problems, told, strict=True):
        assert vars(problem) == {name: one[name] for name in vars(problem)}
    assert (error.file, error.line, error.hint) == (
        str(path),
        5,
        "did you mean `thickness`?",
    )
    text = command("show", path, check=False).stderr
    assert str(error) == text.removeprefix("error: ").rstrip("\n")


def test_errors_are_builtin_exceptions_too(rtac0):
    with pytest.raises(ValueError, match="there is no sensor `rtac1`"):
        fabkit.load("rtac1")
    with pytest.raises(KeyError, match="there is no part `shel`"):
        rtac0.parts["shel"]
    assert rtac0.parts.get("shel") is None
    with pytest.raises(fabkit.FabkitError) as caught:
        fabkit.Camera.load("no-such-file.yaml")
    assert (caught.value.code, caught.value.exit_code) == ("io", 4)
    assert not isinstance(caught.value, ValueError)


@pytest.mark.parametrize(
    ("call", "message", "hint"),
    [
        (lambda s: fabkit.load("rtac0", coat__thicknes="1 mm"), "coat.thicknes", "coat.thickness"),
        (lambda s: fabkit.load("rtac0", coat__thickness=0.1), "0.1", "mm"),
        (lambda s: fabkit.load("rtac0", coat__thickness={}), "is a dict", None),
        (
            lambda s: fabkit.load("rtac0", {"coat.thickness": "1mm"}, coat__thickness="1mm"),
            "twice",
            None,
        ),
        (lambda s: s.fixtures["pin-domes"], "`pin-domes`", "did you mean `pin-dome`?"),
        (lambda s: s.layers["gel"].mesh(), "`gel`", "translucent-gel"),
        (lambda s: s.parts["shell"].mesh(50.0), "50 mm", None),
        (lambda s: s.parts["shell"].export("shell.obj"), "ending", ".stl"),
        (lambda s: s.parts["shell"].export("shell.dxf"), "shell", "stl,3mf"),
        (lambda s: s.export("out", formats=["stlx"]), "`stlx`", "did you mean `stl`?"),
        (lambda s: s.picture(assembly="sensr"), "`sensr`", "did you mean `sensor`?"),
        (lambda s: s.picture(size_px=(100_000, 100_000)), "above the limit", "smaller"),
        (lambda s: fabkit.depth.cast(s, "semi-dome-999"), "`semi-dome-999`", "semi-dome-099"),
        (lambda s: fabkit.depth.cast(s, "hemisphere@30deg,0deg,9mm"), "9 mm", None),
        (lambda s: fabkit.depth.cast(s, samples=99), "99 samples", None),
        (lambda s: fabkit.depth.cast(s, membrane_mm=np.nan), "NaN mm", None),
        (lambda s: fabkit.depth.cast(s, pose=np.eye(3)), "the shape (3, 3)", None),
        (lambda s: fabkit.depth.cast(s, pose=2 * np.eye(4)), "last row", None),
        (lambda s: s.camera.project([[1.0, 2.0]]), "(1, 2); it must be (..., 3)", None),
        (lambda s: s.camera.project([["a", "b", "c"]]), "dtype <U1", None),
        (lambda s: s.camera.unproject(np.zeros((4, 3))), "(4, 3); it must be (..., 2)", None),
        (lambda s: s.camera.with_parameters({"cx": 1.0}), "`cx`", "cx_px"),
        (lambda s: s.camera.to_text("yaml"), "`yaml`", "fabkit, opencv, ros, kalibr"),
        (lambda s: fabkit.dataset.open("no-such-folder"), "no-such-folder", "fabkit.dataset.write"),
    ],
)
def test_error_names_the_wrong_value(rtac0, call, message, hint):
    with pytest.raises(fabkit.FabkitError) as caught:
        call(rtac0)
    assert message in str(caught.value)
    assert hint is None or hint in (caught.value.hint or "")


def test_errors_can_be_pickled():
    with pytest.raises(fabkit.FabkitError) as caught:
        fabkit.load("rtac0", coat__thickness="4 mm")
    again = pickle.loads(pickle.dumps(caught.value))
    assert type(again) is type(caught.value)
    assert str(again) == str(caught.value)
    assert (again.problems, again.code) == (caught.value.problems, "bad-input")


def test_panic_becomes_a_fabkit_error(capfd):
    from fabkit import _fabkit

    with pytest.raises(fabkit.FabkitError) as caught:
        _fabkit.fall()
    assert (caught.value.code, caught.value.exit_code) == ("bug", 70)
    assert "on purpose" in capfd.readouterr().err


def test_every_binding_catches_panics():
    from pathlib import Path

    sources = Path(__file__).parent.parent / "src"
    bare = [path.name for path in sources.glob("*.rs") if "py.detach(" in path.read_text()]
    # The first catches panics itself; in the second the command does.
    assert sorted(bare) == ["command.rs", "running.rs"]


def test_a_changed_file_is_not_replaced_by_an_export(rtac0, tmp_path):
    coupon = rtac0.fixtures["coupon"]
    coupon.export(tmp_path, formats=["stl"])
    (tmp_path / "coupon.yaml").write_text("mine")
    with pytest.raises(ValueError, match=r"coupon\.yaml was changed"):
        coupon.export(tmp_path, formats=["stl"])
    assert (tmp_path / "coupon.yaml").read_text() == "mine"
    manifest = coupon.export(tmp_path, formats=["stl"], force=True)
    assert "coupon.yaml" in [file["name"] for file in manifest["files"]]


@pytest.mark.parametrize("wrong", [None, 7, 1.5, ["rtac0"], b"rtac0", object()])
def test_what_is_no_sensor_is_a_type_error_that_says_so(wrong, tmp_path):
    calls = [
        lambda: fabkit.sim.Sensor(wrong),
        lambda: fabkit.depth.Scene(wrong),
        lambda: fabkit.press(wrong, "ball@0mm,0mm", 0.5),
        lambda: fabkit.check(wrong),
        lambda: fabkit.export(wrong, tmp_path),
        lambda: fabkit.sim.Skin(wrong),
        lambda: fabkit.sim.MarkFollower(wrong, np.zeros((4, 4))),
    ]
    for call in calls:
        with pytest.raises(TypeError, match=r"it must be what `fabkit\.load` returns, or a name"):
            call()
