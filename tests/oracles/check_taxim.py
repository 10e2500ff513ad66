"""Renders a ball on flat sensors with Taxim from their optics packs, and compares with fabkit's own captures.

    pip install numpy pillow jax; pip install --no-deps taxim==1.4.1
    python check_taxim.py path/to/fabkit

On demand: JAX is large. Taxim smooths the gel around the ball in its own way, so the images differ beside the ball. All
of it is simulated.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image
from taxim.taxim_jax import TaximJax

# Radius of the built-in ball, its indentation, and radius of the compared region, mm.
BALL_MM, DEEP_MM, AROUND_MM = 2.5, 0.4, 1.3
# Intensity below which a pixel is, or was, a printed marker.
DARK = 30
# Least correlation with fabkit's changes of colour; reversed colours or mirrored images give 0.5 and less.
ALIKE = 0.85


def picture(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB")).astype(float)


def compare(fabkit: str, sensor: str, folder: Path) -> bool:
    def run(*words: object) -> None:
        subprocess.run([fabkit, *map(str, words), "--quiet"], check=True)

    run("optics-pack", sensor, "-o", folder)
    run("capture", sensor, "--press", f"ball@0mm,0mm,{DEEP_MM}mm", "--no-noise", "-o", folder / "own.png")
    own, rest = picture(folder / "own.png"), picture(folder / "background.png")
    taxim = TaximJax(calib_folder=folder / "taxim")
    y, x = np.mgrid[: taxim.height, : taxim.width]
    far_mm = np.hypot(x + 0.5 - taxim.width / 2, y + 0.5 - taxim.height / 2) * taxim.sensor_params.pixmm
    # Height of the ball above the gel's face, mm; negative where it indents.
    ball = np.where(far_mm < BALL_MM, BALL_MM - DEEP_MM - np.sqrt(np.clip(BALL_MM**2 - far_mm**2, 0, None)), 10.0)
    fine = True
    for with_shadow in (False, True):
        drawn = 255 * np.asarray(taxim.render(ball.astype(np.float32), with_shadow=with_shadow))
        seen = (far_mm < AROUND_MM) & (np.minimum(own.max(axis=-1), rest.max(axis=-1)) > DARK)
        ours, theirs = (own - rest)[seen].ravel(), (drawn - rest)[seen].ravel()
        alike = float(np.corrcoef(ours, theirs)[0, 1])
        left = float(np.sqrt(((ours - theirs) ** 2).mean()))
        print(f"check_taxim: {sensor}, shadows {'on' if with_shadow else 'off'}: fabkit changes "
              f"{ours.std():.1f} grey, Taxim {theirs.std():.1f}; apart {left:.1f} rms, correlation {alike:.3f}")
        fine &= alike > ALIKE
    return fine


def main(fabkit: str) -> int:
    with tempfile.TemporaryDirectory() as name:
        return 0 if all([compare(fabkit, s, Path(name) / s) for s in ("digit-like", "gelsight-like")]) else 1


if __name__ == "__main__":
    sys.exit(main(str(Path(sys.argv[1]).resolve())))
