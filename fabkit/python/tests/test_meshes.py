"""Meshes as arrays."""

import base64
import io
import json
from html.parser import HTMLParser

import numpy as np
import pytest
import trimesh

import fabkit


def test_array_shapes_and_types(rtac0):
    mesh = rtac0.parts["base"].mesh(tolerance_mm=0.02)
    assert (mesh.vertices.dtype, mesh.triangles.dtype) == (np.float64, np.uint32)
    assert mesh.vertices.flags.c_contiguous
    assert mesh.triangles.flags.c_contiguous
    # Each access returns the mesh's own memory.
    assert np.shares_memory(mesh.vertices, mesh.vertices)
    assert mesh.leaves.shape == (len(mesh.triangles),)


def test_trimesh_measures_the_same(rtac0):
    for body in [rtac0.parts["shell"], rtac0.parts["base"], rtac0.layers["black-coat"]]:
        mesh = body.mesh(tolerance_mm=0.02)
        theirs = mesh.to_trimesh()
        assert theirs.is_watertight
        assert theirs.is_winding_consistent
        # Rounding: sums of at most 1e5 terms in another order.
        assert mesh.volume_mm3 == pytest.approx(theirs.volume, rel=1e-10)
        assert mesh.area_mm2 == pytest.approx(theirs.area, rel=1e-10)
        assert theirs.euler_number == 2 - 2 * mesh.genus


def test_a_tighter_tolerance_approaches_the_solid(rtac0):
    gel = rtac0.layers["translucent-gel"]
    volumes = [gel.mesh(tolerance).volume_mm3 for tolerance in (0.04, 0.02, 0.01, 0.001)]
    errors = [abs(volume - volumes[-1]) for volume in volumes[:-1]]
    assert errors[0] > errors[1] > errors[2]


def test_a_mesh_is_written_in_its_own_frame(rtac0, tmp_path):
    mesh = rtac0.parts["base"].mesh()
    mesh.export(tmp_path / "base.stl")
    read = trimesh.load(tmp_path / "base.stl")
    # STL holds 32-bit numbers: half a spacing at 16 mm, and repair may move by 64 of them.
    assert np.abs(read.bounds - [mesh.vertices.min(0), mesh.vertices.max(0)]).max() < 1e-4
    with pytest.raises(fabkit.FabkitError, match=r"\.stl"):
        mesh.export(tmp_path / "base.obj")


class _Frames(HTMLParser):
    """A parser that collects the content of frames."""

    def __init__(self):
        super().__init__()
        self.frames = []

    def handle_starttag(self, tag, attrs):
        if tag == "iframe":
            self.frames.append(dict(attrs))


def test_notebooks_show_a_model_to_turn(rtac0):
    shown = _Frames()
    shown.feed(rtac0._repr_html_())
    (frame,) = shown.frames
    assert frame["sandbox"] == "allow-scripts"
    assert frame["title"] == rtac0.title
    page = rtac0.page()
    assert frame["srcdoc"] == page
    data = json.loads(page.split('<script type="application/json">')[1].split("</script>")[0])
    glb = base64.b64decode(data["glb"])
    scene = trimesh.load(io.BytesIO(glb), file_type="glb")
    assert {*rtac0.layers} - {*scene.geometry} == set()
    # The page shows the camera's rays and the pressed surface.
    assert len(data["rays"]["rays"]) == 82
    assert "translucent-gel" in data["pressed"]["instead_of"]


def test_notebooks_show_pictures(rtac0):
    png = b"\x89PNG\r\n\x1a\n"
    assert rtac0.parts["shell"]._repr_png_().startswith(png)
    assert rtac0._repr_png_().startswith(png)
    truth = fabkit.depth.cast(rtac0, "semi-dome-017")
    assert truth._repr_png_().startswith(png)
