//! Tools that cast a silicone mold around a tube: a cup for the silicone, and a bridge over it, in whose sleeve the
//! tube hangs by its rim.
//!
//! Both are modelled on the tube's axis with the tip up, like the sensor that the mold casts; they are used with the
//! tip down.

use fabkit_geometry::{Angle, Body, CUT_OVERLAP_MM, Length, Path, Process, Solid};

use super::{ScrewJoint, TOOL_GREY, hanging, holes, ring, turn};
use crate::chain_builder::{Name, flipped};
use crate::hardware::Screw;
use crate::materials::Castable;
use crate::parameters;
use crate::parameters::{RuleReport, limits};

parameters! {
    /// Cup and bridge with which a silicone mold is cast around a glass tube.
    pub struct Form {
        /// Thickness of the silicone beside the tube.
        silicone: Length = 3.0..=40.0,
        /// Thickness of the silicone under the tube's tip.
        silicone_floor: Length = 2.0..=40.0,
        /// Trade name of the mold's silicone.
        silicone_material: Castable,
        /// Length of the glass tube from its rim to its tip.
        tube_length: Length = 20.0..=300.0,
        /// Width by which the tube's rim stands out beyond its outside.
        tube_rim: Length = 0.3..=5.0,
        /// Thickness of the cup's wall.
        cup_wall: Length = 4.0..=20.0,
        /// Thickness of the cup's floor and of the bridge.
        plate: Length = 1.2..=10.0,
        /// Height of the cup above the silicone.
        headroom: Length = 0.5..=20.0,
        /// Number of M3x4 screws that hold the bridge.
        screws: u32 = 2..=8,
    }
}

/// Screw that holds the bridge.
const SCREW: Screw = Screw::M3X4;

/// Depth of a hole beyond its screw's tip, mm.
const PILOT_SPARE_MM: f64 = 0.5;

/// Radius of the hole through which a cured mold is pushed out of its cup, mm.
pub const PUSH_HOLE_RADIUS_MM: f64 = 1.5;

/// Number of windows in the bridge for pouring.
const POUR_WINDOWS: u32 = 3;

/// Half angle of a window, degrees.
const WINDOW_HALF_DEG: f64 = 25.0;

/// Distance of the windows from the sleeve and from the outside of the silicone, mm.
const WINDOW_RIM_MM: f64 = 1.0;

/// Height of the tube's rim, mm.
const TUBE_RIM_MM: f64 = 1.5;

/// Heights and radii around a tube, mm; the face of the silicone is z = 0.
#[derive(Clone, Debug)]
pub struct CupAndBridge<'a> {
    form: &'a Form,
    /// Outer radius of the tube.
    tube_radius: f64,
    /// Height of the tube's tip.
    tip_z: f64,
    /// Outer radius of the silicone, inner radius of the cup.
    pub silicone_radius: f64,
    /// Height of the silicone's top (its floor in use).
    pub silicone_top_z: f64,
    /// Height of the cup's rim.
    cup_rim_z: f64,
    /// Outer radius of the cup.
    cup_radius: f64,
    /// Height of the bridge's side that faces away from the cup.
    bridge_z: f64,
    /// Height at which the tube's rim rests on the bridge's sleeve.
    pub sleeve_z: f64,
    /// Height of the tube's open end.
    pub rim_z: f64,
    /// Play of the tube in the bridge's sleeve, mm.
    slide_mm: f64,
}

impl Form {
    /// Creates cup and bridge around a tube of a radius, with its tip at a height and play in the bridge's sleeve, mm.
    pub fn around(&self, tube_radius: f64, tip_z: f64, slide_mm: f64) -> CupAndBridge<'_> {
        let silicone_radius = tube_radius + self.silicone.mm();
        let rim_z = tip_z - self.tube_length.mm();
        let cup_rim_z = -self.headroom.mm();
        CupAndBridge {
            form: self,
            tube_radius,
            tip_z,
            silicone_radius,
            silicone_top_z: tip_z + self.silicone_floor.mm(),
            cup_rim_z,
            cup_radius: silicone_radius + self.cup_wall.mm(),
            bridge_z: cup_rim_z - self.plate.mm(),
            sleeve_z: rim_z + TUBE_RIM_MM,
            rim_z,
            slide_mm,
        }
    }
}

/// Returns a round vessel around z between two radii, open at its rim; its floor lies between two heights.
///
/// ```
/// use fabkit_designs::blocks::cup_and_bridge::bowl;
/// use fabkit_geometry::{CompiledSolid, Point3};
/// // A cup that opens upwards: floor from -2 to 0, rim at 10.
/// let cup = CompiledSolid::new(&bowl([8.0, 10.0], 10.0, [0.0, -2.0]))?;
/// assert!(
///     !cup.contains(&Point3::new(0.0, 0.0, 1.0)) && cup.contains(&Point3::new(0.0, 0.0, -1.0))
/// );
/// assert!(cup.contains(&Point3::new(9.0, 0.0, 9.0)));
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
pub fn bowl([inner, outer]: [f64; 2], rim_z: f64, [floor_z, end_z]: [f64; 2]) -> Solid {
    let mut outline = [
        [0.0, floor_z],
        [inner, floor_z],
        [inner, rim_z],
        [outer, rim_z],
        [outer, end_z],
        [0.0, end_z],
    ];
    // The outline has to run in the same direction whichever way the vessel opens.
    if rim_z > floor_z {
        outline.reverse();
    }
    Solid::revolution(Path::polygon(&outline))
}

impl<'a> CupAndBridge<'a> {
    /// Returns the same cup around another tube, with that radius and its tip at that height, mm.
    #[must_use]
    pub fn with_tube(&self, tube_radius: f64, tip_z: f64) -> CupAndBridge<'a> {
        let rim_z = tip_z - self.form.tube_length.mm();
        CupAndBridge { tube_radius, tip_z, rim_z, sleeve_z: rim_z + TUBE_RIM_MM, ..self.clone() }
    }

    /// Returns the height of the cup's rim, and its inner and outer radius, mm.
    pub fn rim(&self) -> (f64, [f64; 2]) {
        (self.cup_rim_z, [self.silicone_radius, self.cup_radius])
    }

    /// Returns the screws through the bridge into the cup's wall.
    pub fn joint(&self) -> ScrewJoint {
        let first = hanging([(self.silicone_radius + self.cup_radius) / 2.0, 0.0], self.bridge_z);
        let depth = SCREW.length_mm + PILOT_SPARE_MM;
        ScrewJoint::self_tapping("screw", SCREW, ring(self.form.screws, 0.0, first), depth)
    }

    /// Returns a printed tool, upside down on the bed.
    fn tool(name: Name, solid: Solid, note: &str) -> Body {
        name.made(Process::Fdm, solid).colored(TOOL_GREY).with_bed_orientation(flipped()).note(note)
    }

    /// Returns the cup.
    pub fn cup(&self, name: Name) -> Body {
        let (floor_z, plate) = (self.silicone_top_z, self.form.plate.mm());
        let radii = [self.silicone_radius, self.cup_radius];
        let push_hole = Solid::cylinder(PUSH_HOLE_RADIUS_MM, plate + 2.0 * CUT_OVERLAP_MM)
            .at_z(floor_z - CUT_OVERLAP_MM);
        let note = "tape the hole in the floor before pouring; push the cured mold out through it";
        Self::tool(name, bowl(radii, self.cup_rim_z, [floor_z, floor_z + plate]), note)
            .cut(holes([push_hole.named("push hole")]).with_handles(1))
            .cut(self.joint().thread_cut().without_landmarks())
    }

    /// Returns the bridge.
    pub fn bridge(&self, name: Name) -> Body {
        let plate = self.form.plate.mm();
        let bore = self.tube_radius + self.slide_mm;
        let sleeve = bore + plate;
        let outline = Path::polygon(&[
            [bore, self.cup_rim_z],
            [self.cup_radius, self.cup_rim_z],
            [self.cup_radius, self.bridge_z],
            [sleeve, self.bridge_z],
            [sleeve, self.sleeve_z],
            [bore, self.sleeve_z],
        ]);
        let [from, to] = [-WINDOW_HALF_DEG, WINDOW_HALF_DEG]
            .map(|degrees| Angle::from_deg(degrees).expect("finite"));
        let (inner, outer) = (sleeve + WINDOW_RIM_MM, self.silicone_radius - WINDOW_RIM_MM);
        let sector = Path::ring_sector(inner, outer, from, to);
        let window = Solid::extrusion(sector, plate + 2.0 * CUT_OVERLAP_MM)
            .at_z(self.bridge_z - CUT_OVERLAP_MM);
        let windows = (0..POUR_WINDOWS).map(|i| {
            let turned = window.clone().turned_z(turn(i, POUR_WINDOWS, 0.5));
            turned.named(format!("pour window {}", i + 1))
        });
        Self::tool(name, Solid::revolution(outline), "sleeve up, no supports")
            .with_supports(false)
            .with_handles(1)
            .cut(holes(windows).with_handles(POUR_WINDOWS as i32))
            .cut(self.joint().clearance_cut(plate, 0.0).without_landmarks()) // The pan head rests on the bridge.
    }

    /// Reports values with which the tools cannot be assembled or poured. The section must be called `form`.
    pub fn check(&self, report: &mut RuleReport) {
        let (form, slide) = (self.form, self.slide_mm);
        let lead = form.headroom.mm() + form.plate.mm();
        limits! { report:
            form.tube_length >= self.tip_z + lead + 4.0,
                "the glass tube must reach from the mold's tip through the bridge";
            // The parameter is on both sides, so that the message states the value that satisfies the rule.
            form.silicone >= form.silicone.mm() + self.tube_radius + slide + form.plate.mm() + 4.0
                - self.silicone_radius,
                "silicone is poured through windows between the tube's sleeve and the cup";
            form.cup_wall >= SCREW.head_diameter_mm(),
                "the heads of the bridge's M3 screws rest on the wall";
            form.plate <= SCREW.length_mm - 1.5, "an M3x4 must bite 1.5 mm into the cup";
            form.tube_rim >= slide + 0.3, "the tube hangs by its rim";
        }
    }
}
