//! Bodies of the sensor in their places.

use std::sync::Arc;

use fabkit_designs::Design;
use fabkit_export::{Inertia, RobotLink, RobotMesh, RobotShape};
use fabkit_files::Error;
use fabkit_geometry::{Assembly, Body, BodyKind, Pose};
use rayon::prelude::*;

use super::masses::{Mass, mass};
use crate::RobotError;

/// Largest distance of visual meshes from the exact surface, mm: simulators draw nothing smaller.
pub(super) const VISUAL_TOLERANCE_MM: f64 = 0.05;

/// Body of the sensor in its place.
pub(super) struct PlacedBody<'a> {
    pub body: &'a Body,
    pub sensor_from_body: Pose,
    pub mass: Mass,
    pub is_soft: bool,
    /// Vertices in the sensor frame, mm.
    pub vertices_mm: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
}

/// Returns all bodies of the sensor, with their masses and meshes.
pub(super) fn place_bodies<'a>(design: &'a Design) -> Result<Vec<PlacedBody<'a>>, Error> {
    let densities = fabkit_sweep::densities(&design.sensor);
    let one = |(body, pose): (&'a Body, Pose)| -> Result<PlacedBody<'a>, Error> {
        let failed = |source| RobotError::Mesh { part: body.name.clone(), source };
        let placed = body.solid.clone().placed(pose);
        let mesh = fabkit_mesh::mesh(&placed, VISUAL_TOLERANCE_MM).map_err(failed)?;
        let moments = fabkit_export::moments(&placed).map_err(failed)?;
        Ok(PlacedBody {
            body,
            sensor_from_body: pose,
            mass: mass(body, densities.get(body.name.as_str()).copied(), moments),
            // Bodies with a known modulus that are cast, or that the design declares to give way.
            is_soft: body.substance.elasticity.is_some()
                && (body.kind == BodyKind::Cast || body.is_deformable),
            vertices_mm: mesh.vertices,
            triangles: mesh.triangles,
        })
    };
    let places = design.sensor.bodies.iter().flat_map(|body| {
        let in_sensor = body.placements.iter().filter(|place| place.assembly == Assembly::sensor());
        in_sensor.map(move |place| (body, place.assembly_from_body))
    });
    let places: Vec<(&Body, Pose)> = places.collect();
    let standing: Vec<Result<PlacedBody<'a>, Error>> = places.into_par_iter().map(one).collect();
    // Collected in order, so that the first error is the same for any number of threads.
    standing.into_iter().collect()
}

/// Joins all placements of a body into one visual mesh.
pub(super) fn visual_mesh(body: &Body, standing: &[PlacedBody<'_>]) -> RobotMesh {
    let (mut vertices_mm, mut triangles) = (Vec::new(), Vec::new());
    for one in standing.iter().filter(|one| one.body.name == body.name) {
        // Indices of the next placement follow those of the one before.
        let first = vertices_mm.len() as u32;
        vertices_mm.extend_from_slice(&one.vertices_mm);
        triangles.extend(one.triangles.iter().map(|corners| corners.map(|i| i + first)));
    }
    RobotMesh { file: format!("robot-{}.obj", body.name), vertices_mm, triangles }
}

/// Creates a link of bodies that are rigidly connected, with their visual meshes. Collision shapes are added later.
pub(super) fn link(name: &str, own: &[&PlacedBody<'_>], seen: &[Arc<RobotMesh>]) -> RobotLink {
    let inertia = own.iter().fold(Inertia::ZERO, |sum, one| sum.combined(&one.mass.inertia));
    let mut visuals: Vec<RobotShape> = Vec::new();
    for one in own {
        let shape_name = format!("{name}-{}", one.body.name);
        if visuals.iter().any(|shape| shape.name == shape_name) {
            continue;
        }
        let [r, g, b] = one.body.color.map(|part| f64::from(part) / 255.0);
        let file = format!("robot-{}.obj", one.body.name);
        let mesh = seen.iter().find(|mesh| mesh.file == file);
        visuals.extend(mesh.map(|mesh| RobotShape {
            name: shape_name,
            mesh: Arc::clone(mesh),
            rgba: [r, g, b, one.body.opacity],
        }));
    }
    let friction = own.iter().find_map(|one| one.body.substance.elasticity.as_ref()?.friction);
    RobotLink { name: name.to_owned(), inertia, visuals, collisions: Vec::new(), friction }
}
