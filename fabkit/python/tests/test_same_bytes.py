"""Python and the command give the same bytes."""

import json

import numpy as np
import pytest

import fabkit


def tree(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_exported_folders_are_equal(command, rtac0, tmp_path):
    formats = ["stl", "3mf", "dxf", "svg", "tree"]
    command("export", "rtac0", "--format", ",".join(formats), "-o", tmp_path / "command")
    manifest = rtac0.export(tmp_path / "python", formats=formats)
    expected = tree(tmp_path / "command")
    assert len(expected) > 40
    assert tree(tmp_path / "python") == expected
    assert json.loads(expected["manifest.json"]) == manifest


def test_options_reach_the_export(command, tmp_path):
    set_ = ["--set", "coat.thickness=0.1mm", "--tolerance", "0.05mm", "--nominal"]
    parts = ["--part", "shell", "--part", "lid-translucent-gel"]
    command("export", "rtac0", *set_, *parts, "--format", "stl", "-o", tmp_path / "command")
    sensor = fabkit.load("rtac0", {"coat.thickness": "0.1 mm"})
    sensor.export(
        tmp_path / "python",
        parts=["shell", "lid-translucent-gel"],
        formats=["stl"],
        tolerance_mm=0.05,
        nominal=True,
    )
    assert tree(tmp_path / "python") == tree(tmp_path / "command")


@pytest.mark.parametrize("ending", [".stl", ".3mf", ".tree.json", ".png"])
def test_a_part_is_exported_alone(command, rtac0, tmp_path, ending):
    # The file is compensated for shrinkage, so it differs from the mesh.
    name = "lid-translucent-gel"
    word = "tree" if ending == ".tree.json" else ending[1:]
    command("export", f"rtac0/{name}", "--format", word, "-o", tmp_path)
    rtac0.parts[name].export(tmp_path / f"mine{ending}")
    mine = (tmp_path / f"mine{ending}").read_bytes()
    assert mine == (tmp_path / f"{name}{ending}").read_bytes()


@pytest.mark.parametrize(
    ("press", "options"),
    [
        ([], {}),
        (["semi-dome-017"], {"membrane_mm": 0.5}),
        (["hemisphere@30deg,120deg,1.2mm"], {"samples": 2, "print_sigma_mm": 0.1}),
        (["ball@30deg,120deg,0.8mm"], {"contact": "linear", "spacing_mm": 0.6}),
        (
            ["ball@30deg,120deg,0.8mm"],
            {"contact": "linear", "spacing_mm": 0.6, "friction": 0.7, "shear_mm": (0.2, -0.1)},
        ),
    ],
)
def test_depth(command, rtac0, tmp_path, press, options):
    flags = [f"--press={name}" for name in press] or ["--reference"]
    words = {
        "membrane_mm": "--membrane={}mm",
        "print_sigma_mm": "--print-sigma={}mm",
        "contact": "--contact={}",
        "spacing_mm": "--spacing={}mm",
        "friction": "--friction={}",
        "shear_mm": "--shear={0[0]}mm,{0[1]}mm",
    }
    flags += [words.get(key, "--samples={}").format(value) for key, value in options.items()]
    command("depth", "rtac0", *flags, "-o", tmp_path / "truth.npz")
    mine = fabkit.depth.cast(rtac0, press, **options).arrays()
    with np.load(tmp_path / "truth.npz") as theirs:
        assert set(mine) == set(theirs)
        for names in ["label_names", "seen_by_names"]:
            assert mine.pop(names) == theirs[names].tolist()
        for name, array in mine.items():
            assert array.dtype == theirs[name].dtype, name
            assert array.shape == theirs[name].shape, name
            assert array.tobytes() == theirs[name].tobytes(), name


def test_depth_of_a_calibrated_camera(command, rtac0, tmp_path):
    camera = rtac0.camera.with_parameters({"cx_px": 300.0, "k1": 0.01})
    camera.save(tmp_path / "camera.yaml")
    pose = np.linalg.inv(rtac0.sensor_from_camera)
    pose[:3, 3] += [0.2, -0.1, 0.3]
    rows = "".join(f"  - {row}\n" for row in pose.tolist())
    (tmp_path / "pose.yaml").write_text(f"camera_from_sensor:\n{rows}")
    out = tmp_path / "truth.npz"
    files = ["--camera", tmp_path / "camera.yaml", "--pose", tmp_path / "pose.yaml"]
    command("depth", "rtac0", "--reference", *files, "-o", out)
    by_values = fabkit.depth.cast(rtac0, camera=camera, pose=pose)
    by_files = fabkit.depth.cast(
        rtac0, camera=tmp_path / "camera.yaml", pose=tmp_path / "pose.yaml"
    )
    with np.load(out) as theirs:
        assert by_values.range_mm.tobytes() == theirs["range_mm"].tobytes()
        assert by_files.range_mm.tobytes() == theirs["range_mm"].tobytes()


def test_landmarks(command, rtac0, tmp_path):
    command("export", "rtac0/pin-dome", "--format", "stl", "-o", tmp_path)
    text = (tmp_path / "pin-dome.landmarks.json").read_bytes()
    dome = rtac0.fixtures["pin-dome"]
    assert dome.files["pin-dome.landmarks.json"] == text
    pins = json.loads(text)["pins"]
    assert len(pins) == len(dome.landmarks)
    for pin, row in zip(pins, dome.landmarks, strict=True):
        assert {name: row[name].tolist() for name in row.dtype.names} == pin


def test_documents(command, rtac0):
    coupon = rtac0.fixtures["coupon"]
    assert coupon.check().document == command("check", "rtac0/coupon", "--json")
    shown = command("show", "rtac0", "--json")
    assert rtac0.design_hash == shown["design_hash"]
    assert [p.value for p in rtac0.parameters.values()] == [p["value"] for p in shown["parameters"]]
    assert [vars(step) for step in rtac0.chain] == command("show", "rtac0", "--chain", "--json")[
        "steps"
    ]
