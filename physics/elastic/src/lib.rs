//! Elastic deformation of soft layers that are bonded to each other and to rigid parts.
//!
//! Input: exact meridians of the interfaces, materials and an indenter. Output: displacements of every interface,
//! tractions, contact and slip regions, force and moment. The crate knows nothing about cameras or optics.
//!
//! # Conventions
//!
//! - Millimetres, radians, newtons, MPa (N/mm2), `f64`. Names carry the unit.
//! - A [`LayeredBody`] is a solid of revolution about the z axis of its own frame; the indenter is placed in the same frame.
//!   Interfaces are counted inwards from the touched surface, which is 0. On each, s runs from 0 on the axis to 1 at
//!   the rim.
//! - The outward normal points out of the soft body; a gap along it is positive where the indenter is clear of the
//!   surface.
//! - Forces and tractions are those of the indenter on the body.
//!
//! # Models
//!
//! [`StrainTheory::Linear`]: small strain, isotropic layers, contact along the normals of the undeformed surface.
//! Displacements are expanded in harmonics of the azimuth. Each harmonic is solved on the meridian section with
//! biquadratic displacements and pressures that are linear within each element, so that Poisson's ratios up to
//! [`MAX_POISSON_RATIO`] neither lock nor lose volume. Pressures on the touched surface are linear along s between
//! nodes and trigonometric in the azimuth. Contact pressures are never tensile, and friction follows Coulomb's law
//! ([`Press::with_shear`]). Surface that sticks to the indenter moves with it, so the contact region follows the dragged
//! surface, to 3 % of the shear displacement where sharp edges release nodes one by one. Displacements are proportional
//! to tractions. [`StrainTheory::Finite`] shows how large the error is for deep presses.
//!
//! [`StrainTheory::Finite`]: the same bodies and elements with a neo-Hookean material at any strain, for axisymmetric presses
//! only ([`FiniteStack`]). It takes a few seconds a press and serves to check the linear model.
//!
//! Flat pads with liquid-filled channels are solved in three dimensions with brick elements ([`Slab`],
//! [`LiquidStack`]): a press displaces liquid into columns, and the air enclosed ahead of the liquid pushes back.
//!
//! A [`ElasticStack`] is built once for a design. It solves the harmonics that a press needs on demand (about a second),
//! caches them, and then evaluates further presses in milliseconds. A computation that does not converge is an error.
//!
//! ```
//! use fabkit_elastic::{BallIndenter, LayeredBody, MeridianCurve, MeshDensity, BoundaryCondition, ElasticLayer, ElasticMaterial, Press, ElasticStack};
//! use fabkit_geometry::{Point3, Vector3};
//!
//! // A half ellipsoid of soft gel, 2 mm thick at its tip, on a stiff one; its rim is bonded.
//! let half_ellipsoid = |equator_mm: f64, pole_mm: f64| {
//!     MeridianCurve::new(move |s| {
//!         let angle = s * std::f64::consts::FRAC_PI_2;
//!         [equator_mm * angle.sin(), pole_mm * angle.cos()]
//!     })
//! };
//! let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.495)? };
//! let body = LayeredBody {
//!     interfaces: vec![half_ellipsoid(10.0, 12.0), half_ellipsoid(8.0, 10.0)],
//!     layers: vec![gel],
//!     inner: BoundaryCondition::Bonded,
//!     is_rim_bonded: true,
//!     kinks: vec![],
//! };
//! let stack = ElasticStack::new(&body, &MeshDensity::uniform(0.4, 16), 1)?;
//!
//! // A ball comes down beside the tip, half a millimetre deep, and is then dragged sideways.
//! let ball = BallIndenter::new(Point3::new(1.0, 0.0, 20.0), 3.0)?;
//! let press = Press::along(-Vector3::z(), 0.5)?;
//! let pressed = stack.press(&ball, &press)?;
//! assert!(pressed.force_n.z < 0.0);
//! assert!(pressed.bulge_mm > 0.0 && pressed.contact_radius_mm < 1.8);
//! let at_the_tip = pressed.displacement_mm(0, 0.0, 0.0);
//! assert!(at_the_tip.z < -0.2);
//!
//! let sheared = stack.press(&ball, &press.with_shear(0.8, Vector3::new(0.0, 0.1, 0.0), 2)?)?;
//! assert!(sheared.force_n.y > 0.0 && sheared.stick_area_mm2 < sheared.contact_area_mm2);
//! # Ok::<(), fabkit_elastic::ElasticError>(())
//! ```

#![forbid(unsafe_code)]

mod ball_indentation;
mod compliance;
mod contact;
mod element;
mod error;
mod field;
mod finite;
mod friction;
mod harmonic;
mod indenter;
mod liquid;
mod material;
mod meridian;
mod mesh;
mod mesh_density;
mod outcome;
mod patch;
mod resources;
mod response;
mod rings;
mod slab;
mod soft;
mod stack;

pub use ball_indentation::{
    BallIndentationError, BallIndentationTest, BallModulus, IndentationReading,
};
pub use error::{ElasticError, MAX_POISSON_RATIO};
pub use field::DisplacementField;
pub use finite::FiniteStack;
pub use indenter::{BallIndenter, Indenter, Press, SolidIndenter};
pub use liquid::{
    AMBIENT_AIR_MPA, ChannelOutcome, LiquidColumn, LiquidOutcome, LiquidSolver, LiquidStack,
    SkinNode,
};
pub use material::ElasticMaterial;
pub use meridian::{BoundaryCondition, ElasticLayer, LayeredBody, MeridianCurve};
pub use mesh_density::MeshDensity;
pub use outcome::{ContactState, PressOutcome, StrainTheory, SurfaceNode};
pub use resources::SolverResources;
pub use slab::{BrickContents, Slab, SlabField};
pub use soft::{
    BondLine, DeformedSurface, DisplacedMarker, PressPoint, SoftError, SoftLayer, SoftStack,
    TipPressOutcome,
};
pub use stack::ElasticStack;
