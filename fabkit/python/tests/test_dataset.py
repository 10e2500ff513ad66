"""Data sets of the command and of the package."""

import concurrent.futures
import multiprocessing
import pickle
import shutil

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


def tree(folder):
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def test_stitched_and_written_samples_are_equal(folders):
    stitched = fabkit.dataset.open(folders / "stitched")
    written = fabkit.dataset.open(folders / "written")
    assert len(stitched) == len(written) == len(PATTERNS) ** 2
    for a, b in zip(stitched, written, strict=True):
        assert a.keys() == b.keys() == {"indentation_mm", "label"}
        for name in a:
            assert a[name].dtype == b[name].dtype
            np.testing.assert_array_equal(a[name], b[name])


def test_samples_are_chosen_like_items_of_a_list(folders):
    data = fabkit.dataset.open(folders / "stitched")
    numbers = list(range(len(data)))
    assert len(numbers) == 9
    for part in (
        slice(2, 5),
        slice(None, None, 2),
        slice(None, None, -1),
        slice(-3, None),
        slice(9, 9),
    ):
        chosen = data[part]
        np.testing.assert_array_equal(chosen.halves, data.halves[part])
        assert [a["label"].sum() for a in chosen] == [data[i]["label"].sum() for i in numbers[part]]
    odd = np.arange(len(data)) % 2 == 1
    for some in ([3, -1], np.array([3, 8]), odd, []):
        np.testing.assert_array_equal(
            data[some].halves, data.halves[some if len(some) else slice(0)]
        )
    # A selection of a selection, with its range map.
    again = data[::2][1:3]
    np.testing.assert_array_equal(again.halves, data.halves[[2, 4]])
    np.testing.assert_array_equal(again.range_mm(-1), data.range_mm(4))
    np.testing.assert_array_equal(data[np.int64(4)]["label"], data[4]["label"])
    assert len(data) == 9, "the whole is as it was"
    for wrong in (9, -10, [0, 9]):
        with pytest.raises(IndexError, match="there are 9"):
            data[wrong]
    for wrong in (np.array([0.5]), np.array([True]), np.zeros((2, 2), dtype=int)):
        with pytest.raises(fabkit.InvalidInputError, match="9 booleans"):
            data[wrong]


def test_halves_equal_ground_truth(folders, rtac0):
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


def test_data_set_from_python_equals_the_commands(folders, rtac0, tmp_path):
    told = []
    presses = folders / "presses.txt"
    data = fabkit.dataset.write(
        rtac0, tmp_path / "mine", presses=presses, progress=lambda *at: told.append(at)
    )
    assert len(data) == 9
    assert told[-1][0] == told[-1][1]

    assert tree(tmp_path / "mine") == tree(folders / "stitched")
    with pytest.raises(fabkit.FabkitError, match="not empty"):
        fabkit.dataset.write(rtac0, tmp_path / "mine", presses=presses)
    # With `resume`, a finished data set needs no work.
    fabkit.dataset.write(rtac0, tmp_path / "mine", presses=presses, resume=True)
    with pytest.raises(fabkit.FabkitError, match="seam_margin_mm: -1 mm"):
        fabkit.dataset.write(rtac0, tmp_path / "other", seam_margin_mm=-1)


class Losing:
    """An executor that runs tasks in this thread and loses the first ones."""

    def __init__(self, losses):
        self.losses = losses
        self.submitted = 0

    def submit(self, work, *arguments):
        """Run the task at once, or lose it."""
        self.submitted += 1
        future = concurrent.futures.Future()
        if self.submitted <= self.losses:
            future.set_exception(RuntimeError("the worker died"))
        else:
            # Pickle and unpickle, as for another process.
            work, arguments = pickle.loads(pickle.dumps((work, arguments)))
            future.set_result(work(*arguments))
        return future


@pytest.mark.parametrize("kind", ["stitched", "written"])
def test_halves_from_an_executor_are_the_same_bytes(folders, rtac0, tmp_path, kind):
    options = {"presses": folders / "presses.txt", "materialise": kind == "written"}
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=context) as executor:
        fabkit.dataset.write(rtac0, tmp_path / "mine", executor=executor, **options)
    assert tree(tmp_path / "mine") == tree(folders / kind)


def test_lost_shards_are_tried_again_and_finished_ones_are_kept(folders, rtac0, tmp_path):
    options = {"presses": folders / "presses.txt"}
    executor = Losing(losses=2)
    fabkit.dataset.write(rtac0, tmp_path / "again", executor=executor, **options)
    # Six halves fit into one shard.
    assert executor.submitted == 3
    assert tree(tmp_path / "again") == tree(folders / "stitched")

    with pytest.raises(fabkit.FabkitError, match="shards 0 to 0 failed 2 times") as error:
        fabkit.dataset.write(rtac0, tmp_path / "lost", executor=Losing(9), retries=1, **options)
    assert "resume=True" in error.value.hint
    fabkit.dataset.write(rtac0, tmp_path / "lost", resume=True, **options)
    assert tree(tmp_path / "lost") == tree(folders / "stitched")


def test_sensors_and_scenes_can_be_pickled(rtac0, tmp_path):
    file = tmp_path / "thin.yaml"
    file.write_text("format: 1\nextends: rtac0\nname: thin\n")
    sensor = fabkit.load(file, coat__thickness="0.1 mm")
    there = pickle.loads(pickle.dumps(sensor))
    assert there.parameters["coat.thickness"] == sensor.parameters["coat.thickness"]
    pose = np.linalg.inv(rtac0.sensor_from_camera)
    pose[2, 3] += 0.5
    camera = rtac0.camera.resized(80, 60)
    covariance = np.eye(6) * 1e-4
    scene = fabkit.depth.Scene(rtac0, camera=camera, pose=pose, pose_covariance=covariance)
    again = pickle.loads(pickle.dumps(scene))
    np.testing.assert_array_equal(scene.cast().sigma_mm, again.cast().sigma_mm)
    np.testing.assert_array_equal(scene.sensor_from_camera, again.sensor_from_camera)


def test_splits_share_no_pattern(folders):
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


def test_damaged_files_are_errors(folders, tmp_path):
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
        assert "resume=True" in caught.value.hint
    finally:
        shard.write_bytes(whole)


def read_all(folder):
    """Read everything that a training would read."""
    data = fabkit.dataset.open(folder)
    for sample in data:
        assert sample["indentation_mm"].shape == data.reference["is_left"].shape


@pytest.mark.parametrize("kind", ["stitched", "written"])
def test_every_flipped_bit_is_an_error(folders, tmp_path, kind):
    shutil.copytree(folders / kind, tmp_path / "set")
    random = np.random.default_rng(1)
    read_all(tmp_path / "set")
    group = "samples" if kind == "written" else "halves"
    # The card and the groups' metadata are not read; only `--resume` compares them.
    files = [tmp_path / "set" / name for name in ("dataset.json", "samples.csv", "reference.npz")]
    arrays = [path for path in (tmp_path / "set" / group).rglob("*") if path.is_file()]
    files += [path for path in arrays if path.parent.name != group]
    assert len(files) >= 7
    for path in files:
        whole = path.read_bytes()
        for bit in (0, 8 * len(whole) - 1, *random.integers(0, 8 * len(whole), 2)):
            flipped = bytearray(whole)
            flipped[bit // 8] ^= 1 << (bit % 8)
            path.write_bytes(flipped)
            with pytest.raises(fabkit.FabkitError, match=path.name) as caught:
                read_all(tmp_path / "set")
            assert caught.value.code == "io"
        path.write_bytes(whole)
    read_all(tmp_path / "set")


def test_invalid_metadata_is_an_error(folders, tmp_path):
    path = folders / "stitched/halves/label/zarr.json"
    whole = path.read_text()
    shape = '"shape": [\n    6,\n    480,\n    640\n  ]'
    assert shape in whole
    try:
        for rows in (0, 73, 10**6, 2**31, 2**62):
            path.write_text(whole.replace(shape, shape.replace("480", str(rows))))
            with pytest.raises(fabkit.FabkitError, match=r"zarr\.json") as caught:
                fabkit.dataset.open(folders / "stitched")
            assert caught.value.exit_code in (2, 4)
    finally:
        path.write_text(whole)


def test_data_from_workers_is_validated(folders, rtac0, tmp_path):
    class Lying(Losing):
        """An executor that returns given data instead of a shard."""

        def __init__(self, files):
            super().__init__(0)
            self.files = files

        def submit(self, work, *arguments):
            """Return the data at once."""
            future = concurrent.futures.Future()
            future.set_result((self.files, None))
            return future

    options = {"presses": folders / "presses.txt"}
    shard = "halves/label/c/0/0/0"
    right = (folders / "stitched" / shard).read_bytes()
    names = ["../x", str(tmp_path / "x"), "halves/label/../x", "dataset.json", "samples.csv", "x"]
    sent = [(name, right) for name in names]
    sent += [(shard, b""), (shard, right[:-1]), (shard, bytes([right[0] ^ 1]) + right[1:])]
    for number, file in enumerate(sent):
        folder = tmp_path / f"{number}"
        with pytest.raises(fabkit.FabkitError) as caught:
            fabkit.dataset.write(rtac0, folder, executor=Lying([file]), **options)
        assert f"a worker sent `{file[0]}`" in str(caught.value)
        assert not (tmp_path / "x").exists()
        assert not (folder / "halves").exists()
    # The folder is still valid and can be finished.
    fabkit.dataset.write(rtac0, tmp_path / "0", resume=True, **options)
    assert tree(tmp_path / "0") == tree(folders / "stitched")


def test_one_process_writes_at_a_time(folders, rtac0, tmp_path):
    class Second(Losing):
        """An executor whose tasks write to the same folder."""

        def submit(self, work, *arguments):
            """Try to write to the folder, then run the task."""
            with pytest.raises(fabkit.FabkitError, match="is being written to by process"):
                fabkit.dataset.write(rtac0, tmp_path / "mine", resume=True, **options)
            return super().submit(work, *arguments)

    options = {"presses": folders / "presses.txt"}
    fabkit.dataset.write(rtac0, tmp_path / "mine", executor=Second(0), **options)
    assert tree(tmp_path / "mine") == tree(folders / "stitched")
