//! Comparison of a mesh's topology with the design: genus, pieces and closed cavities.

use fabkit_designs::parameters::SourceKind;
use fabkit_designs::{Design, builtin_names, builtin_yaml};
use fabkit_geometry::{Body, Shells};
use fabkit_mesh::{DEFAULT_TOLERANCE_MM, PrintMesh, Shell};

use super::ExportRunError;

/// Largest number of surplus pieces and cavities named in a message.
const MOST_NAMED: usize = 3;

/// Topological counts of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TopologyCounts {
    genus: i32,
    shells: Shells,
}

impl TopologyCounts {
    /// Returns the design's counts. What the design does not count is taken from a mesh at the default tolerance;
    /// `None` if the requested tolerance is as fine, so that nothing is known.
    pub fn from_body(body: &Body, tolerance_mm: f64) -> Option<Self> {
        if let (Some(genus), Some(shells)) = (body.genus, body.shells) {
            return Some(Self { genus, shells });
        }
        // A reference mesh would be no finer than the mesh itself.
        if tolerance_mm <= DEFAULT_TOLERANCE_MM {
            return None;
        }
        let fine = fabkit_mesh::mesh(&body.solid, DEFAULT_TOLERANCE_MM).ok()?.to_print().ok()?;
        Some(Self::from_mesh(&fine))
    }

    pub fn from_mesh(mesh: &PrintMesh) -> Self {
        let shells = mesh.shells();
        let voids = shells.iter().filter(|shell| shell.is_void()).count();
        Self { genus: mesh.genus(), shells: Shells { pieces: shells.len() - voids, voids } }
    }

    /// Compares a mesh with the counts; returns the failure if they differ.
    pub fn failure(self, body: &Body, mesh: &PrintMesh) -> Option<ExportRunError> {
        let (part, found) = (body.name.to_owned(), Self::from_mesh(mesh));
        if found.shells != self.shells {
            let (counted, found) = (self.shells, found.shells);
            let unexpected = surplus_shells(mesh.shells(), counted);
            return Some(ExportRunError::Shells { part, found, counted, unexpected });
        }
        let (found, counted) = (found.genus, self.genus);
        (found != counted).then_some(ExportRunError::Genus { part, found, counted })
    }
}

/// Returns the smallest of the surplus pieces and cavities, at most `MOST_NAMED`.
fn surplus_shells(mut shells: Vec<Shell>, counted: Shells) -> Vec<Shell> {
    shells.sort_by(|a, b| a.volume_mm3.abs().total_cmp(&b.volume_mm3.abs()));
    let (voids, pieces): (Vec<Shell>, Vec<Shell>) = shells.into_iter().partition(Shell::is_void);
    let too_many = |all: Vec<Shell>, counted: usize| {
        let count = all.len().saturating_sub(counted);
        all.into_iter().take(count)
    };
    too_many(pieces, counted.pieces)
        .chain(too_many(voids, counted.voids))
        .take(MOST_NAMED)
        .collect()
}

/// Formats shells for a message: `: a piece of 9.000e-3 mm3 at (1.00, 2.00, 3.00) mm, a cavity of ...`.
pub(super) fn format_shells(shells: &[Shell]) -> String {
    let place = |shell: &Shell| {
        let what = if shell.is_void() { "cavity" } else { "piece" };
        let [x, y, z] = shell.at_mm;
        format!("a {what} of {:.3e} mm3 at ({x:.2}, {y:.2}, {z:.2}) mm", shell.volume_mm3.abs())
    };
    let all: Vec<String> = shells.iter().map(place).collect();
    if all.is_empty() { String::new() } else { format!(": {}", all.join(", ")) }
}

/// Attributes a wrong topology: to fabkit if the design is built in and unchanged, otherwise to the changed values.
pub(super) fn attribute_failure(failure: ExportRunError, design: &Design) -> ExportRunError {
    let (ExportRunError::Genus { .. } | ExportRunError::Shells { .. }) = &failure else {
        return failure;
    };
    match changed_parameters(design) {
        Some(changed) => ExportRunError::CannotBeMade { reason: failure.to_string(), changed },
        None => failure,
    }
}

/// Returns the parameters that differ from the built-in design of that name; if there is none, those that the user
/// gave. `None` for an unchanged built-in design.
fn changed_parameters(design: &Design) -> Option<Vec<String>> {
    if design.parameters.is_empty() {
        return None; // Made by a program.
    }
    let name = &design.sensor.name;
    // The name of a variant or fixture continues the sensor's after a hyphen.
    let builtin = builtin_names().into_iter().filter(|builtin| {
        name.strip_prefix(builtin).is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
    });
    let shown = |path: &str, value: &str| format!("{path} = {value}");
    // One name may begin with another, so the longest match counts.
    let Some(builtin) = builtin.max_by_key(|builtin| builtin.len()) else {
        let given = design.parameters.iter().filter(|s| s.source.kind == SourceKind::User);
        return Some(given.map(|s| shown(&s.path, &s.value)).collect());
    };
    let project = fabkit_fixtures::load(builtin, builtin_yaml(builtin)?, &[]).ok()?;
    let is_same = |path: &str, value: &str| {
        project.settings().any(|setting| setting.path == path && setting.value == value)
    };
    // Values computed from expressions follow from other changes and are not listed.
    let own = design.parameters.iter().filter(|setting| setting.expression.is_none());
    let other = own.filter(|s| !is_same(&s.path, &s.value));
    let other: Vec<String> = other.map(|s| shown(&s.path, &s.value)).collect();
    (!other.is_empty()).then_some(other)
}
