"""Data sets that the command wrote."""

import multiprocessing

import numpy as np
import pytest

import fabkit

PATTERNS = ["semi-dome-001", "semi-dome-002", "semi-dome-003"]


@pytest.fixture(scope="module")
def folders(command, tmp_path_factory):
    folder = tmp_path_factory.mktemp("data")
    (folder / "presses.txt").write_text("\n".join(PATTERNS) + "\n")
    for name, flags in {"stitched": [], "written": ["--materialise"]}.items():
        presses = ["--presses", folder / "presses.txt"]
        command("dataset", "rtac0", *presses, *flags, "-o", folder / name)
    return folder


def test_stitched_and_written_samples_are_equal(folders):
    stitched = fabkit.dataset.open(folders / "stitched")
    written = fabkit.dataset.open(folders / "written")
    assert len(stitched) == len(written) == len(PATTERNS) ** 2
    for a, b in zip(stitched, written, strict=True):
        assert a.keys() == b.keys() == {"indentation_mm", "label"}
        for name in a:
            assert a[name].dtype == b[name].dtype
            np.testing.assert_array_equal(a[name], b[name])


def test_halves_are_what_the_camera_sees(folders, rtac0):
    data = fabkit.dataset.open(folders / "written")
    left, right = np.unravel_index(5, (3, 3))
    assert data.halves[5].tolist() == [left, 3 + right]
    both = [
        fabkit.depth.cast(rtac0, PATTERNS[left]),
        fabkit.depth.cast(rtac0, PATTERNS[right] + "-flipped"),
    ]
    sample, range_mm = data[5], data.range_mm(5)
    for side, truth in zip(("is_left", "is_right"), both, strict=True):
        mask = data.reference[side]
        assert mask.any()
        np.testing.assert_array_equal(
            sample["indentation_mm"][mask], truth.indentation_mm[mask].astype(np.float32)
        )
        # Indentation is stored in 32 bits: half a spacing below 2 mm.
        np.testing.assert_allclose(range_mm[mask], truth.range_mm[mask], rtol=0, atol=1.2e-7)


def test_a_data_set_from_python_is_the_commands(folders, rtac0, tmp_path):
    told = []
    presses = folders / "presses.txt"
    data = fabkit.dataset.write(
        rtac0, tmp_path / "mine", presses=presses, progress=lambda *at: told.append(at)
    )
    assert len(data) == 9
    assert told[-1][0] == told[-1][1]

    def tree(folder):
        files = (path for path in folder.rglob("*") if path.is_file())
        return {str(path.relative_to(folder)): path.read_bytes() for path in files}

    assert tree(tmp_path / "mine") == tree(folders / "stitched")
    with pytest.raises(fabkit.FabkitError, match="not empty"):
        fabkit.dataset.write(rtac0, tmp_path / "mine", presses=presses)
    # Nothing is left to do.
    fabkit.dataset.write(rtac0, tmp_path / "mine", presses=presses, resume=True)
    with pytest.raises(fabkit.FabkitError, match="seam_margin_mm: -1 mm"):
        fabkit.dataset.write(rtac0, tmp_path / "other", seam_margin_mm=-1)


def test_splits_share_nothing(folders):
    sizes = {
        split: len(fabkit.dataset.open(folders / "stitched", split))
        for split in ("train", "validation", "test", "mixed")
    }
    assert sum(sizes.values()) == 9
    assert min(sizes["train"], sizes["test"]) >= 1
    with pytest.raises(fabkit.FabkitError, match="`tests`"):
        fabkit.dataset.open(folders / "stitched", "tests")
    with pytest.raises(IndexError):
        fabkit.dataset.open(folders / "stitched")[9]


def deepest(folder):
    return [float(sample["indentation_mm"].max()) for sample in fabkit.dataset.open(folder)]


def test_forked_processes_can_read(folders):
    expected = deepest(folders / "written")
    with multiprocessing.get_context("fork").Pool(2) as pool:
        for found in pool.map(deepest, [folders / "written", folders / "stitched"], 1):
            assert found == expected


def test_damage_is_noticed(folders, tmp_path):
    (tmp_path / "halves").mkdir()
    with pytest.raises(fabkit.FabkitError) as caught:
        fabkit.dataset.open(tmp_path)
    assert caught.value.code == "io"
    shard = next(
        path for path in (folders / "stitched/halves/label/c").rglob("0") if path.is_file()
    )
    whole = shard.read_bytes()
    shard.write_bytes(whole[:-3] + b"abc")
    try:
        with pytest.raises(fabkit.FabkitError, match="damaged") as caught:
            fabkit.dataset.open(folders / "stitched")[0]
        assert "--resume" in caught.value.hint
    finally:
        shard.write_bytes(whole)
