//! Layers that give: what a press does to soft layers that are bonded to each other and to what is stiff.
//!
//! Exact meridians in; displacements of every interface, tractions, contact and slip, force and moment out.
//! Nothing here knows what looks at the layers.
//!
//! # Conventions
//!
//! - Millimetres, radians, newtons, MPa (N/mm2), `f64`. Names carry the unit.
//! - A [`Body`] is of revolution about the z axis of its own frame; whatever presses is placed in the same
//!   frame. Interfaces are counted from the touched one, 0, inwards. On each, s runs from 0 on the axis to 1 at
//!   the rim.
//! - The outward normal points out of the soft body; a gap along it is positive where the presser is away.
//! - Forces and tractions are those of the presser on the body.
//!
//! # What is solved
//!
//! [`Level::Linear`]: small strain, isotropic layers, contact along the surface's normals at rest.
//! Displacements are expanded in harmonics of the azimuth; each is solved on the meridian with biquadratic
//! displacements and pressures that are linear in each element, so that Poisson's ratios up to
//! [`MAX_POISSON_RATIO`] neither lock nor lose volume. Pressures on the touched surface are linear along s
//! between nodes and trigonometric around. They push or vanish, and friction follows Coulomb's law
//! ([`Press::sheared`]): what the presser holds goes along with it, so that its print is where the surface
//! has been dragged, to 3 % of the way where sharp edges let go of nodes one by one. All is in proportion to
//! tractions. How far off that is for deep presses, the other level tells.
//!
//! [`Level::Finite`]: the same bodies and elements with a neo-Hookean material at any strain, for what is
//! symmetric about the axis alone, a few seconds a press ([`FiniteStack`]): it tells how far the other one is
//! off.
//!
//! What is flat and has channels of liquid in it is solved in three dimensions, by bricks ([`Slab`],
//! [`LiquidStack`]): a press squeezes liquid into columns, and air that is shut in ahead of them pushes back.
//!
//! A [`Stack`] is made once for a design, solves what a press needs when it comes (a second), keeps it, and is then
//! pressed in milliseconds. What does not converge is an error.
//!
//! ```
//! use fabkit_elastic::{Ball, Body, Curve, Division, Hold, Layer, Material, Press, Stack};
//! use fabkit_geometry::{Point3, Vector3};
//!
//! // A half ellipsoid of soft gel, 2 mm thick at its tip, on a stiff one; its rim is bonded.
//! let half_ellipsoid = |equator_mm: f64, pole_mm: f64| {
//!     Curve::new(move |s| {
//!         let angle = s * std::f64::consts::FRAC_PI_2;
//!         [equator_mm * angle.sin(), pole_mm * angle.cos()]
//!     })
//! };
//! let gel = Layer { name: "gel".to_owned(), material: Material::new(0.2, 0.495)? };
//! let body = Body {
//!     interfaces: vec![half_ellipsoid(10.0, 12.0), half_ellipsoid(8.0, 10.0)],
//!     layers: vec![gel],
//!     inner: Hold::Bonded,
//!     is_rim_bonded: true,
//!     kinks: vec![],
//! };
//! let stack = Stack::new(&body, &Division::even(0.4, 16), 1)?;
//!
//! // A ball comes down beside the tip, half a millimetre deep, and is then dragged sideways.
//! let ball = Ball::new(Point3::new(1.0, 0.0, 20.0), 3.0)?;
//! let press = Press::along(-Vector3::z(), 0.5)?;
//! let pressed = stack.press(&ball, &press)?;
//! assert!(pressed.force_n.z < 0.0);
//! assert!(pressed.bulge_mm > 0.0 && pressed.contact_radius_mm < 1.8);
//! let at_the_tip = pressed.displacement_mm(0, 0.0, 0.0);
//! assert!(at_the_tip.z < -0.2);
//!
//! let sheared = stack.press(&ball, &press.sheared(0.8, Vector3::new(0.0, 0.1, 0.0), 2)?)?;
//! assert!(sheared.force_n.y > 0.0 && sheared.stick_area_mm2 < sheared.contact_area_mm2);
//! # Ok::<(), fabkit_elastic::ElasticError>(())
//! ```

#![forbid(unsafe_code)]

mod ball_test;
mod compliance;
mod contact;
mod division;
mod element;
mod error;
mod field;
mod finite;
mod friction;
mod harmonic;
mod liquid;
mod material;
mod meridian;
mod mesh;
mod outcome;
mod patch;
mod presser;
mod response;
mod rings;
mod slab;
mod soft;
mod stack;

pub use ball_test::{BallModulus, BallReading, BallTest, BallTestError};
pub use division::Division;
pub use error::{ElasticError, MAX_POISSON_RATIO};
pub use field::Field;
pub use finite::FiniteStack;
pub use liquid::{
    AIR_MPA, ChannelMoved, Column, LiquidOutcome, LiquidReady, LiquidStack, SkinNode,
};
pub use material::Material;
pub use meridian::{Body, Curve, Hold, Layer};
pub use outcome::{Level, Outcome, SurfaceNode, Touch};
pub use presser::{Ball, Press, Presser, SolidPresser};
pub use slab::{Cell, Slab, SlabField};
pub use soft::{BondLine, MarkMoved, Place, SoftError, SoftLayer, SoftStack, TipPress, Yielded};
pub use stack::Stack;
