//! Building blocks that several families share.

pub mod adapter;
pub mod bayonet;
pub mod board_camera;
pub mod cable;
pub mod cable_openings;
pub mod chamber_light;
pub mod circuit;
pub mod clamshell;
pub mod cup_and_bridge;
pub mod edge;
pub mod frame_mold;
mod joint;
pub mod label;
mod led_ring;
pub mod lighting;
pub mod listed_markers;
pub mod marker_grid;
pub mod mold;
pub mod mounting;
mod o_ring_seat;
pub mod optics;
pub mod posted_camera;
mod rect;
pub mod sprue;
mod vented_lid;

use std::f64::consts::{PI, TAU};

use fabkit_geometry::{
    Angle, Body, Color, CutFeature, EllipsoidOffset, Landmark, NominalCamera, NominalLens, Point3,
    Pose, PressFit, Sensor, Solid, Vector3,
};

use crate::Header;
use crate::chain_builder::Name;

pub(crate) use board_camera::{BoardCamera, board_camera};
pub use joint::ScrewJoint;
pub(crate) use led_ring::{LedRing, led_ring};
pub use o_ring_seat::ORingSeat;
pub use rect::Rect;
pub use vented_lid::VentedLid;

/// Default values for every family that has the parameter: file name for messages, and YAML text.
pub(crate) const DEFAULTS: (&str, &str) = ("blocks.yaml (defaults)", include_str!("defaults.yaml"));

crate::bodies! {
    /// LED.
    pub LED "led";
    /// Wire of the LEDs.
    pub LED_WIRE "led-wire";
    /// Camera.
    pub CAMERA "camera";
    /// Cable of the camera.
    pub CAMERA_CABLE "camera-cable";
    /// Steel pins that align mold halves and frames.
    pub DOWEL "dowel";
}

/// Smallest gap between parts that must not touch, mm.
pub const APART_MM: f64 = 0.1;

/// Thinnest printed wall, mm: two lines of a 0.4 mm nozzle.
pub const PRINTED_WALL_MM: f64 = 0.8;

/// Overlap between pieces of one body, mm, so that no faces coincide.
pub const INTO_MM: f64 = 0.2;

/// Colour of black plastic in drawings: light enough that its edges are visible.
pub const BLACK: Color = [92, 96, 104];

/// Colour of white plastic, darker than paper.
pub const WHITE: Color = [236, 236, 232];

/// Colour of brass.
pub const BRASS: Color = [205, 170, 90];

/// Colour of glass and clear acrylic.
pub const GLASS: Color = [190, 215, 225];

/// Colour of rubber.
pub const RUBBER: Color = [30, 30, 30];

/// Colour of a circuit board's solder mask.
pub const MASK_GREEN: Color = [40, 120, 70];

/// Colour of a camera's board with its lens.
pub const CAMERA_GREEN: Color = [35, 60, 45];

/// Colour of a white LED.
pub const LED_YELLOW: Color = [250, 240, 170];

/// Colour of molds.
pub const MOLD_BLUE: Color = [120, 160, 205];

/// Colour of printed tools other than molds.
pub const TOOL_GREY: Color = [180, 184, 190];

/// Returns the angle of position `index` out of `count` equal steps around the axis, shifted by `offset` steps.
///
/// ```
/// use fabkit_designs::blocks::turn;
/// // The first of four positions, shifted by half a step: on the diagonal.
/// assert!((turn(0, 4, 0.5).deg() - 45.0).abs() < 1e-12);
/// ```
pub fn turn(index: u32, count: u32, offset: f64) -> Angle {
    let rad = TAU * (f64::from(index) + offset) / f64::from(count);
    Angle::from_rad(rad).expect("a fraction of a turn is finite")
}

/// Returns `first` turned around the z axis to `count` positions, shifted by `offset` steps.
///
/// ```
/// use fabkit_designs::blocks::ring;
/// use fabkit_geometry::Pose;
/// let places = ring(4, 0.0, Pose::translation(10.0, 0.0, -3.0));
/// // Counter-clockwise seen from above: the second one is on +y.
/// let second = places[1].translation_mm();
/// assert!((second.y - 10.0).abs() < 1e-12 && second.x.abs() < 1e-12 && second.z == -3.0);
/// ```
pub fn ring(count: u32, offset: f64, first: Pose) -> Vec<Pose> {
    (0..count).map(|i| Pose::rotation_z(turn(i, count, offset)).then_in(first)).collect()
}

/// Returns the number of pieces of a width (mm) that fit side by side on a circle, not rounded.
///
/// ```
/// use fabkit_designs::blocks::around;
/// // Six circles fit around a circle of their own size.
/// assert!((around(2.0, 2.0) - 6.0).abs() < 1e-9);
/// ```
pub fn around(radius_mm: f64, width_mm: f64) -> f64 {
    // Each piece takes the angle of its chord.
    PI / (width_mm / 2.0 / radius_mm).clamp(0.0, 1.0).asin()
}

/// Returns half the length of a circle's chord at a distance from its centre; 0 outside.
///
/// ```
/// use fabkit_designs::blocks::half_chord;
/// assert_eq!(half_chord(5.0, 3.0), 4.0);
/// assert_eq!(half_chord(5.0, 6.0), 0.0);
/// ```
pub fn half_chord(radius_mm: f64, distance_mm: f64) -> f64 {
    (radius_mm.powi(2) - distance_mm.powi(2)).max(0.0).sqrt()
}

/// Returns the four corners of a rectangle with these half edges, counter-clockwise.
pub fn corners([x, y]: [f64; 2]) -> [[f64; 2]; 4] {
    [[x, y], [-x, y], [-x, -y], [x, -y]]
}

/// Returns an upright pose at (x, y) and height z.
pub fn upright([x, y]: [f64; 2], z: f64) -> Pose {
    Pose::translation(x, y, z)
}

/// Returns an upside-down pose at (x, y) and height z: its z axis points down.
///
/// ```
/// use fabkit_designs::blocks::hanging;
/// use fabkit_geometry::Point3;
/// // A point 2 mm along the body's own z lies 2 mm lower.
/// let below = hanging([1.0, 0.0], 5.0).point(Point3::new(0.0, 0.0, 2.0));
/// assert!((below - Point3::new(1.0, 0.0, 3.0)).norm() < 1e-12);
/// ```
pub fn hanging([x, y]: [f64; 2], z: f64) -> Pose {
    Pose::z_to(-Vector3::z(), Point3::new(x, y, z))
}

/// Returns landmarks `label 1`, `label 2`, ... at the poses.
pub fn landmarks_at(label: &str, poses: &[Pose]) -> Vec<Landmark> {
    poses.iter().zip(1..).map(|(pose, i)| Landmark::at(format!("{label} {i}"), pose)).collect()
}

/// Returns copies `label 1`, `label 2`, ... of a solid at the poses.
pub fn copies(label: &str, poses: &[Pose], solid: &Solid) -> Vec<Solid> {
    let copy = |(pose, i)| solid.clone().placed(pose).named(format!("{label} {i}"));
    poses.iter().copied().zip(1..).map(copy).collect()
}

/// Returns a cut of holes without landmarks, none of them counted as a handle.
pub fn holes(tools: impl IntoIterator<Item = Solid>) -> CutFeature {
    CutFeature { tools: tools.into_iter().collect(), ..CutFeature::default() }
}

/// Merges components of the same name: placements and quantities add up.
///
/// ```
/// use fabkit_designs::blocks::merged;
/// use fabkit_designs::chain_builder::{bought, in_sensor};
/// use fabkit_geometry::Solid;
/// let screw = bought("screw-m3x16", "M3 x 16", Solid::cylinder(1.5, 16.0), [in_sensor()]);
/// let all = merged([screw.clone(), screw]);
/// assert_eq!((all.len(), all[0].placements.len()), (1, 2));
/// ```
pub fn merged(bodies: impl IntoIterator<Item = Body>) -> Vec<Body> {
    let mut all: Vec<Body> = Vec::new();
    for body in bodies {
        match all.iter_mut().find(|other| other.name == body.name) {
            None => all.push(body),
            Some(same) => {
                same.quantity += body.quantity;
                same.placements.extend(body.placements);
            }
        }
    }
    all
}

/// Returns an intended overlap of two bodies.
pub fn press_fit(
    inner: impl Into<String>,
    outer: Name,
    interference_mm: f64,
    reason: &str,
) -> PressFit {
    PressFit { inner: inner.into(), outer: outer.into(), interference_mm, reason: reason.into() }
}

/// Returns a sphere in the form that touched surfaces and marker patterns use.
pub fn sphere(radius_mm: f64) -> EllipsoidOffset {
    EllipsoidOffset { equatorial_mm: radius_mm, polar_mm: radius_mm, offset_mm: 0.0 }
}

/// Returns a camera on the axis that looks along +z; its image's right is the sensor's +x.
///
/// ```
/// use fabkit_designs::blocks::camera_at;
/// use fabkit_geometry::{Angle, NominalLens, Point3};
/// let view = Angle::from_deg(90.0).ok_or("not finite")?;
/// let camera = camera_at(-20.0, [640, 480], view, NominalLens::default());
/// // 20 mm in front of the pupil: the origin of the sensor frame.
/// let seen = camera.sensor_from_camera.point(Point3::new(0.0, 0.0, 20.0));
/// assert_eq!(seen, Point3::origin());
/// # Ok::<(), &str>(())
/// ```
pub fn camera_at(
    pupil_z: f64,
    [width_px, height_px]: [u32; 2],
    view: Angle,
    lens: NominalLens,
) -> NominalCamera {
    let sensor_from_camera = Pose::translation(0.0, 0.0, pupil_z);
    NominalCamera { sensor_from_camera, width_px, height_px, field_of_view: view, lens }
}

/// Creates a sensor from bodies, with the names in the header of its file.
pub fn sensor(
    header: &Header,
    camera: NominalCamera,
    bodies: impl IntoIterator<Item = Body>,
) -> Sensor {
    Sensor::new(header.name.as_str(), &header.title, &header.reference, camera, bodies)
}

/// Returns a derived length for `fabkit show`: name, and value with unit.
pub fn mm(name: &str, value: f64) -> (String, String) {
    (name.to_owned(), format!("{value:.3} mm"))
}
