"""Evaluates simulated captures by the methods of the sensors' papers.

    python check_pictures.py PATH_TO_FABKIT [shadows] [inks] [dots] [skin]

ShadowTac: the authors' detection of dimples in the reference image, written anew from its description (the paper's code
shifts each channel towards its light until the three shadows of a dimple coincide, and marks dark places of the
maximum over channels). UVDtact: markers must be invisible in white light, and a threshold must find them in
ultraviolet. TacTip: number of dots that 30 x 30 pixels resolve, for the paper's four tips. Fluidic sensor:
displacement of markers in the image.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image
from scipy import ndimage
from scipy.spatial import cKDTree

# Constants of the published code: half of a marker's width in the image, px, and the factor by which images shrink.
MARKER_PX, SHRINK = 15, 5
# Side of the authors' crop, and margin at its edge outside of which a dimple is completely inside, px.
CROP_PX, EDGE_PX = 1200, 20
# Sum of the three colours' intensities above which a pixel is not dark.
LIT_GREY = 60
NOISE_GREY = 1.2


class Camera:
    def __init__(self, fabkit: str, folder: Path) -> None:
        self.fabkit, self.folder = fabkit, folder

    def take(self, *words: str) -> tuple[dict, np.ndarray]:
        picture = self.folder / "picture.png"
        run = [self.fabkit, "capture", *words, "-o", str(picture), "--json"]
        done = subprocess.run(run, capture_output=True, text=True, check=True)
        return json.loads(done.stdout), np.asarray(Image.open(picture)).astype(float)


def marks(document: dict) -> np.ndarray:
    return np.array([mark["pixel"] for mark in document["marks"] if mark["pixel"]])


def dimples(picture: np.ndarray, lamps_deg: list[float]) -> np.ndarray:
    """Finds columns and rows of dimples in a square colour image, given the directions of its lights."""
    shifted = []
    for channel, angle in enumerate(np.deg2rad(lamps_deg)):
        blurred = ndimage.uniform_filter(picture[..., channel], 11)
        way = MARKER_PX * np.sin(angle), MARKER_PX * np.cos(angle)
        shifted.append(ndimage.shift(blurred, way, order=1, mode="nearest"))
    value = np.max(shifted, axis=0)[SHRINK // 2 :: SHRINK, SHRINK // 2 :: SHRINK]
    narrow, wide = (
        ndimage.uniform_filter(value, times * MARKER_PX // SHRINK + 1) for times in (2, 6)
    )
    rows, columns = np.mgrid[: value.shape[0], : value.shape[1]]
    middle = value.shape[0] / 2
    mask = (value < 0.85 * (2 * wide - narrow)) & (np.hypot(columns - middle, rows - middle) < middle)
    labels, count = ndimage.label(ndimage.binary_opening(mask))
    areas = ndimage.sum(mask, labels, range(1, count + 1))
    centres = np.array(ndimage.center_of_mass(mask, labels, range(1, count + 1)))[:, ::-1]
    least = (MARKER_PX / SHRINK / 2) ** 2 * np.pi * 0.3
    return SHRINK * centres[(areas > least) & (areas < 300)] + SHRINK // 2


def shadows(camera: Camera) -> bool:
    document, picture = camera.take("shadowtac", "--reference")
    left = (picture.shape[1] - CROP_PX) // 2
    drawn = marks(document) - [left, 0]
    inside = np.hypot(*(drawn - CROP_PX / 2).T) < CROP_PX / 2 - EDGE_PX
    drawn = drawn[inside]
    # Red, blue and green are 120 degrees apart, red on +y, which is up in the image.
    found = dimples(picture[:, left : left + CROP_PX], [90, 330, 210])
    away, _ = cKDTree(found).query(drawn)
    is_found = away < MARKER_PX
    share, error = is_found.mean(), np.median(away[is_found])
    print(f"ShadowTac: {len(drawn)} dimples in view, {100 * share:.1f} % found (at least 95), ", end="")
    print(f"median error {error:.2f} px (below 2), {len(found)} found in all; ", end="")
    # A ray that grazes a dimple's rim must see the coat: single black pixels there would be an error.
    grey = picture.sum(axis=-1).astype(float)
    around = ndimage.minimum_filter(grey, footprint=[[1, 1, 1], [1, 0, 1], [1, 1, 1]])
    middle = slice(EDGE_PX, -EDGE_PX), slice(left + EDGE_PX, left + CROP_PX - EDGE_PX)
    specks = int(((grey < 0.3 * around) & (around > LIT_GREY))[middle].sum())
    print(f"{specks} black specks (none)")
    return share >= 0.95 and error < 2 and specks == 0


def inks(camera: Camera) -> bool:
    with_markers, without = (
        camera.take("uvdtact", "--reference", "--no-noise", *more)[1]
        for more in ((), ("--set", "markers.count=0"))
    )
    seen = np.abs(with_markers - without)
    document, picture = camera.take("uvdtact", "--reference", "--light", "uv", "--samples", "2")
    red, _, blue = (picture[..., channel] for channel in range(3))
    share = np.where(red > 20, blue / np.maximum(red + blue, 1), 0)
    mask = share > ndimage.median_filter(share, 31) + 0.06
    mask[red <= 20] = False
    labels, count = ndimage.label(ndimage.binary_opening(mask, np.ones((2, 2))))
    centres = np.array(ndimage.center_of_mass(mask, labels, range(1, count + 1)))[:, ::-1]
    drawn = marks(document)
    # The drawn position is a slot's end, but the image shows the whole slot, up to its length nearer to the camera.
    away, which = cKDTree(centres).query(drawn)
    is_found = away < 8
    print(f"UVDtact: markers change white pictures by {seen.mean():.3f} grey on average ", end="")
    print(f"(noise {NOISE_GREY}); {is_found.sum()} of {len(drawn)} found in ultraviolet, ", end="")
    print(f"{len(set(which[is_found]))} apart, {count} places in all")
    return seen.mean() < NOISE_GREY and len(set(which[is_found])) == len(drawn)


def dots(camera: Camera) -> bool:
    for tip in "ABCD":
        document, picture = camera.take(
            *("tactip", "--reference", "--samples", "8", "--no-noise", "--set", f"pins.layout={tip}")
        )
        drawn = marks(document)
        peaks = (picture == ndimage.maximum_filter(picture, 3)) & (picture > 0)
        # Peaks at least two of the chip's 64 steps above the darkest neighbour.
        peaks &= picture > ndimage.minimum_filter(picture, 5) + 2 * 255 / 63
        labels, count = ndimage.label(peaks, np.ones((3, 3)))
        centres = np.array(ndimage.center_of_mass(peaks, labels, range(1, count + 1)))[:, ::-1]
        away, which = cKDTree(centres).query(drawn)
        resolved = len(set(which[away < 1.2]))
        print(f"TacTip {tip}: {len(document['marks'])} dots drawn, {len(drawn)} in the picture, ", end="")
        print(f"{resolved} told apart")
    return True


def ends_px(picture: np.ndarray, drawn: np.ndarray) -> np.ndarray:
    """Finds where liquid columns end: the first pixel of the row, from the left, that is half as red as the column."""
    found = []
    for column, row in drawn:
        line = picture[round(row), :, 0] - picture[round(row), :, 1]
        half = line[round(column) + 20 : round(column) + 60].mean() / 2
        # Start the search shortly before the end, to ignore spots elsewhere in the row.
        first = round(column) - 40
        after = first + int(np.argmax(line[first:] > half))
        found.append(after - 1 + (half - line[after - 1]) / (line[after] - line[after - 1]))
    return np.array(found)


def skin(camera: Camera) -> bool:
    is_right = True
    for depth in (2, 5):
        press = ("--press", f"hemisphere@20mm,3mm,{depth}mm", "--spacing", "2mm")
        moves = []
        for light in (("--light", "display", "--samples", "4"), ()):
            taken = [
                camera.take("fluidic", *light, *what, "--no-noise")
                for what in (("--reference",), press)
            ]
            pixels = [np.array([mark["pixel"] for mark in document["marks"]]) for document, _ in taken]
            moves.append(np.hypot(*(pixels[1] - pixels[0]).T))
            if light:
                # Read the columns from the images as well, as a laboratory would.
                seen = [ends_px(picture, where) for (_, picture), where in zip(taken, pixels, strict=True)]
                off = np.abs(np.abs(seen[1] - seen[0]) - moves[-1]).max()
                is_right &= off < 0.25
            else:
                pitch = np.hypot(*(pixels[0][1] - pixels[0][0]))
        columns, markers = (by.max() for by in moves)
        print(f"fluidic, {press[1]}: columns move up to {columns:.1f} px (read {off:.2f} px off), ", end="")
        print(f"markers up to {markers:.1f} px, {markers / pitch:.2f} of their pitch")
    return bool(is_right)


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        camera = Camera(sys.argv[1], Path(folder))
        checks = [check for check in (shadows, inks, dots, skin) if check.__name__ in sys.argv[2:] or not sys.argv[2:]]
        wrong = [check.__name__ for check in checks if not check(camera)]
    if wrong:
        sys.exit(f"pictures that are not read as papers read theirs: {', '.join(wrong)}")


if __name__ == "__main__":
    main()
