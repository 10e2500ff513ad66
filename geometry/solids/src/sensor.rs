//! Complete sensor: bodies, connections between them, camera and manufacturing chain.

use crate::{
    Adhesion, Body, BodyKind, Circuit, Lighting, LiquidSkin, Marker, MotionLeg, NominalCamera,
    Pose, Step, TouchSurface, VisibleEffect,
};

/// Group of parts of several materials that are printed as one piece.
///
/// Their solids are in one frame and touch without overlap; their files share coordinates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PrintGroup {
    /// Name, `[a-z0-9-]{1,64}`; also that of the file that contains all parts.
    pub name: String,
    /// Names of the parts. The first one determines the orientation on the bed.
    pub parts: Vec<String>,
}

/// Intended overlap of two bodies: a press fit, a self-cutting thread.
#[derive(Clone, Debug, PartialEq)]
pub struct PressFit {
    /// Name of the body that is pressed in.
    pub inner: String,
    /// Name of the body that holds it.
    pub outer: String,
    /// Largest intended overlap, mm, measured across the fit's surface (per side).
    pub interference_mm: f64,
    /// Reason for the overlap.
    pub reason: String,
}

/// Layer that is cast onto a body that it does not stick to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnbondedLayer {
    /// Name of the step that casts it.
    pub step: String,
    /// Name of the layer.
    pub layer: String,
    /// Name of the body below it.
    pub substrate: String,
}

/// Detachable tip: bodies behind it may be wider, and fixtures go around the tip alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Detachable {
    /// Names of the bodies that are detached.
    pub bodies: Vec<String>,
    /// Path by which the rest returns to the tip, sensor frame.
    pub back: Vec<MotionLeg>,
    /// The same path in words, without a full stop.
    pub instruction: String,
}

/// Complete sensor, ready for export, rendering and checks.
///
/// Sensor frame: origin at the centre of the sensing surface's base circle, +z toward the tip.
///
/// ```
/// use fabkit_geometry::{Angle, Body, NominalCamera, NominalLens, Pose, Process, Sensor, Solid};
/// let screw = Body::bought("screw", "M2 x 5", Solid::cylinder(1.0, 5.0));
/// let base = Body::made("base", "carries all", Process::Fdm, Solid::cylinder(12.0, 3.0));
/// let camera = NominalCamera {
///     sensor_from_camera: Pose::translation(0.0, 0.0, -30.0),
///     width_px: 640,
///     height_px: 480,
///     field_of_view: Angle::from_deg(120.0).unwrap(),
///     lens: NominalLens::default(),
/// };
/// let sensor = Sensor::new("mine", "My sensor", "unpublished", camera, [screw, base]);
/// assert_eq!((&*sensor.bodies[0].name, sensor.components().count()), ("base", 1)); // parts come first
/// ```
#[derive(Clone, Debug)]
pub struct Sensor {
    /// Name, `[a-z0-9-]{1,64}`.
    pub name: String,
    /// Title for readers.
    pub title: String,
    /// Reference of the paper.
    pub reference: String,
    /// Bodies that it consists of and is made with: parts, then layers, then components; see [`sort_by_kind`].
    pub bodies: Vec<Body>,
    /// Manufacturing steps in order.
    pub chain: Vec<Step>,
    /// Groups of parts that are printed as one piece.
    pub print_groups: Vec<PrintGroup>,
    /// Intended overlaps.
    pub press_fits: Vec<PressFit>,
    /// Layers stated not to stick to the body below them.
    pub loose: Vec<UnbondedLayer>,
    /// Stated adhesion between bodies.
    pub adhesions: Vec<Adhesion>,
    /// Pairs of bodies that the camera tells apart because one is dark and the other light.
    pub contrasts: Vec<[String; 2]>,
    /// Markers that the camera tracks while the gel moves; empty if there are none.
    pub marks: Vec<Marker>,
    /// Lighting modes, the usual one first; empty if unknown.
    pub lightings: Vec<Lighting>,
    /// Bit depth of the camera's intensities.
    pub intensity_bits: u32,
    /// JPEG quality of the camera's images, 1 to 100; `None` if they are not compressed.
    pub jpeg_quality: Option<u8>,
    /// Force that the touched surface must bear in every direction, N; `None` if there is no requirement.
    pub required_load_n: Option<f64>,
    /// Nominal camera.
    pub camera: NominalCamera,
    /// Names of the bodies that the camera is meant to see; empty if there is no camera.
    pub visible_bodies: Vec<String>,
    /// Sensing surface; `None` if nothing is known to press it.
    pub touch: Option<TouchSurface>,
    /// Pressed skin with liquid channels, another kind of sensing surface.
    pub liquid: Option<LiquidSkin>,
    /// Detachable part that fixtures hold.
    pub detachable: Option<Detachable>,
    /// Pose of the mounting face: centre of the robot's hole pattern or of the sensor's own lower face, z towards the
    /// sensor, as out of a robot's flange. `None` if no such face is known.
    pub mount: Option<Pose>,
    /// Electric circuits: etched boards, soldered parts and wiring.
    pub circuits: Vec<Circuit>,
}

/// Sorts parts before layers before components, each in their own order. All lists and files use this order.
///
/// ```
/// use fabkit_geometry::{Body, Process, Solid, sort_by_kind};
/// let ball = || Solid::sphere(1.0);
/// let led = Body::bought("led", "white, 0603", ball());
/// let skin = Body::cast("skin", "black silicone", ball());
/// let mold = Body::made("mold", "upper half", Process::Sla, ball());
/// let core = Body::made("core", "inner half", Process::Sla, ball());
/// let names: Vec<String> =
///     sort_by_kind([led, skin, mold, core]).into_iter().map(|b| b.name).collect();
/// assert_eq!(names, ["mold", "core", "skin", "led"]);
/// ```
pub fn sort_by_kind(bodies: impl IntoIterator<Item = Body>) -> Vec<Body> {
    // A separate non-generic function, so that it is compiled once and not for every iterator type.
    fn sorted(mut bodies: Vec<Body>) -> Vec<Body> {
        bodies.sort_by_key(|body| match body.kind {
            BodyKind::Made(_) => 0,
            BodyKind::Cast => 1,
            BodyKind::Bought => 2,
        });
        bodies
    }
    sorted(bodies.into_iter().collect())
}

impl Sensor {
    /// Creates a sensor from bodies and a camera, without chain, press fits and sensing surface.
    pub fn new(
        name: impl Into<String>,
        title: impl Into<String>,
        reference: impl Into<String>,
        camera: NominalCamera,
        bodies: impl IntoIterator<Item = Body>,
    ) -> Self {
        Self {
            name: name.into(),
            title: title.into(),
            reference: reference.into(),
            bodies: sort_by_kind(bodies),
            chain: Vec::new(),
            print_groups: Vec::new(),
            press_fits: Vec::new(),
            loose: Vec::new(),
            adhesions: Vec::new(),
            contrasts: Vec::new(),
            marks: Vec::new(),
            lightings: Vec::new(),
            intensity_bits: 8,
            jpeg_quality: None,
            required_load_n: None,
            camera,
            visible_bodies: Vec::new(),
            touch: None,
            liquid: None,
            detachable: None,
            mount: None,
            circuits: Vec::new(),
        }
    }

    /// Returns the made parts, each with its process.
    pub fn parts(&self) -> impl Iterator<Item = &Body> + Clone {
        self.bodies.iter().filter(|body| body.is_made())
    }

    /// Returns the cast layers.
    pub fn layers(&self) -> impl Iterator<Item = &Body> + Clone {
        self.bodies.iter().filter(|body| body.kind == BodyKind::Cast)
    }

    /// Returns the bought components.
    pub fn components(&self) -> impl Iterator<Item = &Body> + Clone {
        self.bodies.iter().filter(|body| body.kind == BodyKind::Bought)
    }

    /// Returns the body with this name.
    pub fn body(&self, name: &str) -> Option<&Body> {
        self.bodies.iter().find(|body| body.name == name)
    }

    /// Returns whether a lighting shows the positions of the markers that a body contains.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, NominalCamera, Pose};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// use fabkit_geometry::{Lighting, Sensor, VisibleEffect};
    /// let mut sensor = Sensor::new("tip", "A tip", "", camera, []);
    /// let effect = VisibleEffect::Markers { marks: "dots".into() };
    /// sensor.lightings = vec![Lighting::from_body("white", "led", effect)];
    /// assert!(sensor.is_marker_body("dots") && !sensor.is_marker_body("skin"));
    /// ```
    pub fn is_marker_body(&self, name: &str) -> bool {
        self.lightings.iter().any(|lighting| {
            matches!(&lighting.effect, VisibleEffect::Markers { marks } if marks == name)
        })
    }

    /// Returns the body with this name for modification.
    pub fn body_mut(&mut self, name: &str) -> Option<&mut Body> {
        self.bodies.iter_mut().find(|body| body.name == name)
    }
}
