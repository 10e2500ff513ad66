//! Soft layers and light sources, for simulators that deform and render themselves.

use std::collections::BTreeMap;
use std::sync::Arc;

use fabkit_capture::SLOPE_BINS;
use fabkit_designs::Design;
use fabkit_elastic::{SoftLayer, SoftStack};
use fabkit_export::{
    RobotLightSource, RobotMesh, RobotSensingSurface, RobotTetrahedra, TetraMesh, VERSION, msh2,
    vtk,
};
use fabkit_files::Error;
use fabkit_geometry::{Sensor, TouchSurface, Vector3, VisibleEffect};
use fabkit_light::Emitters;
use fabkit_tetra::Tetrahedra;

use crate::RobotError;

/// Approximate length of edges, mm. It is coarse, because simulators solve the mesh in every step; finer meshes are in
/// the formats `msh` and `vtk`.
const EDGE_MM: f64 = 1.0;
const MM_PER_M: f64 = 1000.0;

/// Touched surface with its tetrahedra and their files, for Drake, UIPC and TacEx.
pub(super) struct SoftBody {
    pub touch: RobotSensingSurface,
    pub files: [(&'static str, &'static str, Vec<u8>); 2],
    /// Approximate length of edges in the mesh, mm.
    pub edge_mm: f64,
    /// Simplifications, in words.
    pub left_out: Vec<String>,
}

/// Builds the soft layers below a surface. `link` is the name of the outermost layer's link.
pub(super) fn build_soft_body(
    design: &Design,
    touch: &TouchSurface,
    mesh: &Arc<RobotMesh>,
    link: &str,
) -> Result<SoftBody, Error> {
    let sensor = &design.sensor;
    let stack = SoftStack::at_tip(sensor).map_err(RobotError::from)?;
    let cells = Tetrahedra::new(&stack, touch, EDGE_MM).map_err(RobotError::from)?;
    let title =
        format!("{}: soft layers in its sensor frame, metres, fabkit {VERSION}", sensor.name);
    let materials: Vec<String> = cells.layers.iter().map(|layer| layer.name.clone()).collect();
    let file = TetraMesh {
        title: &title,
        notes: &[],
        points_mm: &cells.points_mm,
        unit_mm: MM_PER_M,
        cells: &cells.cells,
        cell_materials: &cells.cell_layers,
        materials: &materials,
        faces: &[("outer", &cells.touched_faces), ("bonded", &cells.bonded_faces)],
    };
    let files =
        [("robot-tetrahedra.vtk", "vtk", vtk(&file)), ("robot-tetrahedra.msh", "msh", msh2(&file))];
    let tetrahedra = RobotTetrahedra {
        file: files[0].0.to_owned(),
        surface: boundary_faces(&cells.cells),
        points_mm: cells.points_mm,
        cells: cells.cells,
    };
    let [least_mm, most_mm] = mesh.bounds_mm();
    let touch = RobotSensingSurface {
        mesh: Arc::clone(mesh),
        link: link.to_owned(),
        size_mm: [0, 1, 2].map(|axis| most_mm[axis] - least_mm[axis]),
        top_z_mm: touch.apex_z_mm(),
        max_indentation_mm: touch.max_indentation_mm(),
        young_mpa: series_modulus_mpa(&stack.layers),
        thickness_mm: stack.layers.iter().map(|layer| layer.thickness_mm).sum(),
        slope_bins: (touch.plane().is_some() && shows_slopes(sensor)).then_some(SLOPE_BINS),
        tetrahedra: Arc::new(tetrahedra),
    };
    let left_out = [cells.simplifications, stack.simplifications].concat();
    Ok(SoftBody { touch, files, edge_mm: cells.edge_mm, left_out })
}

/// Returns whether the sensor's usual light makes slopes visible.
fn shows_slopes(sensor: &Sensor) -> bool {
    let usual = sensor.lightings.first();
    usual.is_some_and(|lighting| matches!(lighting.effect, VisibleEffect::Slopes { .. }))
}

/// Computes the modulus of a single layer that is as compliant as all layers in series.
fn series_modulus_mpa(layers: &[SoftLayer]) -> f64 {
    let thickness_mm: f64 = layers.iter().map(|layer| layer.thickness_mm).sum();
    // Compliances of layers in series add up.
    let gives: f64 = layers.iter().map(|l| l.thickness_mm / l.elasticity.young_mpa).sum();
    thickness_mm / gives
}

/// Collects the faces that belong to a single tetrahedron, counter-clockwise seen from outside.
fn boundary_faces(cells: &[[u32; 4]]) -> Vec<[u32; 3]> {
    let mut once: BTreeMap<[u32; 3], Option<[u32; 3]>> = BTreeMap::new();
    for [a, b, c, d] in cells {
        for face in [[*a, *c, *b], [*a, *b, *d], [*a, *d, *c], [*b, *c, *d]] {
            let mut key = face;
            key.sort_unstable();
            // A face that occurs twice, with its corners in opposite orders, is inside.
            once.entry(key).and_modify(|face| *face = None).or_insert(Some(face));
        }
    }
    once.into_values().flatten().collect()
}

/// Lists the light sources of the usual light, each at the centroid of its emitting pieces; empty if the lighting is
/// unknown.
pub(super) fn light_sources(sensor: &Sensor) -> Vec<RobotLightSource> {
    let Some(lighting) = sensor.lightings.first() else { return Vec::new() };
    let Ok(emitters) = Emitters::new(sensor, lighting) else { return Vec::new() };
    /// Sums over a light source's pieces: power, and position and colour times power.
    type Sum = (f64, Vector3<f64>, Vector3<f64>);
    let mut lamps: BTreeMap<usize, Sum> = BTreeMap::new();
    for piece in emitters.pieces() {
        let (power, place, rgb) = lamps.entry(piece.source).or_default();
        *power += piece.power;
        *place += piece.power * piece.place.coords;
        *rgb += piece.power * Vector3::from(piece.color);
    }
    let brightest = lamps.values().map(|lamp| lamp.0).fold(0.0, f64::max);
    let shining = lamps.into_values().filter(|(power, ..)| *power > 0.0);
    let lamp = |(power, place, rgb): Sum| RobotLightSource {
        place_mm: (place / power).into(),
        rgb: (rgb / power).into(),
        share: power / brightest,
    };
    shining.map(lamp).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_tetrahedra_share_one_face() {
        // The second lies on the other side of 1, 2, 3.
        let faces = boundary_faces(&[[0, 1, 2, 3], [4, 1, 3, 2]]);
        assert_eq!(faces.len(), 6);
        assert!(faces.iter().all(|face| {
            let mut key = *face;
            key.sort_unstable();
            key != [1, 2, 3]
        }));
        // Each edge is gone along both ways, so that it is closed and looks outwards.
        let edges = || faces.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
        for [a, b] in edges() {
            assert_eq!(edges().filter(|edge| *edge == [b, a]).count(), 1);
        }
    }
}
