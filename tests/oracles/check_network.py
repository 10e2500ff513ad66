"""Compares R-Tac0's published network on simulated and on real captures of pins.

    python check_network.py PATH_TO_FABKIT CAPTURES NETWORK.onnx CAMERA.yaml

CAPTURES is a folder of the published captures of pins, with `ref.png` and `holes.json`. Each is simulated with light
constants that are fitted to all of them (`fit-light`), and with pins as deep as the fit says, and a bit deeper. The
network's input is that of its authors: both images blurred by 5 x 5, their difference less 3, clipped at 47, over 47;
its output times 2 mm is the depth. Needs onnxruntime, numpy, scipy, pillow. On demand: neither the captures nor the
network are in this repository.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import onnxruntime
from PIL import Image
from scipy import ndimage

RINGS_DEG = [0, 18, 36, 54, 72]
NEAR_PX = 12
# Radius of the authors' mask around the tip's pixel, px.
MASK_PX = 200


def ring(hole: int) -> int:
    return next(i for i, last in enumerate([1, 5, 13, 21, 29]) if hole <= last)


def grey(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path).convert("L")).astype(np.float32)


def blurred(picture: np.ndarray) -> np.ndarray:
    # A window of 5 x 5 px, sigma 5 px.
    return ndimage.gaussian_filter(picture, 5, radius=2)


class Network:
    def __init__(self, file: str) -> None:
        self.session = onnxruntime.InferenceSession(file)

    def depth_mm(self, reference: np.ndarray, capture: np.ndarray) -> np.ndarray:
        difference = np.clip(blurred(reference) - blurred(capture) - 3, 0, 47) / 47
        name = self.session.get_inputs()[0].name
        return 2 * self.session.run(None, {name: difference[None, None]})[0][0, 0]


def main() -> None:
    fabkit, captures, network, camera = sys.argv[1:]
    folder, network = Path(captures), Network(network)
    reference = folder / "ref.png"

    def run(*words: str) -> dict:
        done = subprocess.run([fabkit, *words, "--json"], capture_output=True, text=True, check=True)
        return json.loads(done.stdout)

    with tempfile.TemporaryDirectory() as scratch:
        light, pose = Path(scratch) / "light.json", Path(scratch) / "pose.yaml"
        common = ("--camera", camera, "--captures", captures, "--landmarks", str(folder / "holes.json"))
        fitted = run("fit-light", "rtac0", *common, "--reference", str(reference), "-o", str(light))
        run("calibrate", "extrinsics", "rtac0", *common, "-o", str(pose))
        found_mm = fitted["pin_depth_mm"]
        readings: dict[str, list[list[float]]] = {}

        def read(name: str, before: Path, pressed: Path, holes: list[int], pixels: np.ndarray) -> None:
            depth = network.depth_mm(grey(before), grey(pressed))
            rows, columns = np.mgrid[: depth.shape[0], : depth.shape[1]]
            rings = readings.setdefault(name, [[] for _ in RINGS_DEG])
            for hole, (x, y) in zip(holes, pixels, strict=True):
                rings[ring(hole)].append(depth[np.hypot(columns - x, rows - y) < NEAR_PX].max())

        files = sorted(file for file in folder.glob("*.png") if file.name != "ref.png")
        where = run("calibrate", "pins", "--reference", str(reference), *map(str, files))
        for image, file in zip(where["images"], files, strict=True):
            holes = [int(hole) for hole in file.stem.split("_")]
            pixels = np.array([pin["pixel"] for pin in image["pins"]])
            if len(pixels) != len(holes):
                continue
            # The order of real pins follows from the pixels of simulated pins in the same holes.
            names = [word for hole in holes for word in ("--press", f"pin-{hole}-long")]
            for depth_mm in (found_mm, 1.45):
                length = f"fixtures.pin_dome.pins.lengths=[5mm,{4.65 + depth_mm:.3f}mm]"
                design = ("rtac0", "--set", "fixtures.pin_dome.pins.diameter=1.6mm", "--set", length)
                view = ("--camera", camera, "--constants", str(light), "--spacing", "0.3mm")
                rest, pressed = Path(scratch) / "rest.png", Path(scratch) / "pressed.png"
                truth = Path(scratch) / "truth.npz"
                run("capture", *design, *view, "--reference", "-o", str(rest), "--seed", "99")
                more = ("--truth", str(truth), "--seed", str(holes[1]))
                run("capture", *design, *view, *names, "-o", str(pressed), *more)
                with np.load(truth) as arrays:
                    labels, words = arrays["label"], list(arrays["label_names"])
                centres = []
                for hole in holes:
                    label = next(i for i, word in enumerate(words) if f"pin-{hole}-long" in str(word))
                    rows, columns = np.nonzero(labels == label)
                    centres.append((columns.mean(), rows.mean()))
                read(f"simulated, {depth_mm:.2f} mm deep", rest, pressed, holes, np.array(centres))
            # Each hole's real pin is the one nearest to its simulated pin.
            away = np.linalg.norm(pixels[None] - np.array(centres)[:, None], axis=2)
            read("real", reference, file, holes, pixels[away.argmin(axis=1)])
        print("network's reading, median mm, by ring: ", RINGS_DEG, "deg")
        for name, rings in sorted(readings.items()):
            medians = [f"{np.median(of):.2f}" if of else "-" for of in rings]
            print(f"{name}: {', '.join(medians)}  ({sum(map(len, rings))} pins)")


if __name__ == "__main__":
    main()
