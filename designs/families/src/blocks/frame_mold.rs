//! Open molds for flat layers: frames on a floor, filled to the brim and scraped level.
//!
//! The upper face of the floor is z = 0, around the z axis. Steel dowels stand in it; each frame slides onto them, is
//! as high as the layer that is cast in it, and lifts off first. Slots at the seam take a screwdriver.

use fabkit_geometry::{
    Angle, Body, CUT_OVERLAP_MM, Length, Path, Pose, PressFit, Process, Profile, Solid,
};

use super::{DOWEL, MOLD_BLUE, PRINTED_WALL_MM, TOOL_GREY, copies, holes, press_fit, upright};
use crate::chain_builder::{AssemblyName, Name};
use crate::hardware::Dowel;
use crate::hardware::tools::pry;
use crate::parameters;
use crate::parameters::{RuleReport, limits};

parameters! {
    /// Open molds: frames that slide onto dowels in a floor.
    pub struct FrameMold {
        /// Minimum thickness of the wall around cavity and dowels.
        wall: Length = 1.2..=20.0,
        /// Thickness of the mold's floor.
        floor: Length = 2.0..=40.0,
        /// Diameter of the two steel dowel pins.
        dowel_diameter: Length = 1.0..=8.0,
        /// Length of the dowel pins.
        dowel_length: Length = 4.0..=40.0,
        /// Width of a pry slot, in which a screwdriver lifts the frame.
        pry_width: Length = 3.0..=20.0,
        /// Depth of a pry slot.
        pry_depth: Length = 0.8..=6.0,
        /// Height of a pry slot.
        pry_gap: Length = 0.5..=4.0,
        /// Material of the molds.
        material: String = 1..=80,
    }
}

crate::bodies! {
    /// Floor that all frames stand on.
    pub FLOOR "mold-floor" "what is cast stands on it; holds the dowels";
}

/// Distance of a dowel's end below the brim of the lowest frame, mm: a scraper passes above it.
const BELOW_BRIM_MM: f64 = 0.5;

/// Smallest engagement of a dowel in a frame, mm.
const LEAST_HOLD_MM: f64 = 1.0;

/// Radius of the upright edges, mm.
const CORNER_MM: f64 = 4.0;

/// Floor with its dowels, and the dimensions that its frames share.
#[derive(Clone, Debug)]
pub struct Frames<'a> {
    /// Parameters of the mold.
    pub mold: &'a FrameMold,
    /// Half the edges of the widest cavity, mm.
    pub cavity: [f64; 2],
    /// Height of the lowest frame, mm.
    pub lowest_mm: f64,
    /// Linear shrinkage of the cast layers, as a fraction.
    pub shrinkage: f64,
    /// Gap around a dowel in the floor, mm; negative for a press fit.
    pub press_mm: f64,
    /// Gap around a dowel in every frame, mm.
    pub slide_mm: f64,
}

impl Frames<'_> {
    /// Returns the width of the frame from the widest cavity to the outside, mm.
    fn rim_mm(&self) -> f64 {
        let dowel = self.mold.dowel_diameter.mm() / 2.0 + self.slide_mm;
        // A wall on either side of the dowel's hole.
        2.0 * (self.mold.wall.mm() + dowel)
    }

    /// Returns the outline of the floor and of all frames.
    fn outline(&self) -> Path {
        let edges = self.cavity.map(|half| 2.0 * (half + self.rim_mm()));
        Path::rectangle([0.0; 2], edges, CORNER_MM)
    }

    /// Returns the depth of a dowel's socket in the floor, mm.
    fn socket_mm(&self) -> f64 {
        self.mold.dowel_length.mm() - (self.lowest_mm - BELOW_BRIM_MM)
    }

    /// Returns the poses at which the dowels leave the floor.
    fn dowel_poses(&self) -> [Pose; 2] {
        let x = self.cavity[0] + self.rim_mm() / 2.0;
        [-x, x].map(|x| upright([x, 0.0], 0.0))
    }

    /// Returns a hole for a dowel between two heights.
    fn hole(&self, gap_mm: f64, heights: [f64; 2]) -> Solid {
        Solid::rod(self.mold.dowel_diameter.mm() / 2.0 + gap_mm, heights)
    }

    /// Returns a printed piece of the mold with its notes.
    fn tool(&self, name: Name, solid: Solid) -> Body {
        name.made(Process::Sla, solid)
            .with_material(&self.mold.material)
            .colored(TOOL_GREY)
            .sealed("varnish")
            .for_shrinkage(self.shrinkage)
            .note("wash, cure and bake: uncured resin keeps platinum silicone from curing")
    }

    /// Returns the floor, placed in each of the assemblies.
    pub fn floor(&self, assemblies: &[AssemblyName]) -> Body {
        let (mold, over) = (self.mold, CUT_OVERLAP_MM);
        let plate = Solid::prism(self.outline(), [-mold.floor.mm(), 0.0]);
        let socket = self.hole(self.press_mm, [-self.socket_mm(), over]);
        let y = self.cavity[1] + self.rim_mm();
        let slot =
            // Centred on the floor's edge, so that half of it cuts.
            Solid::cuboid(mold.pry_width.mm(), 2.0 * mold.pry_depth.mm(), mold.pry_gap.mm() + over);
        let slots = [-y, y].map(|y| upright([0.0, y], -mold.pry_gap.mm()));
        let deg = |side: f64| Angle::from_deg(90.0 * side).expect("a quarter of a turn is finite");
        let pried = [-1.0, 1.0].map(|side| {
            let mouth = Pose::translation(0.0, side * y, -mold.pry_gap.mm() / 2.0);
            pry(mouth.then_in(Pose::rotation_z(deg(side))), mold.pry_depth.mm())
        });
        let floor = self.tool(FLOOR, plate);
        pried
            .into_iter()
            .fold(floor, Body::with_tool_access)
            .placed(assemblies.iter().map(|name| name.in_place().lifted(-12.0)))
            .note("face up; polish it, the foot of the gel is seen through")
            .cut(holes(copies("socket", &self.dowel_poses(), &socket)))
            .cut(holes(copies("pry slot", &slots, &slot)))
    }

    /// Returns a frame around a cavity, from the floor up to `height_mm`.
    pub fn frame(
        &self,
        name: Name,
        cavity: impl Into<Path>,
        height_mm: f64,
        assembly: AssemblyName,
    ) -> Body {
        let profile = Profile::new(self.outline()).with_hole(cavity.into());
        let over = CUT_OVERLAP_MM;
        let hole = self.hole(self.slide_mm, [-over, height_mm + over]);
        self.tool(name, Solid::prism(profile, [0.0, height_mm]))
            .placed([assembly.in_place().lifted(14.0)])
            .colored(MOLD_BLUE)
            .with_handles(3)
            .cut(holes(copies("dowel hole", &self.dowel_poses(), &hole)))
    }

    /// Returns the dowels, placed in each of the assemblies; a lab needs one pair.
    pub fn dowels(&self, assemblies: &[AssemblyName]) -> Body {
        let mold = self.mold;
        let dowel =
            Dowel { diameter_mm: mold.dowel_diameter.mm(), length_mm: mold.dowel_length.mm() };
        let poses = self.dowel_poses();
        let middle = Pose::translation(0.0, 0.0, dowel.length_mm / 2.0 - self.socket_mm());
        let places = assemblies.iter().flat_map(|name| {
            poses.iter().map(move |pose| name.at(pose.then_in(middle)).lifted(30.0))
        });
        DOWEL
            .bought(dowel.specification(), dowel.solid(), places)
            // The same pair serves all assemblies.
            .with_quantity(poses.len() as u32)
            .with_order(dowel.order())
            .with_tool_access(dowel.press_access())
            .as_fastener()
    }

    /// Returns the press fit that holds the dowels.
    pub fn press_fit(&self) -> PressFit {
        press_fit(DOWEL, FLOOR, -self.press_mm, "the dowels stay in the floor")
    }

    /// Reports values with which floor, dowels and slots do not fit each other. The section must be called `mold`;
    /// `thickness` is the path of the parameter that sets the lowest frame's height.
    pub fn check(&self, thickness: &str, report: &mut RuleReport) {
        let mold = self.mold;
        limits! { report:
            mold.floor >= self.socket_mm() + PRINTED_WALL_MM,
                "the dowels end below the lowest frame's brim, and need a socket with a bottom";
        }
        let held = self.lowest_mm - BELOW_BRIM_MM;
        report.require(
            held >= LEAST_HOLD_MM,
            thickness,
            || {
                format!(
                    "{thickness} leaves a frame of {:.2} mm, which dowels cannot hold",
                    self.lowest_mm
                )
            },
            || format!("make it at least {} mm", LEAST_HOLD_MM + BELOW_BRIM_MM),
        );
        limits! { report:
            mold.dowel_length >= held + LEAST_HOLD_MM, "a dowel needs a socket in the floor";
            mold.pry_depth <= self.rim_mm() - mold.wall.mm(),
                "the pry slots must end in front of the cavity";
            mold.pry_gap <= mold.floor.mm() - PRINTED_WALL_MM,
                "the pry slots are cut into the floor";
            mold.pry_width <= 2.0 * self.cavity[0], "the pry slots lie between the dowels";
        }
    }
}
