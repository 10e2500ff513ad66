//! Errors of the elastic solver.

/// Largest accepted Poisson's ratio, without unit.
///
/// At this ratio the bulk stiffness, `2 nu / (1 - 2 nu)` times the shear stiffness, is 5,000 times as large, which
/// costs a factorisation about four of its sixteen digits. No silicone is known more precisely to be incompressible.
pub const MAX_POISSON_RATIO: f64 = 0.4999;

/// Errors of a body, a mesh, a press or an iteration.
///
/// ```
/// use fabkit_elastic::{ElasticError, ElasticMaterial};
///
/// // Errors say what to do.
/// let error = ElasticMaterial::new(0.2, 0.5).unwrap_err();
/// assert_eq!(error, ElasticError::Poisson { poisson: 0.5 });
/// assert!(error.to_string().ends_with("take 0.495 for silicone, or 0.4999 for what is incompressible"));
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ElasticError {
    /// Young's modulus that is not positive and finite.
    #[error(
        "a Young's modulus of {young_mpa} MPa is not positive and finite; \
         silicones lie between 0.02 and 5 MPa"
    )]
    Young {
        /// Given value.
        young_mpa: f64,
    },
    /// Poisson's ratio outside 0 to [`MAX_POISSON_RATIO`].
    #[error(
        "a Poisson's ratio of {poisson} is not within 0 to {MAX_POISSON_RATIO}; \
         take 0.495 for silicone, or {MAX_POISSON_RATIO} for what is incompressible"
    )]
    Poisson {
        /// Given value.
        poisson: f64,
    },
    /// Numbers of layers and interfaces that do not match.
    #[error(
        "{layers} layers need {} interfaces, from the touched one inwards, not {interfaces}", .layers + 1
    )]
    Interfaces {
        /// Number of layers.
        layers: usize,
        /// Number of interfaces.
        interfaces: usize,
    },
    /// Curve that leaves the half plane, or begins off the axis.
    #[error(
        "interface {interface} is at radius {radius_mm} mm, height {height_mm} mm at s = {s}: \
         it must begin on the axis and stay at positive radii"
    )]
    Curve {
        /// Index of the interface, counted from the touched surface, 0.
        interface: usize,
        /// Parameter along the curve, 0 to 1.
        s: f64,
        /// Radius that the curve returns, mm.
        radius_mm: f64,
        /// Height that the curve returns, mm.
        height_mm: f64,
    },
    /// Layer without thickness, or interfaces that cross.
    #[error(
        "layer {layer:?} has no thickness, or is folded, at radius {radius_mm:.4} mm, height {height_mm:.4} mm: \
         interfaces must follow each other inwards, and s must mean about the same place on both"
    )]
    Folded {
        /// Name of the layer.
        layer: String,
        /// Radius of the place, mm.
        radius_mm: f64,
        /// Height of the place, mm.
        height_mm: f64,
    },
    /// Body without a bonded boundary.
    #[error("nothing holds the body: bond its innermost interface, or its rim")]
    NotBonded,
    /// Invalid number of a division.
    #[error("{what} of {value} cannot divide a body; {hint}")]
    MeshDensity {
        /// Name of the number.
        what: &'static str,
        /// Given value.
        value: f64,
        /// Permitted values.
        hint: &'static str,
    },
    /// More memory than allowed.
    #[error(
        "{harmonics} harmonics of {rings} rings take {needed_mib} MiB, more than {limit_mib}: \
         take a wider spacing, or fewer harmonics"
    )]
    TooLarge {
        /// Number of harmonics.
        harmonics: usize,
        /// Number of rings.
        rings: usize,
        /// Memory needed, MiB.
        needed_mib: usize,
        /// Memory allowed, MiB.
        limit_mib: usize,
    },
    /// Slab with too many nodes.
    #[error("{unknowns} unknowns are more than {limit}: take a wider spacing")]
    TooFine {
        /// Number of unknowns (or of nodes in contact) that there would be.
        unknowns: usize,
        /// Number allowed.
        limit: usize,
    },
    /// Factorisation that failed, for example at a pivot that is not positive.
    #[error("harmonic {harmonic} cannot be factorised: {reason}")]
    Factorisation {
        /// Harmonic of the azimuth.
        harmonic: usize,
        /// Message of the solver.
        reason: String,
    },
    /// Indenter that does not reach the surface.
    #[error("the indenter does not touch the surface: it is {gap_mm} mm away; move it in")]
    NoContact {
        /// Smallest gap along the surface's normals, mm; infinite where none of them meets the indenter.
        gap_mm: f64,
    },
    /// Indenter that fits between the nodes.
    #[error(
        "the indenter reaches {depth_mm:.3} mm deep but holds no node: its print is smaller than the distance of \
         nodes; take a smaller spacing, and more harmonics"
    )]
    TooCoarse {
        /// Depth of the indenter along the surface's normal, mm.
        depth_mm: f64,
    },
    /// Indenter that does not start outside.
    #[error(
        "on its way the indenter starts {inside_mm:.3} mm inside the surface, or behind it: \
         place it outside, and let it move towards the body"
    )]
    StartsInside {
        /// Distance back to the first touch, mm.
        inside_mm: f64,
    },
    /// Press deeper than the soft layers.
    #[error(
        "a press of {depth_mm:.3} mm at ({:.2}, {:.2}, {:.2}) mm is not within the {thickness_mm:.3} mm \
         of what is soft there: press less deep", .place_mm[0], .place_mm[1], .place_mm[2]
    )]
    TooDeep {
        /// Depth along the surface's normal, mm.
        depth_mm: f64,
        /// Thickness of all layers at that place, mm.
        thickness_mm: f64,
        /// Point of the undeformed surface, frame of the body, mm.
        place_mm: [f64; 3],
    },
    /// Invalid number of a press.
    #[error("{what} of {value} is not {hint}")]
    Press {
        /// Name of the number.
        what: &'static str,
        /// Given value.
        value: f64,
        /// Permitted values.
        hint: &'static str,
    },
    /// Iteration that did not converge.
    #[error(
        "{what} did not converge in {iterations} iterations: {residual:.3e} is left, \
         {tolerance:.3e} is asked for"
    )]
    NoConvergence {
        /// Name of the iteration.
        what: &'static str,
        /// Number of iterations.
        iterations: usize,
        /// Remaining residual.
        residual: f64,
        /// Required tolerance.
        tolerance: f64,
    },
}
