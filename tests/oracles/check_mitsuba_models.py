"""Compares the models of coats, scattering layers and fluorescent gels with the path tracer Mitsuba 3.

    python check_mitsuba_models.py PATH_TO_THE_EXAMPLE_models_json

There are three scenes of each. Coats: absolute radiance of cells, seen from below, with light sources and shadows; the
script adds the formula of the rough mirror to Mitsuba, which has none like it. Layers: an isotropically scattering slab
over black in diffuse light, compared with the two-stream model, which is an approximation. Fluorescence: absorption of
the exciting light, summed over depth. On demand: `pip install mitsuba numpy`.
"""

import json
import subprocess
import sys
from typing import Any

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f

HALF, SIDE, HEIGHT = 6.0, 40, 10.0
BOUND = 0.02
LAMPS = ((8, 0, [1, 0.1, 0]), (-4, 7, [0, 1, 0.2]), (-4, -7, [0.1, 0, 1]))
# Paths for each pixel and light source.
SAMPLES = 400
# Reflectance of the plane that measures the light in a gel: small, so that it does not disturb it.
SENDS = 0.01
# Half the side of slabs, mm: so wide that their edges have no effect.
WIDE = 500.0


class Satin(mi.BSDF):
    """Reflectance of a satin coat: Lambert's law plus a Blinn lobe."""

    def __init__(self, props: Any) -> None:
        mi.BSDF.__init__(self, props)
        self.diffuse, self.shine, self.exponent = (
            props[name] for name in ("diffuse", "shine", "exponent")
        )
        self.m_flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide
        self.m_components = [self.m_flags]

    def eval(self, ctx: Any, si: Any, wo: Any, active: bool = True) -> Any:
        if si.wi.z <= 0 or wo.z <= 0:
            return mi.Color3f(0.0)
        half = np.array([si.wi.x + wo.x, si.wi.y + wo.y, si.wi.z + wo.z])
        lobe = (self.exponent + 8) / 8 * (half[2] / np.linalg.norm(half)) ** self.exponent
        return mi.Color3f(wo.z / np.pi * (self.diffuse + self.shine * lobe))

    def pdf(self, ctx: Any, si: Any, wo: Any, active: bool = True) -> float:
        return max(wo.z, 0.0) / np.pi

    def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: bool = True) -> Any:
        raise NotImplementedError("lamps alone are asked")

    def to_string(self) -> str:
        return "Satin"


mi.register_bsdf("satin", Satin)


def lamp(x: float, y: float) -> dict:
    return {
        "type": "rectangle",
        "to_world": T().translate([x, y, 0]).scale([1, 0.75, 1]),
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}},
    }


def orthographic(z: float, half: float, side: int, samples: int, **more: Any) -> dict:
    """Creates an orthographic camera that looks along +z; x decreases to the right in the image."""
    look = T().look_at(origin=[0, 0, z], target=[0, 0, z + 1], up=[0, 1, 0])
    return {
        "type": "orthographic",
        "near_clip": 1e-5,
        "to_world": look @ T().scale([half, half, 1]),
        "film": {
            "type": "hdrfilm",
            "width": side,
            "height": side,
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
        },
        "sampler": {"type": "independent", "sample_count": samples},
        **more,
    }


def plane(z: float, half: float, bsdf: dict) -> dict:
    """Creates a rectangle that faces down."""
    place = T().translate([0, 0, z]).rotate([1, 0, 0], 180).scale([half, half, 1])
    return {"type": "rectangle", "to_world": place, "bsdf": bsdf}


def diffuse(part: float) -> dict:
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": part}}


def surfaces(bsdf: dict) -> dict[str, dict]:
    tilted = (
        T()
        .translate([0, 0, HEIGHT])
        .rotate([0, 1, 0], -20)
        .rotate([1, 0, 0], 180)
        .scale([40, 40, 1])
    )
    return {
        "tilted plane": {"s": {"type": "rectangle", "to_world": tilted, "bsdf": bsdf}},
        "ball": {
            "s": {"type": "sphere", "center": [0, 0, HEIGHT + 15], "radius": 15.0, "bsdf": bsdf}
        },
        "bump on a plane": {
            "s": plane(HEIGHT, 40, bsdf),
            "t": {"type": "sphere", "center": [1, 0.5, HEIGHT], "radius": 1.5, "bsdf": bsdf},
        },
    }


def coats(ours: dict) -> list[str]:
    spread, shine, exponent = ours["coat"]
    satin = {"type": "satin", "diffuse": spread, "shine": shine, "exponent": exponent}
    wrong = []
    for finish, bsdf in (("matt", diffuse(spread)), ("satin", satin)):
        for name, shapes in surfaces(bsdf).items():
            theirs = np.zeros((SIDE, SIDE, 3))
            # One light source at a time: the random choice among three would be most of the noise.
            for x, y, color in LAMPS:
                described = {
                    "type": "scene",
                    "integrator": {"type": "direct", "bsdf_samples": 0, "emitter_samples": 1},
                    "sensor": orthographic(2.0, HALF, SIDE, SAMPLES),
                    "lamp": lamp(x, y),
                    **shapes,
                }
                theirs += np.pi * np.array(mi.render(mi.load_dict(described)))[::-1, ::-1] * color
            mine = np.array(ours["coats"][f"{name}, {finish}"]).reshape(SIDE, SIDE, 3)
            rms = np.sqrt(np.mean((mine - theirs) ** 2)) / theirs.mean()
            share = mine.sum() / theirs.sum()
            print(
                f"coat, {name}, {finish}: {100 * rms:.2f} % rms of the mean, all light {share:.4f} of theirs"
            )
            if rms > BOUND:
                wrong.append(f"{name}, {finish}")
    return wrong


def slab(medium: Any, low: float, high: float) -> dict:
    place = T().translate([0, 0, (low + high) / 2]).scale([WIDE, WIDE, (high - low) / 2])
    return {"type": "cube", "to_world": place, "bsdf": {"type": "null"}, "interior": medium}


def gel(per_mm: float, albedo: float) -> Any:
    described = {
        "type": "homogeneous",
        "sigma_t": per_mm,
        "albedo": albedo,
        "phase": {"type": "isotropic"},
    }
    return mi.load_dict(described)


def layers(ours: dict) -> None:
    for depth, model in ours["layers"].items():
        high = float(depth)
        film = {
            "type": "hdrfilm",
            "width": 1,
            "height": 1,
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
        }
        # The meter faces the slab and is transparent.
        meter = {
            **plane(high + 0.01, 1.0, {"type": "null"}),
            "sensor": {
                "type": "irradiancemeter",
                "film": film,
                "sampler": {"type": "independent", "sample_count": 400_000},
            },
        }
        described = {
            "type": "scene",
            "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": 10_000},
            "meter": meter,
            "slab": slab(gel(1.0, 1.0), 0.0, high),
            # Slightly below the slab, so that no ray starts behind it.
            "black": {
                "type": "rectangle",
                "to_world": T().translate([0, 0, -0.1]).scale(WIDE),
                "bsdf": diffuse(0.0),
            },
            "light": {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}},
        }
        found = float(np.array(mi.render(mi.load_dict(described))).mean()) / np.pi
        print(
            f"layer of {depth} mean free paths: two streams {model:.4f}, path traced {found:.4f}, "
            f"off by {100 * (model / found - 1):+.1f} %"
        )


def arrives(media: list[tuple[Any, float, float]], depth: float, way: list[float]) -> float:
    """Computes the fraction of the light in front of the gels that arrives at a depth inside them."""
    inside = next(medium for medium, low, high in media if low < depth < high)
    described = {
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": 8},
        "sensor": orthographic(depth - 1e-4, 0.1, 2, 40_000, medium=inside),
        "level": {**plane(depth, 1.0, diffuse(SENDS)), "interior": inside, "exterior": inside},
        "light": {
            "type": "directional",
            "direction": way,
            "irradiance": {"type": "rgb", "value": 1.0},
        },
        **{f"gel{i}": slab(*gel) for i, gel in enumerate(media)},
    }
    return float(np.array(mi.render(mi.load_dict(described))).mean()) * np.pi / SENDS / way[2]


def glows(gels: list[tuple[float, float]], way: list[float]) -> float:
    """Computes the absorbed light, integrated over depth by Gauss's rule; gels are absorption, 1/mm, and thickness."""
    media, low = [], 0.0
    for per_mm, thickness in gels:
        # A small gap: a ray cannot distinguish two coincident faces.
        media.append((gel(per_mm, 0.0), low + 1e-4, low + thickness - 1e-4))
        low += thickness
    nodes, weights = np.polynomial.legendre.leggauss(6)
    total = 0.0
    for (per_mm, thickness), (_, start, _) in zip(gels, media):
        depths = start + thickness * (nodes + 1) / 2
        light = [arrives(media, depth, way) for depth in depths]
        total += per_mm * thickness / 2 * float(weights @ light) / way[2]
    return total


def main() -> None:
    ours = json.loads(subprocess.run([sys.argv[1]], capture_output=True, check=True).stdout)
    layers(ours)
    straight, aside = [0.0, 0.0, 1.0], [0.5**0.5, 0.0, 0.5**0.5]
    one, along, two = (ours["glow"][name] for name in ("one", "aside", "two"))
    slanted = glows([(0.5, 2.0)], aside)
    scenes = (
        ("one gel", one, glows([(0.5, 2.0)], straight)),
        ("light from 45 degrees aside, its own way", along, slanted),
        ("two gels", two, glows([(0.3, 0.8), (0.7, 1.2)], straight)),
    )
    wrong = []
    for name, mine, theirs in scenes:
        print(
            f"glow, {name}: {mine:.4f}, path traced {theirs:.4f}, off by {100 * (mine / theirs - 1):+.2f} %"
        )
        if abs(mine / theirs - 1) > BOUND:
            wrong.append(name)
    wrong += coats(ours)
    if wrong:
        sys.exit(f"more than 2 % off: {'; '.join(wrong)}")


if __name__ == "__main__":
    main()
