"""Presses layered pads with scikit-fem and compares force, bulge and displacements with `fabkit-elastic`.

    cargo build --release -p fabkit-elastic --example press_json
    python check_elastic.py target/release/examples/press_json

The axisymmetric solution is independent: Taylor-Hood elements (biquadratic displacements, pressures that are bilinear
within each layer and discontinuous between layers), with the surface nodes in contact fixed to the indenter. The
contact is a disc: the largest one whose outermost element is not in tension. Of fabkit only the numbers that the
example prints are used. Needs scikit-fem 12 and scipy.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import time
from dataclasses import dataclass
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
    MeshQuad,
    asm,
)
from skfem.helpers import ddot, sym_grad

Array = np.ndarray

# Largest difference of the two solutions, relative to the depth and to the force.
AGREEMENT = 0.01
PAD_RADIUS_MM = 12.0
ECOFLEX_ON_PDMS = [(0.07, 1.5), (1.7, 1.5)]


@dataclass
class Case:
    """One press. Layers, from the touched one down, are Young's modulus, MPa, and thickness, mm."""

    name: str
    layers: list[tuple[float, float]]
    poisson: float
    presser: str
    radius_mm: float
    depth_mm: float
    # Size of elements under the indenter, and radius of the region with that size.
    element_mm: float = 0.06
    fine_mm: float = 4.8

    def shape_mm(self, r: Array) -> Array:
        """Returns the height of the indenter above its lowest point; infinite beside it."""
        inside = np.clip(self.radius_mm**2 - r**2, 0.0, None)
        return np.where(r < self.radius_mm, self.radius_mm - np.sqrt(inside), np.inf)

    @property
    def thickness_mm(self) -> float:
        return sum(thickness for _, thickness in self.layers)

    def asked(self) -> dict[str, Any]:
        return {
            "radius_mm": PAD_RADIUS_MM,
            "layers": [
                {"young_mpa": young, "poisson": self.poisson, "thickness_mm": thickness}
                for young, thickness in self.layers
            ],
            "presser": {f"{self.presser}_mm": self.radius_mm},
            "depth_mm": self.depth_mm,
            "spacing_mm": self.element_mm / 2.0,
            "reach_mm": self.fine_mm,
        }


CASES = [
    Case("ball R4, 0.6 mm", ECOFLEX_ON_PDMS, 0.495, "ball", 4.0, 0.6),
    Case("ball R4, 1.0 mm", ECOFLEX_ON_PDMS, 0.495, "ball", 4.0, 1.0),
    Case("pin R0.8, 0.7 mm", ECOFLEX_ON_PDMS, 0.495, "pin", 0.8, 0.7, 0.02, 1.6),
    Case("ball R4, 0.6 mm, nu 0.45", ECOFLEX_ON_PDMS, 0.45, "ball", 4.0, 0.6),
    Case("ball R4, 1.5 mm, one gel", [(0.07, 3.0)], 0.495, "ball", 4.0, 1.5),
]


class Pad:
    """Stiffness matrix of a pad that is bonded at z = 0 and free at its rim."""

    def __init__(self, case: Case) -> None:
        fine = np.arange(0.0, case.fine_mm + 1e-9, case.element_mm)
        coarse = np.geomspace(case.fine_mm, PAD_RADIUS_MM, 30)[1:]
        heights, z = [np.array([0.0])], 0.0
        for _, thickness in reversed(case.layers):
            # Elements are smallest below the touched surface.
            size = case.element_mm * (1.0 if z + thickness > case.thickness_mm - 1e-9 else 4.0)
            count = math.ceil(thickness / (3.0 * size))
            heights.append(z + thickness * (1.0 - np.linspace(1.0, 0.0, count + 1)[1:] ** 1.5))
            z += thickness
        mesh = MeshQuad.init_tensor(np.concatenate([fine, coarse]), np.concatenate(heights))
        self.top_mm = z
        self.u = Basis(mesh, ElementVector(ElementQuad2()), intorder=6)
        middles = mesh.p[1][mesh.t].mean(axis=0)
        blocks: list[list[Any]] = [[None]]
        bottom = 0.0
        for young, thickness in reversed(case.layers):
            inside = np.flatnonzero((middles > bottom) & (middles < bottom + thickness))
            bottom += thickness
            shear = young / 2.0 / (1.0 + case.poisson)
            lame = 2.0 * shear * case.poisson / (1.0 - 2.0 * case.poisson)
            u = Basis(mesh, ElementVector(ElementQuad2()), intorder=6, elements=inside)
            p = Basis(mesh, ElementQuad1(), intorder=6, elements=inside)
            used = np.unique(p.element_dofs)
            stiffness = asm(strain_form(shear), u)
            blocks[0][0] = stiffness if blocks[0][0] is None else blocks[0][0] + stiffness
            volume = asm(divergence_form, u, p)[used]
            bulk = asm(bulk_form(lame), p)[used][:, used]
            blocks[0].append(volume.T)
            for row in blocks[1:]:
                row.append(None)
            blocks.append([volume] + [None] * (len(blocks) - 1) + [-bulk])
        self.matrix = bmat(blocks).tocsc()
        held = self.u.get_dofs(lambda x: x[1] < 1e-9).all()
        axis = self.u.get_dofs(lambda x: x[0] < 1e-9).all(["u^1"])
        self.fixed = np.unique(np.concatenate([held, axis]))
        places = self.u.doflocs
        on_top = np.abs(places[1] - z) < 1e-9
        is_axial = np.zeros(self.u.N, bool)
        is_axial[self.u.nodal_dofs[1]] = True
        is_axial[self.u.facet_dofs[1]] = True
        top = np.flatnonzero(on_top & is_axial)
        self.top = top[np.argsort(places[0][top])]
        self.top_r_mm = places[0][self.top]

    def press(self, case: Case, held: int) -> tuple[Array, Array]:
        """Solves for displacements, and forces in N per radian on the innermost `held` nodes, which are in contact."""
        nodes = self.top[:held]
        solution = np.zeros(self.matrix.shape[0])
        solution[nodes] = case.shape_mm(self.top_r_mm[:held]) - case.depth_mm
        known = np.union1d(self.fixed, nodes)
        free = np.setdiff1d(np.arange(self.matrix.shape[0]), known)
        right = -(self.matrix @ solution)[free]
        solution[free] = splu(self.matrix[free][:, free]).solve(right)
        return solution, (self.matrix @ solution)[nodes]


def strain_form(shear: float) -> BilinearForm:
    @BilinearForm
    def form(u: Any, v: Any, w: Any) -> Any:
        r = w.x[0]
        return 2.0 * shear * (ddot(sym_grad(u), sym_grad(v)) + u[0] * v[0] / r**2) * r

    return form


@BilinearForm
def divergence_form(u: Any, q: Any, w: Any) -> Any:
    from skfem.helpers import div

    return (div(u) + u[0] / w.x[0]) * q * w.x[0]


def bulk_form(lame: float) -> BilinearForm:
    @BilinearForm
    def form(p: Any, q: Any, w: Any) -> Any:
        return p * q / lame * w.x[0]

    return form


def solved(pad: Pad, case: Case) -> tuple[Array, float, float]:
    """Finds the contact; returns displacements, force, N, and contact radius, mm."""
    most = int(np.count_nonzero(pad.top_r_mm < case.radius_mm * (1.0 - 1e-9)))
    # A biquadratic element adds two nodes: the contact ends at a corner node, 3, 5, ...
    low, high = 1, (most - 1) // 2
    while low < high:
        middle = (low + high + 1) // 2
        _, forces = pad.press(case, 2 * middle + 1)
        # Tension at the outermost element means that the disc is larger than the contact.
        low, high = (middle, high) if forces[-2:].sum() < 0.0 else (low, middle - 1)
    held = 2 * low + 1
    solution, forces = pad.press(case, held)
    force_n = -2.0 * math.pi * float(forces.sum())
    return solution, force_n, float(pad.top_r_mm[held - 1])


def compared(case: Case, example: str) -> bool:
    start = time.monotonic()
    pad = Pad(case)
    solution, force_n, radius_mm = solved(pad, case)
    seconds = time.monotonic() - start
    asked = json.dumps(case.asked())
    answer = json.loads(
        subprocess.run([example], input=asked, check=True, capture_output=True, text=True).stdout
    )

    probe_r = np.concatenate([np.arange(0.05, 4.9, 0.05), np.arange(5.0, 11.0, 0.25)])
    worst = 0.0
    height, profiles = pad.top_mm, answer["profiles"]
    for profile, (_, thickness) in zip(profiles, [*case.layers, (0.0, 0.0)], strict=True):
        there = np.vstack([probe_r, np.full_like(probe_r, min(max(height, 1e-9), pad.top_mm - 1e-9))])
        moved = (pad.u.probes(there) @ solution[: pad.u.N]).reshape(2, -1)
        ours = np.array(profile)
        for component in range(2):
            ours_there = np.interp(probe_r, ours[:, 0], ours[:, 2 + component])
            worst = max(worst, float(np.abs(ours_there - moved[component]).max()))
        height -= thickness
    bulge_mm = float(solution[pad.top].max())
    ours_n = -answer["force_n"][2]
    of_force = ours_n / force_n - 1.0
    of_bulge = (answer["bulge_mm"] - bulge_mm) / case.depth_mm
    is_close = max(abs(of_force), abs(of_bulge), worst / case.depth_mm) < AGREEMENT
    is_close &= abs(answer["contact_radius_mm"] - radius_mm) < 1.5 * case.element_mm
    print(
        f"{case.name}: force {ours_n:.4f} N, scikit-fem {force_n:.4f} ({of_force:+.2%}); "
        f"bulge {answer['bulge_mm']:.4f} mm, {bulge_mm:.4f} ({of_bulge:+.2%} of the press); "
        f"radius {answer['contact_radius_mm']:.3f} mm, {radius_mm:.3f}; "
        f"displacements within {worst / case.depth_mm:.2%} of the press; "
        f"{pad.matrix.shape[0]} unknowns, {seconds:.0f} s: {'ok' if is_close else 'FAILED'}",
        flush=True,
    )
    return is_close


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("example", help="the example press_json, built")
    asked = parser.parse_args()
    return 0 if all([compared(case, asked.example) for case in CASES]) else 1


if __name__ == "__main__":
    sys.exit(main())
