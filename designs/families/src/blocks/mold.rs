//! Two-piece block molds: the features that the molds of several families share.
//!
//! A block stands on z = 0 around the z axis and parts at x = 0. Its mouth is at z = 0: in use it is turned over. Half
//! `a` (x < 0) holds the steel dowels, half `b` slides onto them; rubber bands in a groove hold both together, slots at
//! the parting plane take a screwdriver to part them. The family itself cuts the cavity.

use fabkit_geometry::{
    Angle, CUT_OVERLAP_MM, Length, Path, Point3, Pose, Process, Profile, Solid, Vector3,
};

use super::PRINTED_WALL_MM;
use crate::chain_builder::Name;
use crate::fits::Fit;
use crate::parameters;
use crate::parameters::{RuleReport, limits};
use crate::processes::ProcessAssignments;

parameters! {
    /// Two-piece molds for the gel layers.
    pub struct Mold {
        /// Edge of the mold's square block.
        width: Length = 20.0..=200.0,
        /// Height of the mold's block.
        height: Length = 10.0..=200.0,
        /// Minimum thickness of wall and floor around the cavity.
        wall: Length = 1.2..=20.0,
        /// Diameter of the steel dowel pins.
        dowel_diameter: Length = 1.0..=8.0,
        /// Length of the dowel pins.
        dowel_length: Length = 3.0..=40.0,
        /// Distance of the dowels' centres from the block's sides.
        dowel_inset: Length = 1.5..=20.0,
        /// Depth of the groove for rubber bands.
        band_depth: Length = 0.5..=4.0,
        /// Width of the groove for rubber bands.
        band_width: Length = 1.0..=15.0,
        /// Width of the mouth of a pry slot, in which a screwdriver opens the mold.
        pry_length: Length = 3.0..=20.0,
        /// Depth of a pry slot.
        pry_depth: Length = 0.8..=6.0,
        /// Height of a pry slot, both halves together.
        pry_gap: Length = 0.8..=6.0,
        /// Thickness of the mold's lid.
        lid_thickness: Length = 2.0..=15.0,
        /// Number of vents above the gel.
        vents: u32 = 4..=32,
        /// Diameter of a vent.
        vent_diameter: Length = 0.6..=4.0,
        /// Material of the mold.
        material: String = 1..=80,
    }
}

/// Radius of the block's upright edges, mm.
const CORNER_MM: f64 = 3.0;

/// Space beyond a dowel's end, mm.
const SOCKET_SPARE_MM: f64 = 0.5;

/// Half of a mold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// Half at x < 0, which holds the dowels.
    A,
    /// Half at x > 0, which slides onto them.
    B,
}

impl Half {
    /// Returns the sign of the half's x.
    pub fn outwards(self) -> f64 {
        match self {
            Self::A => -1.0,
            Self::B => 1.0,
        }
    }
}

/// Returns a half without a cavity: block, sockets for the dowels of the other half and of a lid, pry slots and band
/// groove.
pub fn half(mold: &Mold, making: &ProcessAssignments, name: Name, which: Half) -> Solid {
    let (w, height) = (mold.width.mm() / 2.0, mold.height.mm());
    // Outline of half A; half B is the same, turned by 180 degrees.
    let outline = Path::from([0.0, w])
        .line([CORNER_MM - w, w])
        .arc([-w, w - CORNER_MM], [CORNER_MM - w, w - CORNER_MM], true)
        .line([-w, CORNER_MM - w])
        .arc([CORNER_MM - w, -w], [CORNER_MM - w, CORNER_MM - w], true)
        .line([0.0, -w])
        .close();
    let turned = if which == Half::A { 0.0 } else { 180.0 };
    let block = Solid::extrusion(outline, height)
        .turned_z(Angle::from_deg(turned).expect("half a turn is finite"));

    let gap_mm = |fit| making.gap_mm(name, Process::Fdm, fit);
    let grip = mold.dowel_length.mm() / 2.0;
    let (fit, depth) = match which {
        Half::A => (Fit::Press, grip),
        Half::B => (Fit::Slide, grip + SOCKET_SPARE_MM),
    };
    let sockets = side_dowel_poses(mold).into_iter().enumerate().map(|(i, pose)| {
        dowel_tool(mold, gap_mm(fit), depth).placed(pose).named(format!("socket {}", i + 1))
    });
    let lid_pose = lid_dowel_poses(mold)[usize::from(which == Half::B)];
    let lid_socket =
        dowel_tool(mold, gap_mm(Fit::Press), grip).placed(lid_pose).named("lid socket");
    let pry = [-1.0, 1.0].map(|side| {
        let (gap, depth) = (mold.pry_gap.mm(), mold.pry_depth.mm());
        // Centred on the block's side, so that half of it cuts.
        Solid::cuboid(gap, 2.0 * depth, mold.pry_length.mm())
            // Between the rubber band and the block's end, beside the upper dowel.
            .at(0.0, side * w, 0.75 * height - mold.pry_length.mm() / 2.0)
            .named(if side < 0.0 { "pry slot 1" } else { "pry slot 2" })
    });
    block
        .minus_all(sockets)
        .minus(lid_socket)
        .minus_all(pry)
        .minus(band_groove(mold).named("band groove"))
}

/// Returns the poses of the dowels across the parting plane x = 0: z axis along +x, origin on the plane.
pub fn side_dowel_poses(mold: &Mold) -> Vec<Pose> {
    let (inset, height) = (mold.dowel_inset.mm(), mold.height.mm());
    let y = mold.width.mm() / 2.0 - inset;
    let places = [[y, inset], [-y, inset], [-y, height - inset], [y, height - inset]];
    places.map(|[y, z]| Pose::z_to(Vector3::x(), Point3::new(0.0, y, z))).to_vec()
}

/// Returns the poses of the dowels between block and lid, one in each half: origin on the block's mouth, z axis up.
pub fn lid_dowel_poses(mold: &Mold) -> Vec<Pose> {
    let x = mold.width.mm() / 2.0 - mold.dowel_inset.mm();
    [-x, x].map(|x| Pose::translation(x, 0.0, 0.0)).to_vec()
}

/// Returns a hole for a dowel along z around the origin, `depth_mm` to both sides.
pub fn dowel_tool(mold: &Mold, gap_mm: f64, depth_mm: f64) -> Solid {
    let radius = mold.dowel_diameter.mm() / 2.0 + gap_mm;
    Solid::cylinder(radius, 2.0 * depth_mm).at_z(-depth_mm)
}

/// Returns a groove around the whole block that keeps rubber bands in place.
fn band_groove(mold: &Mold) -> Solid {
    let (width, band) = (mold.width.mm(), mold.band_width.mm());
    let inner = width - 2.0 * mold.band_depth.mm();
    let outer = width + 2.0;
    let ring = Profile::new(Path::rectangle([0.0; 2], [outer; 2], 0.0))
        .with_hole(Path::rectangle([0.0; 2], [inner; 2], CORNER_MM));
    Solid::extrusion(ring, band).at_z((mold.height.mm() - band) / 2.0)
}

/// Returns a plate that covers the block's mouth, below z = 0.
pub fn plate(mold: &Mold, thickness: f64) -> Solid {
    let outline = Path::rectangle([0.0; 2], [mold.width.mm(); 2], CORNER_MM);
    Solid::extrusion(outline, thickness).at_z(-thickness)
}

/// Returns the pry slots between a plate and the block, at the sides that carry dowels.
pub fn plate_pry_slots(mold: &Mold) -> [Solid; 2] {
    let (depth, gap) = (mold.pry_depth.mm(), mold.pry_gap.mm() / 2.0);
    [-1.0, 1.0].map(|side| {
        Solid::cuboid(2.0 * depth, mold.pry_length.mm(), gap + CUT_OVERLAP_MM)
            .at(side * mold.width.mm() / 2.0, 0.0, -gap)
            .named(if side < 0.0 { "pry slot 1" } else { "pry slot 2" })
    })
}

/// Reports a cavity of `radius_mm` and `depth_mm` that does not fit the block, or features of the block that do not fit
/// each other. The section must be called `mold`; `slide` is the gap of its widest dowel holes, mm.
pub fn check(mold: &Mold, slide: f64, [radius_mm, depth_mm]: [f64; 2], report: &mut RuleReport) {
    let (dowel, inset) = (mold.dowel_diameter.mm() / 2.0, mold.dowel_inset.mm());
    let grip = mold.dowel_length.mm() / 2.0;
    limits! { report:
        mold.height >= depth_mm + mold.wall.mm(), "the block needs a floor below the cavity";
        mold.width >= 2.0 * (radius_mm + mold.wall.mm() + dowel + inset),
            "dowels stand between the cavity's wall and the side";
        mold.dowel_inset >=
            dowel + slide + mold.band_depth.mm() + PRINTED_WALL_MM,
            "a dowel needs a wall between its hole and the band groove";
        mold.dowel_length <= mold.height.mm() - mold.band_width.mm() - 2.0 * PRINTED_WALL_MM,
            "the lid's dowels must end above the band groove";
        mold.pry_depth <= inset - dowel - slide - 0.6,
            "the pry slots must end in front of the dowels";
        mold.pry_length <= mold.height.mm() / 2.0 - mold.band_width.mm(),
            "the pry slots lie between the band groove and the block's end";
        mold.lid_thickness >= grip, "the dowels must not stand out of the lid";
    }
}
