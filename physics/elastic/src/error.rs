//! Why a press has no result.

/// Poisson's ratio up to which a solution keeps its digits, without unit.
///
/// The bulk stiffness is `2 nu / (1 - 2 nu)` times the shear stiffness, 5,000 times here, and so many digits
/// of sixteen are lost in a factorisation. No silicone is known more closely to be incompressible.
pub const MAX_POISSON_RATIO: f64 = 0.4999;

/// What a body, a press or an iteration cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ElasticError {
    /// A modulus that no material has.
    #[error(
        "a Young's modulus of {young_mpa} MPa is not positive and finite; \
         silicones lie between 0.02 and 5 MPa"
    )]
    Young {
        /// As told.
        young_mpa: f64,
    },
    /// Poisson's ratio of no material, or of one that cannot be told from incompressible.
    #[error(
        "a Poisson's ratio of {poisson} is not within 0 to {MAX_POISSON_RATIO}; \
         take 0.495 for silicone, or {MAX_POISSON_RATIO} for what is incompressible"
    )]
    Poisson {
        /// As told.
        poisson: f64,
    },
    /// Layers and interfaces that do not go together.
    #[error(
        "{layers} layers need {} interfaces, from the touched one inwards, not {interfaces}", .layers + 1
    )]
    Interfaces {
        /// How many layers.
        layers: usize,
        /// How many interfaces.
        interfaces: usize,
    },
    /// A curve that leaves the half plane, or begins off the axis.
    #[error(
        "interface {interface} is at radius {radius_mm} mm, height {height_mm} mm at s = {s}: \
         it must begin on the axis and stay at positive radii"
    )]
    Curve {
        /// Counted from the touched surface, 0.
        interface: usize,
        /// Where along it, 0 to 1.
        s: f64,
        /// As the curve says.
        radius_mm: f64,
        /// As the curve says.
        height_mm: f64,
    },
    /// A layer without thickness, or interfaces that cross.
    #[error(
        "layer {layer:?} has no thickness, or is folded, at radius {radius_mm:.4} mm, height {height_mm:.4} mm: \
         interfaces must follow each other inwards, and s must mean about the same place on both"
    )]
    Folded {
        /// Which layer.
        layer: String,
        /// Where.
        radius_mm: f64,
        /// Where.
        height_mm: f64,
    },
    /// A body that nothing holds.
    #[error("nothing holds the body: bond its innermost interface, or its rim")]
    Loose,
    /// A division that is none.
    #[error("{what} of {value} cannot divide a body; {hint}")]
    Division {
        /// Which number.
        what: &'static str,
        /// As told.
        value: f64,
        /// What it may be.
        hint: &'static str,
    },
    /// More unknowns than fit into memory.
    #[error(
        "{harmonics} harmonics of {rings} rings take {needed_mib} MiB, more than {limit_mib}: \
         take a wider spacing, or fewer harmonics"
    )]
    TooLarge {
        /// How many.
        harmonics: usize,
        /// How many.
        rings: usize,
        /// How much.
        needed_mib: usize,
        /// How much is allowed.
        limit_mib: usize,
    },
    /// Nodes of a slab that are too near to each other.
    #[error("{unknowns} unknowns are more than {limit}: take a wider spacing")]
    TooFine {
        /// How many there would be.
        unknowns: usize,
        /// How many are allowed.
        limit: usize,
    },
    /// A factorisation that met a pivot that is not positive.
    #[error("harmonic {harmonic} cannot be factorised: {reason}")]
    Factorisation {
        /// Which harmonic of the azimuth.
        harmonic: usize,
        /// What the solver says.
        reason: String,
    },
    /// A presser that does not reach the surface.
    #[error("the presser does not touch the surface: it is {gap_mm} mm away; move it in")]
    NoContact {
        /// The least gap along the surface's normals, mm; infinite where none of them meets the presser.
        gap_mm: f64,
    },
    /// A presser that slips between the nodes.
    #[error(
        "the presser reaches {depth_mm:.3} mm deep but holds no node: its print is smaller than the distance of \
         nodes; take a smaller spacing, and more harmonics"
    )]
    TooCoarse {
        /// Along the surface's normal, mm.
        depth_mm: f64,
    },
    /// A presser that does not come from outside.
    #[error(
        "on its way the presser starts {inside_mm:.3} mm inside the surface, or behind it: \
         place it outside, and let it move towards the body"
    )]
    StartsInside {
        /// How far back it would have to go to touch, mm.
        inside_mm: f64,
    },
    /// A presser deeper than what is soft.
    #[error(
        "a press of {depth_mm:.3} mm at ({:.2}, {:.2}, {:.2}) mm is not within the {thickness_mm:.3} mm \
         of what is soft there: press less deep", .place_mm[0], .place_mm[1], .place_mm[2]
    )]
    TooDeep {
        /// Along the surface's normal, mm.
        depth_mm: f64,
        /// Of all layers at that place, mm.
        thickness_mm: f64,
        /// The place on the surface at rest, frame of the body.
        place_mm: [f64; 3],
    },
    /// A number of a press that is none.
    #[error("{what} of {value} is not {hint}")]
    Press {
        /// Which number.
        what: &'static str,
        /// As told.
        value: f64,
        /// What it may be.
        hint: &'static str,
    },
    /// An iteration that did not end.
    #[error(
        "{what} did not converge in {iterations} iterations: {residual:.3e} is left, \
         {tolerance:.3e} is asked for"
    )]
    NoConvergence {
        /// Which iteration.
        what: &'static str,
        /// How many were done.
        iterations: usize,
        /// What is left.
        residual: f64,
        /// What is asked for.
        tolerance: f64,
    },
}
