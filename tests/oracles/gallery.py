"""Draws simulated captures of all sensors, at rest and pressed, without noise, on one sheet.

    python gallery.py PATH_TO_FABKIT SHEET.png
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

WIDTH, HEIGHT, GAP, TITLE = 300, 230, 10, 24
SENSORS = [
    ("R-Tac0", ["rtac0"], ["ball@20deg,120deg,1.2mm"]),
    ("9DTact", ["9dtact"], ["ball@0mm,0mm,2mm"]),
    ("ShadowTac", ["shadowtac"], ["ball@8deg,30deg,2mm"]),
    ("DIGIT-like", ["digit-like"], ["ball@1mm,1mm,1mm"]),
    ("GelSight-like", ["gelsight-like"], ["ball@1mm,1mm,1.2mm"]),
    ("UVDtact, white", ["uvdtact"], ["hemisphere@50deg,90deg,1.4mm"]),
    ("UVDtact, ultraviolet", ["uvdtact", "--light=uv"], ["hemisphere@50deg,90deg,1.4mm"]),
    ("TacTip", ["tactip", "--samples=8"], ["disc-107@0deg,0deg,2mm"]),
    ("Fluidic, markers", ["fluidic", "--samples=2"], ["hemisphere@7mm,7mm,4mm", "--spacing=1.5mm"]),
    (
        "Fluidic, display",
        ["fluidic", "--light=display", "--samples=2"],
        ["hemisphere@20mm,3mm,5mm", "--spacing=1.5mm"],
    ),
]


def main() -> None:
    fabkit, sheet_file = sys.argv[1:]
    columns = 4
    rows = -(-2 * len(SENSORS) // columns)
    size = (GAP + columns * (WIDTH + GAP), GAP + rows * (HEIGHT + TITLE + GAP))
    sheet = Image.new("RGB", size, "white")
    draw = ImageDraw.Draw(sheet)
    with tempfile.TemporaryDirectory() as folder:
        for number, (title, sensor, press) in enumerate(SENSORS):
            for pressed, what in enumerate((["--reference"], ["--press", *press])):
                picture = Path(folder) / "picture.png"
                run = [fabkit, "capture", *sensor, *what, "--no-noise", "-o", str(picture)]
                subprocess.run(run, check=True)
                image = Image.open(picture).convert("RGB")
                scale = min(WIDTH / image.width, HEIGHT / image.height)
                way = Image.Resampling.NEAREST if scale > 1 else Image.Resampling.LANCZOS
                image = image.resize((round(image.width * scale), round(image.height * scale)), way)
                place = 2 * number + pressed
                left = GAP + place % columns * (WIDTH + GAP)
                top = GAP + place // columns * (HEIGHT + TITLE + GAP)
                middle = ((WIDTH - image.width) // 2, TITLE + (HEIGHT - image.height) // 2)
                sheet.paste(image, (left + middle[0], top + middle[1]))
                if not pressed:
                    font = ImageFont.load_default(15)
                    draw.text((left, top + 2), f"{title}, at rest and pressed", "black", font)
    # Full colour: a palette would add steps that the captures do not have.
    sheet.save(sheet_file, optimize=True)


if __name__ == "__main__":
    main()
