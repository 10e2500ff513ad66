"""Presses a pad at large strain with scikit-fem and compares force and bulge with `fabkit-elastic`: 3 minutes.

    cargo build --release -p fabkit-elastic --example press_json
    python check_elastic_finite.py target/release/examples/press_json

It uses the same neo-Hookean energy, `G/2 (I1 - 3 - 2 ln J) + lambda/2 (J - 1)^2`, in Taylor-Hood elements, and an
independent contact: soft springs between surface and ball with the pressure `k e ln(1 + exp(-gap / e))`. The error of
the springs is proportional to 1 / k, so two stiffnesses, the second twice the first, extrapolate to a rigid ball.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
from typing import Any

import numpy as np
from scipy.sparse import bmat
from scipy.sparse.linalg import splu
from skfem import (
    Basis,
    BilinearForm,
    ElementQuad1,
    ElementQuad2,
    ElementVector,
    FacetBasis,
    Functional,
    LinearForm,
    MeshQuad,
    asm,
)
from skfem.helpers import grad

Array = np.ndarray

YOUNG_MPA, POISSON = 0.1, 0.495
SHEAR_MPA = YOUNG_MPA / 2.0 / (1.0 + POISSON)
LAME_MPA = 2.0 * SHEAR_MPA * POISSON / (1.0 - 2.0 * POISSON)
THICKNESS_MM, PAD_RADIUS_MM, BALL_MM = 3.0, 8.0, 4.0
FINE_MM, ELEMENT_MM = 3.6, 0.15
DEPTHS_MM = [0.05 * i for i in range(1, 31)]
COMPARED = [10, 20, 30]
# Stiffness of the springs, MPa/mm, and length over which they set in, mm.
SPRINGS, EDGE_MM = (20.0, 40.0), 1e-3
# Largest relative difference. The remaining errors of springs and elements are a few thousandths.
AGREEMENT = 0.01


def gradient(w: Any) -> list[Array]:
    """Returns the deformation gradient: four components in the meridian plane, row by row, and the hoop component."""
    g = grad(w["u"])
    return [1.0 + g[0, 0], g[0, 1], g[1, 0], 1.0 + g[1, 1], 1.0 + w["u"][0] / w.x[0]]


def varied(v: Any, w: Any) -> list[Array]:
    """Returns the change of the deformation gradient by a variation of the displacement."""
    g = grad(v)
    return [g[0, 0], g[0, 1], g[1, 0], g[1, 1], v[0] / w.x[0]]


def ratio(f: list[Array]) -> Array:
    """Returns the volume ratio, the determinant of the deformation gradient."""
    return f[4] * (f[0] * f[3] - f[1] * f[2])


def slope(f: list[Array]) -> list[Array]:
    """Returns the derivatives of the volume ratio by the components of the deformation gradient."""
    return [f[3] * f[4], -f[2] * f[4], -f[1] * f[4], f[0] * f[4], f[0] * f[3] - f[1] * f[2]]


def bend(f: list[Array], x: list[Array], y: list[Array]) -> Array:
    """Returns the second derivative of the volume ratio along two variations."""
    plane = x[0] * y[3] + x[3] * y[0] - x[1] * y[2] - x[2] * y[1]
    around = f[3] * x[0] - f[2] * x[1] - f[1] * x[2] + f[0] * x[3]
    around_too = f[3] * y[0] - f[2] * y[1] - f[1] * y[2] + f[0] * y[3]
    return f[4] * plane + around * y[4] + around_too * x[4]


def dot(x: list[Array], y: list[Array]) -> Array:
    return sum(a * b for a, b in zip(x, y, strict=True))


@LinearForm
def forces(v: Any, w: Any) -> Any:
    f, x = gradient(w), varied(v, w)
    return (SHEAR_MPA * dot(f, x) + (w["p"] - SHEAR_MPA / ratio(f)) * dot(slope(f), x)) * w.x[0]


@BilinearForm
def tangent(u: Any, v: Any, w: Any) -> Any:
    f, x, y = gradient(w), varied(v, w), varied(u, w)
    j, s = ratio(f), slope(f)
    bent = (w["p"] - SHEAR_MPA / j) * bend(f, x, y)
    return (SHEAR_MPA * (dot(x, y) + dot(s, x) * dot(s, y) / j**2) + bent) * w.x[0]


@BilinearForm
def mixed(u: Any, q: Any, w: Any) -> Any:
    return dot(slope(gradient(w)), varied(u, w)) * q * w.x[0]


@LinearForm
def volume(q: Any, w: Any) -> Any:
    return (ratio(gradient(w)) - 1.0 - w["p"] / LAME_MPA) * q * w.x[0]


@BilinearForm
def bulk(p: Any, q: Any, w: Any) -> Any:
    return p * q / LAME_MPA * w.x[0]


class Contact:
    """Springs between the deformed surface and a ball."""

    def __init__(self, spring: float, depth_mm: float) -> None:
        self.spring, self.depth_mm = spring, depth_mm

    def push(self, w: Any) -> tuple[Array, Array, Array, Array]:
        """Returns pressure, its stiffness, and slope and curvature of the ball above each point."""
        x = w.x[0] + w["u"][0]
        root = np.sqrt(np.clip(BALL_MM**2 - x**2, 1e-6, None))
        gap = THICKNESS_MM - self.depth_mm + BALL_MM - root - w.x[1] - w["u"][1]
        # No contact near the ball's equator, where its slope is infinite.
        gap = np.where(x < 0.98 * BALL_MM, gap, 1.0) / -EDGE_MM
        pressure = self.spring * EDGE_MM * np.logaddexp(0.0, gap)
        return pressure, self.spring / (1.0 + np.exp(-np.clip(gap, -50, 50))), x / root, BALL_MM**2 / root**3

    def forms(self) -> tuple[LinearForm, BilinearForm, Functional]:
        @LinearForm
        def pushed(v: Any, w: Any) -> Any:
            pressure, _, s, _ = self.push(w)
            return -pressure * (s * v[0] - v[1]) * w.x[0]

        @BilinearForm
        def stiffness(u: Any, v: Any, w: Any) -> Any:
            pressure, k, s, c = self.push(w)
            return (k * (s * v[0] - v[1]) * (s * u[0] - u[1]) - pressure * c * u[0] * v[0]) * w.x[0]

        @Functional
        def force(w: Any) -> Any:
            return 2.0 * math.pi * self.push(w)[0] * w.x[0]

        return pushed, stiffness, force


def solved(spring: float) -> Array:
    """Solves for force, N, and bulge, mm, at each depth: depths x 2."""
    along = np.arange(0.0, FINE_MM + 1e-9, ELEMENT_MM)
    along = np.concatenate([along, np.geomspace(FINE_MM, PAD_RADIUS_MM, 14)[1:]])
    mesh = MeshQuad.init_tensor(along, THICKNESS_MM * (1.0 - np.linspace(1.0, 0.0, 15) ** 1.4))
    top = mesh.facets_satisfying(lambda x: np.abs(x[1] - THICKNESS_MM) < 1e-9)
    u_basis = Basis(mesh, ElementVector(ElementQuad2()), intorder=6)
    p_basis = Basis(mesh, ElementQuad1(), intorder=6)
    surface = FacetBasis(mesh, ElementVector(ElementQuad2()), facets=top, intorder=8)
    fixed = np.union1d(
        u_basis.get_dofs(lambda x: x[1] < 1e-9).all(), u_basis.get_dofs(lambda x: x[0] < 1e-9).all(["u^1"])
    )
    heights = u_basis.get_dofs(lambda x: np.abs(x[1] - THICKNESS_MM) < 1e-9).all(["u^2"])
    u, p = u_basis.zeros(), p_basis.zeros()
    free = np.setdiff1d(np.arange(u.size + p.size), fixed)
    found = []
    for depth_mm in DEPTHS_MM:
        pushed, stiffness, force = Contact(spring, depth_mm).forms()
        for _ in range(60):
            at = {"u": u_basis.interpolate(u), "p": p_basis.interpolate(p)}
            on_top = surface.interpolate(u)
            k = asm(tangent, u_basis, **at) + asm(stiffness, surface, u=on_top)
            b = asm(mixed, u_basis, p_basis, u=at["u"])
            residual = np.concatenate(
                [asm(forces, u_basis, **at) + asm(pushed, surface, u=on_top), asm(volume, p_basis, **at)]
            )
            matrix = bmat([[k, b.T], [b, -asm(bulk, p_basis)]]).tocsc()
            step = np.zeros(u.size + p.size)
            step[free] = -splu(matrix[free][:, free]).solve(residual[free])
            largest = float(np.abs(step[: u.size]).max())
            # Newton steps of at most 0.1 mm keep elements from turning inside out.
            step *= min(1.0, 0.1 / max(largest, 1e-30))
            u, p = u + step[: u.size], p + step[u.size :]
            if largest < 1e-6:
                break
        else:
            raise RuntimeError(f"no convergence at {depth_mm} mm")
        found.append([force.assemble(surface, u=surface.interpolate(u)), u[heights].max()])
    return np.array(found)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("example", help="the example press_json, built")
    example = parser.parse_args().example
    soft, stiff = (solved(spring) for spring in SPRINGS)
    # Richardson extrapolation to an infinite stiffness.
    rigid = 2.0 * stiff - soft
    agrees = True
    for number in COMPARED:
        depth_mm, (force_n, bulge_mm) = DEPTHS_MM[number - 1], rigid[number - 1]
        asked = {
            "radius_mm": PAD_RADIUS_MM,
            "layers": [{"young_mpa": YOUNG_MPA, "poisson": POISSON, "thickness_mm": THICKNESS_MM}],
            "presser": {"ball_mm": BALL_MM},
            "depth_mm": depth_mm,
            "spacing_mm": 0.06,
            "reach_mm": FINE_MM,
            "level": "finite",
        }
        run = subprocess.run([example], input=json.dumps(asked), check=True, capture_output=True, text=True)
        answer = json.loads(run.stdout)
        of_force = -answer["force_n"][2] / force_n - 1.0
        of_bulge = answer["bulge_mm"] / bulge_mm - 1.0
        is_close = max(abs(of_force), abs(of_bulge)) < AGREEMENT
        agrees &= is_close
        print(
            f"{depth_mm:.1f} mm: force {-answer['force_n'][2]:.4f} N, scikit-fem {force_n:.4f} "
            f"({of_force:+.2%}); bulge {answer['bulge_mm']:.4f} mm, {bulge_mm:.4f} ({of_bulge:+.2%}): "
            f"{'ok' if is_close else 'FAILED'}"
        )
    return 0 if agrees else 1


if __name__ == "__main__":
    sys.exit(main())
