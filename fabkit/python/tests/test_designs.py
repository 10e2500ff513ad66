"""Sensors as objects: values, changes, build steps, and names that completion offers."""

from __future__ import annotations

import copy
import importlib
import pickle
import warnings
from pathlib import Path

import pytest

import fabkit


def test_values_are_numbers_in_their_units(rtac0: fabkit.Sensor) -> None:
    radius = rtac0.parameters["surface.radius"]
    assert (radius.value, radius.unit, radius.written, str(radius)) == (
        15.0,
        "mm",
        "15 mm",
        "15 mm",
    )
    assert radius.limit == {"min": 8.0, "max": 60.0, "unit": "mm", "choices": []}
    assert rtac0.surface.radius == 15.0
    # `camera` is the Camera object, not the section of parameters.
    assert rtac0.values.camera.field_of_view == 160.0
    assert rtac0.leds.count == 8
    assert "radius" in dir(rtac0.surface)
    assert {"surface", "coat", "export"} <= set(dir(rtac0))
    assert repr(rtac0.surface) == "<radius: 15 mm, wall_height: 6 mm>"
    with pytest.raises(AttributeError, match=r"surface\.radius"):
        _ = rtac0.surface.radios
    with pytest.raises(AttributeError, match="surfaces"):
        _ = rtac0.surfaces
    dome = rtac0.fixtures["pin-dome"]
    assert next(iter(dome.parameters)).startswith("fixtures.pin_dome.")
    assert dome.fixtures.pin_dome.captures.pins == 5


def test_replace_changes_parameters(rtac0: fabkit.Sensor) -> None:
    thin = fabkit.load("rtac0", coat__thickness="0.1 mm")
    wide = thin.replace(surface__radius=1.1 * thin.surface.radius)
    assert (wide.surface.radius, wide.coat.thickness) == (16.5, 0.1)
    assert thin.surface.radius == 15.0
    # Derived values follow the change, and overrides can be changed again.
    assert wide.tube.outer_diameter == 27.0
    assert (
        wide.replace({"coat.thickness": rtac0.parameters["coat.thickness"]}).coat.thickness == 0.05
    )
    assert wide.replace(leds__count=7).leds.count == 7
    # It is pickled as its source and overrides.
    assert pickle.loads(pickle.dumps(wide)).design_hash == wide.design_hash
    assert copy.copy(wide).design_hash == wide.design_hash
    with pytest.raises(fabkit.InvalidInputError) as caught:
        thin.replace(surface__radius=900)
    problem = caught.value.problems[0]
    assert (problem.code, problem.value) == ("out_of_range", "900 mm")
    assert problem.suggestion == {"path": "surface.radius", "value": "35 mm"}
    assert problem.limit is not None
    assert problem.limit["max"] == 60.0


def test_build_steps_and_components(rtac0: fabkit.Sensor) -> None:
    steps = {step.name: step for step in rtac0.chain}
    pour = steps["pour-transparent-gel"]
    assert pour.batch is not None
    assert pour.action == "pour"
    assert pour.batch["layer"] == "transparent-gel"
    assert pour.cure is not None
    assert pour.cure["hours"] > 0
    bought = rtac0.bought
    assert [body.name for body in bought] == list(rtac0.components)
    assert all(body.quantity > 0 and body.summary for body in bought)
    assert rtac0.fixtures["pin-dome"].bought


def test_lengths_are_numbers_or_texts(rtac0: fabkit.Sensor, tmp_path: Path) -> None:
    base = rtac0.parts["base"]
    assert len(base.mesh("50 um").triangles) == len(base.mesh(0.05).triangles)
    both = [
        rtac0.export(tmp_path / name, parts=["base"], formats=["stl"], tolerance_mm=tolerance)
        for name, tolerance in (("number", 0.05), ("text", "0.05 mm"))
    ]
    assert both[0]["files"] == both[1]["files"]
    rtac0.export(tmp_path / "bed", parts=["base"], formats=["3mf"], bed_mm=("20 cm", 200.0))
    for text, says in (("50", "no unit"), ("50 deg", "length"), ("wide", "not a number")):
        with pytest.raises(fabkit.InvalidInputError, match=says) as caught:
            base.mesh(text)
        assert "tolerance_mm" in str(caught.value)
        assert caught.value.hint


@pytest.mark.parametrize(
    "name",
    [
        "",
        ".bodies",
        ".calibrate",
        ".dataset",
        ".depth",
        ".designs",
        ".errors",
        ".parameters",
        ".sweep",
    ],
)
def test_completion_offers_what_is_public(name: str) -> None:
    module = importlib.import_module(f"fabkit{name}")
    offered = dir(module)
    assert sorted(offered) == sorted(module.__all__)
    assert not {"np", "os", "json", "csv", "annotations"} & set(offered)
    assert all(hasattr(module, one) for one in offered)


def test_values_that_change_nothing_are_warned_about():
    with pytest.warns(fabkit.DesignWarning, match=r"mount.width = 31 mm changes nothing") as told:
        sensor = fabkit.load("rtac0", mount__width="31 mm")
    # The warning names the line that sets the value, not one of the package's.
    assert told[0].filename == __file__
    with pytest.warns(fabkit.DesignWarning, match=r"it counts if base.cable_exit is `floor`"):
        sensor.replace(base__cable_angle="90 deg")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fabkit.load("rtac0", coat__thickness="0.1 mm").replace(shell__wall=1.6)
