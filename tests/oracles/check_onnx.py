"""Compares fabkit's evaluation of networks with ONNX Runtime: outputs must agree to 1e-5, relative if above 1.

    cargo build --release -p fabkit-network --example evaluate
    python check_onnx.py target/release/examples/evaluate [NETWORK.onnx [REFERENCE CAPTURE...]]

It evaluates random networks of many forms on random images. NETWORK.onnx is compared as well, on a random image, or on
captures that are prepared as R-Tac0's authors do, with the time on one core and the share of touched pixels. Needs
onnx, onnxruntime, numpy, scipy, pillow. On demand.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
from onnx import TensorProto, helper, numpy_helper
from PIL import Image
from scipy import ndimage

BOUND = 1e-5


def random_network(random: np.random.Generator) -> bytes:
    """Creates a random chain of convolutions with all supported operators between them."""
    nodes, constants, channels, name = [], [], 1, "x"

    def constant(values) -> str:
        constants.append(numpy_helper.from_array(np.float32(values), f"c{len(constants)}"))
        return constants[-1].name

    def node(operator: str, *inputs: str, **attributes) -> None:
        nonlocal name
        output = f"t{len(nodes)}"
        nodes.append(helper.make_node(operator, [name, *inputs], [output], **attributes))
        name = output

    count = int(random.integers(1, 5))
    for i in range(count):
        outputs = 1 if i + 1 == count else int(random.choice([1, 3, 8, 16, 20, 33]))
        groups = 1
        if outputs % channels == 0 and channels > 1 and random.random() < 0.6:
            groups = channels
        elif channels % 2 == outputs % 2 == 0 and random.random() < 0.5:
            groups = 2
        rows, columns = (int(2 * random.integers(0, 4) + 1) for _ in range(2))
        per_group = channels // groups
        scale = 1 / np.sqrt(per_group * rows * columns)
        weights = constant(scale * random.standard_normal((outputs, per_group, rows, columns)))
        bias = [constant(random.standard_normal(outputs))] if random.random() < 0.8 else []
        pads = [rows // 2, columns // 2] * 2
        how = {"auto_pad": "SAME_UPPER"} if random.random() < 0.3 else {"pads": pads}
        node("Conv", weights, *bias, group=groups, **how)
        channels = outputs
        between = random.choice(["Relu", "Relu", "Clip", "Sigmoid", "Add", "Sub", "Mul", "Div", "Identity"])
        if between == "Clip":
            node("Clip", constant(-0.5), constant(1.5))
        elif between in ("Add", "Sub", "Mul", "Div"):
            shape = () if random.random() < 0.5 else (channels, 1, 1)
            node(between, constant(random.uniform(0.5, 2, shape)))
        else:
            node(between)
    any_size = [1, 1, "rows", "columns"]
    nodes[-1].output[0] = "y"
    graph = helper.make_graph(
        nodes,
        "random",
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, any_size)],
        [helper.make_tensor_value_info("y", TensorProto.FLOAT, any_size)],
        constants,
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
    onnx.checker.check_model(model)
    return model.SerializeToString()


class Compared:
    """A network, evaluated by fabkit and by ONNX Runtime."""

    def __init__(self, evaluate: str, network: Path, folder: Path) -> None:
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = 1
        self.session = onnxruntime.InferenceSession(network, options)
        self.evaluate, self.network, self.folder = evaluate, network, folder

    def ours(self, picture: np.ndarray, *words: str) -> tuple[np.ndarray, float]:
        given, found = self.folder / "in.f32", self.folder / "out.f32"
        picture.astype("<f4").tofile(given)
        command = [self.evaluate, self.network, given, str(picture.shape[1]), found, *words]
        one = os.environ | {"RAYON_NUM_THREADS": "1"}
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=one)
        return np.fromfile(found, "<f4").reshape(picture.shape), float(done.stdout)

    def worst(self, picture: np.ndarray) -> tuple[float, str]:
        """Returns the largest difference, and the times in words."""
        picture = picture.astype(np.float32)
        start = time.perf_counter()
        theirs = self.session.run(None, {self.session.get_inputs()[0].name: picture[None, None]})[0][0, 0]
        theirs_s = time.perf_counter() - start
        everything, dense_s = self.ours(picture)
        touched, touched_s = self.ours(picture, "touched")
        where = picture != 0
        assert np.array_equal(touched, np.where(where, everything, 0)), "touched pixels differ"
        off = float((np.abs(everything - theirs) / np.maximum(1, np.abs(theirs))).max())
        words = f"ONNX Runtime {theirs_s:.3f} s, everything {dense_s:.3f} s, touched {touched_s:.4f} s"
        return off, f"{words} ({100 * where.mean():.2f} %)"


def prepared(reference: Path, capture: Path) -> np.ndarray:
    def blurred(path: Path) -> np.ndarray:
        picture = np.asarray(Image.open(path).convert("L")).astype(np.float32)
        return ndimage.gaussian_filter(picture, 5, radius=2, mode="mirror")

    return np.clip(blurred(reference) - blurred(capture) - 3, 0, 47) / 47


def main() -> None:
    evaluate, *more = sys.argv[1:]
    evaluate = str(Path(evaluate).resolve())
    random, worst = np.random.default_rng(1), 0.0
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for _ in range(60):
            network = folder / "random.onnx"
            network.write_bytes(random_network(random))
            picture = random.standard_normal(random.integers(1, 90, 2))
            picture[random.random(picture.shape) < 0.5] = 0
            worst = max(worst, Compared(evaluate, network, folder).worst(picture)[0])
        print(f"60 random networks: {worst:.1e} (bound {BOUND})")
        if more:
            compared = Compared(evaluate, Path(more[0]), folder)
            reference, captures = (Path(more[1]), more[2:]) if more[1:] else (None, [])
            pictures = {name: prepared(reference, Path(name)) for name in captures}
            if not pictures:
                pictures = {"random": random.uniform(0, 1, (100, 120))}
            for name, picture in pictures.items():
                off, words = compared.worst(picture)
                print(f"{Path(name).name}: {off:.1e}; {words}")
                worst = max(worst, off)
    assert worst < BOUND, worst


if __name__ == "__main__":
    main()
