"""Validates the documents that `--json` prints against their JSON Schemas.

    python check_contracts.py PATH_TO_FABKIT

It covers all commands that need no real captures. The schemas are those that `fabkit schema --output` prints; the
validator is the package jsonschema, which checks the schemas themselves first. Nothing here uses fabkit's own code.
"""

import json
import subprocess
import sys
import tempfile

import jsonschema

PLAN = """format: 1
sensor: rtac0
axes:
  camera.depth: [6 mm, 7 mm]
metrics: [coverage]
"""
GEL = """format: 1
gel: Smooth-On Ecoflex 00-30
ball: 12 mm
thickness: 12 mm
diameter: 50 mm
readings:
  - {load: 41.3 g, gap: 19 mm}
  - {load: 79.6 g, gap: 18.5 mm}
  - {load: 127.5 g, gap: 18 mm}
"""
#: In each line: schema, expected exit code, command line.
COMMANDS = """
list 0 list
show 0 show rtac0
show 0 show fluidic
show 0 show rtac0/semi-domes
limits 0 show 9dtact --limits
show 0 show rtac0 --set mold.width=44.1mm --fix
chain 0 show tactip --chain
check 0 check shadowtac
check 1 check rtac0-published-2025/pin-dome
export 0 export rtac0 -o out
export 0 export rtac0/coupon -o coupon
export 0 export 9dtact --robot urdf,mjcf,sdf -o robot
reread 0 verify ./out
gel-profile 0 profile gel.yaml -o batch.yaml
new 0 new mine --family dome
render 0 render rtac0/base --size 16x12 -o base.png
sweep 0 sweep plan.yaml -o sweep
depth 0 depth rtac0 --press semi-dome-017 -o press.npz
probes 0 dataset rtac0 --probes --count 20 -o probes.csv
completions 0 completions fish
man 0 man
capture 0 capture 9dtact --press ball@0mm,0mm,1mm -o capture.png
capture 0 capture 9dtact --reference -o rest.png
reconstruct 0 reconstruct 9dtact --reference rest.png capture.png -o depth
calibrate-plan 0 calibrate plan digit-like --captures 2
optics-pack 0 optics-pack gelsight-like -o optics
optics-pack 0 optics-pack digit-like -o tables
press 0 press digit-like --indenter ball@0mm,0mm --depth 0.4mm --steps 2 --shear 0.1mm,0mm --csv curve.csv
guide 0 guide tactip -o guide
error 2 show rtac1
error 2 show rtac0 --set surface.radius=9 --set leds.count=80
error 2 export rtac0 --tolerance=1
error 2 exprot
error 2 export rtac0/pin-dome --robot urdf
error 2 bench rtac1 -o bench
error 3 render rtac0 --size 10000x10000 -o a.png
error 4 show nowhere.yaml
"""


def run(fabkit: str, folder: str, words: list[str]) -> tuple[int, dict]:
    """Runs a command; returns its exit code and its JSON document."""
    done = subprocess.run([fabkit, *words], capture_output=True, text=True, cwd=folder)
    try:
        return done.returncode, json.loads(done.stdout)
    except json.JSONDecodeError as error:
        sys.exit(f"fabkit {' '.join(words)}: {error}\n{done.stdout}{done.stderr}")


def main(fabkit: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        _, unknown = run(fabkit, folder, ["schema", "--output", "-", "--json"])
        names = unknown["problems"][0]["limit"]["choices"]
        validators = {}
        for name in names:
            _, schema = run(fabkit, folder, ["schema", "--output", name])
            jsonschema.Draft202012Validator.check_schema(schema)
            validators[name] = jsonschema.Draft202012Validator(schema)
        with open(f"{folder}/plan.yaml", "w") as plan:
            plan.write(PLAN)
        with open(f"{folder}/gel.yaml", "w") as gel:
            gel.write(GEL)
        for line in COMMANDS.strip().splitlines():
            name, code, *words = line.split()
            found, document = run(fabkit, folder, [*words, "--json"])
            if found != int(code):
                sys.exit(f"fabkit {' '.join(words)}: exit {found} instead of {code}: {document}")
            wrong = [f"{e.json_path}: {e.message}" for e in validators[name].iter_errors(document)]
            if wrong:
                sys.exit(f"fabkit {' '.join(words)} --json:\n" + "\n".join(wrong))
    print(f"{len(names)} schemas hold")


if __name__ == "__main__":
    main(*sys.argv[1:])
