//! Pieces: parts that are printed together share one placement and one tolerance.

use fabkit_export::DocumentInfo;
use fabkit_files::UnknownName;
use fabkit_files::staging::OutputFile;
use fabkit_geometry::{Body, Pose, PrintGroup, Sensor};
use fabkit_mesh::DEFAULT_TOLERANCE_MM;

use super::topology::TopologyCounts;
use super::{
    ExportOptions, ExportRunError, Format, MadeFile, MeshedPart, finish_mesh, object, rotate_mesh,
};
use crate::bodies;

/// Smallest chord tolerance that is tried against a wrong topology, mm. A topology that is wrong at this tolerance has
/// another cause.
pub(super) const MIN_TOLERANCE_MM: f64 = DEFAULT_TOLERANCE_MM / 2.0;

/// Single body, or all bodies of a print group.
pub(super) struct Piece<'a> {
    /// Print group, if it is one.
    pub group: Option<&'a PrintGroup>,
    /// Bodies of the piece; at least one.
    pub bodies: Vec<&'a Body>,
}

/// Groups the chosen bodies into pieces, in their order. A part of a print group brings the others with it, because
/// they are useless alone.
pub(super) fn pieces<'a>(
    sensor: &'a Sensor,
    chosen: Vec<&'a Body>,
) -> Result<Vec<Piece<'a>>, UnknownName> {
    let mut pieces: Vec<Piece> = Vec::with_capacity(chosen.len());
    for body in chosen {
        let member = |group: &&PrintGroup| group.parts.iter().any(|part| part == &body.name);
        let Some(group) = sensor.print_groups.iter().find(member) else {
            pieces.push(Piece { group: None, bodies: vec![body] });
            continue;
        };
        if !pieces.iter().any(|piece| piece.group == Some(group)) {
            let bodies = group.parts.iter().map(|part| bodies::find(sensor, part));
            pieces.push(Piece { group: Some(group), bodies: bodies.collect::<Result<_, _>>()? });
        }
    }
    Ok(pieces)
}

impl<'a> Piece<'a> {
    /// Meshes the bodies as placed in their files: rotated like the first body, and shifted together.
    ///
    /// Where a wall or a hole is narrower than the tolerance, the tolerance is halved until the topology matches the
    /// design; for all bodies, because they share faces.
    pub(super) fn mesh_bodies(
        &self,
        options: &ExportOptions,
    ) -> Result<Vec<MeshedPart<'a>>, ExportRunError> {
        let mut tolerance_mm = options.tolerance_mm;
        let counted: Vec<_> =
            self.bodies.iter().map(|body| TopologyCounts::from_body(body, tolerance_mm)).collect();
        loop {
            match self.meshed_at(options, &counted, tolerance_mm) {
                Err(failure)
                    if failure.is_topology_failure() && tolerance_mm > MIN_TOLERANCE_MM =>
                {
                    tolerance_mm /= 2.0;
                }
                done => return done,
            }
        }
    }

    fn meshed_at(
        &self,
        options: &ExportOptions,
        counted: &[Option<TopologyCounts>],
        tolerance_mm: f64,
    ) -> Result<Vec<MeshedPart<'a>>, ExportRunError> {
        let bed_from_body = self.bodies[0].bed_from_body;
        let bodies: Vec<_> = self
            .bodies
            .iter()
            .map(|body| rotate_mesh(body, &bed_from_body, options, tolerance_mm))
            .collect::<Result<_, ExportRunError>>()?;
        // Rotated first and shifted afterwards, so that the lowest coordinates are exactly zero.
        let corners = bodies.iter().map(|body| body.mesh.bounds().min);
        let min = corners.reduce(|a, b| a.inf(&b)).unwrap_or_default();
        let shift = Pose::translation(-min.x, -min.y, -min.z);
        bodies
            .into_iter()
            .zip(counted)
            .map(|(body, counted)| {
                finish_mesh(body, *counted, &shift, &bed_from_body, tolerance_mm)
            })
            .collect()
    }

    /// Makes the 3MF file of a print group, one object made of all its parts; `None` for a single body.
    pub(super) fn group_file(
        &self,
        title: &str,
        hash: &str,
        meshed: &[MeshedPart],
    ) -> Result<Option<MadeFile>, ExportRunError> {
        let Some(group) = self.group else { return Ok(None) };
        let name = Format::ThreeMf.file_name(&group.name);
        let title = format!("{title}: {}", group.name);
        let document = DocumentInfo { title: &title, design_hash: hash };
        let objects: Vec<_> = meshed.iter().map(|m| object(m, &m.print)).collect();
        let bytes = fabkit_export::three_mf_single_item(document, &group.name, &objects)
            .map_err(|source| ExportRunError::Write { file: name.clone(), source })?;
        let file = OutputFile { name, bytes };
        let (format, parts) = (Format::ThreeMf.word(), group.parts.clone());
        Ok(Some(MadeFile { file, format, parts, stock: None }))
    }
}
