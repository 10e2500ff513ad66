//! Where things are: every edge and height that more than one body needs, derived once.

use fabkit_geometry::{Path, Process, Solid};

use super::joints::CASING_SCREW;
use super::parameters::{FlatGel, LightFrom};
use crate::blocks::PRINTED_WALL_MM;
use crate::fits::{Fit, gap_mm};

/// Refractive index of acrylic; gel has less, so that this underestimates what is seen.
const PLATE_INDEX: f64 = 1.49;

/// Step that the LEDs' board is glued to from below, mm.
const STEP_MM: f64 = 0.8;

/// An upright prism around the axis: half its edges and the radius of its upright edges, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Half the edges along x and y.
    pub half: [f64; 2],
    /// Radius of the upright edges.
    pub corner: f64,
}

impl Block {
    /// Seen along z.
    pub fn path(self) -> Path {
        Path::rectangle([0.0; 2], self.half.map(|half| 2.0 * half), self.corner)
    }

    /// Between two heights.
    pub fn prism(self, heights: [f64; 2]) -> Solid {
        Solid::prism(self.path(), heights)
    }

    /// Smaller on all sides; corners stay parallel while they can.
    pub fn shrunk(self, by_mm: f64) -> Self {
        Self { half: self.half.map(|h| h - by_mm), corner: (self.corner - by_mm).max(0.5) }
    }

    /// Whether a point, as far from the axes, lies inside by `wall_mm`.
    pub fn holds(self, [x, y]: [f64; 2], wall_mm: f64) -> bool {
        let [w, h] = self.shrunk_sharply(wall_mm);
        let corner = (self.corner - wall_mm).max(0.0);
        let beyond = [x - (w - corner), y - (h - corner)].map(|d| d.max(0.0));
        x <= w + 1e-9 && y <= h + 1e-9 && beyond[0].hypot(beyond[1]) <= corner + 1e-9
    }

    fn shrunk_sharply(self, by_mm: f64) -> [f64; 2] {
        self.half.map(|h| h - by_mm)
    }
}

/// Edges and heights in the sensor frame, mm. z = 0 is the pad's foot, the upper rim of the shell.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// The pad with its coat.
    pub pad: Block,
    /// The pad's gel.
    pub gel: Block,
    /// The opening that plate and bed lie in.
    pub opening: Block,
    /// The plate.
    pub plate: Block,
    /// The room below the plate's ledge.
    pub chamber: Block,
    /// The room around the camera, wide enough for its board.
    pub lower: Block,
    /// Outside of shell and base.
    pub outside: Block,
    /// The pad's top.
    pub top_z: f64,
    /// The gel under the coat: what the camera sees.
    pub seen_z: f64,
    /// Top of the plate.
    pub plate_top_z: f64,
    /// Bottom of the plate.
    pub plate_bottom_z: f64,
    /// Middle of the strips of LEDs at the walls.
    pub strip_z: f64,
    /// Where the chamber becomes the camera's room; top of the LEDs' board.
    pub step_z: f64,
    /// The camera's optical centre.
    pub pupil_z: f64,
    /// Front of the lens.
    pub lens_front_z: f64,
    /// Top of the camera's board.
    pub board_top_z: f64,
    /// Bottom of the camera's board.
    pub board_bottom_z: f64,
    /// Bottom of the shell, top of the base's floor.
    pub joint_z: f64,
    /// Bottom of everything.
    pub bottom_z: f64,
    /// Where the shell's screws are, from the axes.
    pub screw: [f64; 2],
}

impl Layout {
    /// Derives the layout; meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &FlatGel) -> Self {
        let slide = gap_mm(Process::Fdm, Fit::Slide);
        let edges = [p.pad.length.mm(), p.pad.width.mm()];
        let pad = Block { half: edges.map(|edge| edge / 2.0), corner: p.pad.corner.mm() };
        let side = p.coat.side.mm();
        let gel = Block { corner: p.pad.corner.mm() - side, ..pad.shrunk(side) };
        let opening = pad.shrunk(p.plate.overlap.mm());
        let narrow = opening.half.map(|half| half - p.plate.ledge.mm());

        let step = if p.leds.from == LightFrom::Below { STEP_MM } else { 0.0 };
        let board = p.camera.board_size.mm() / 2.0 + slide;
        let wide = narrow.map(|half| (half + step).max(board));
        let out = [0, 1].map(|i| (pad.half[i] + p.shell.rim.mm()).max(wide[i] + p.shell.wall.mm()));
        let head = CASING_SCREW.head_diameter_mm() / 2.0 + gap_mm(Process::Fdm, Fit::Snug);
        let screw = out.map(|half| half - head - PRINTED_WALL_MM);
        let pilot = CASING_SCREW.pilot_hole_mm() / 2.0 + PRINTED_WALL_MM;
        let corner = corner_inside_mm([screw[0] - wide[0], screw[1] - wide[1]], pilot);

        let (top_z, plate_top_z) = (p.pad.thickness.mm(), -p.bed.thickness.mm());
        let seen_z = top_z - p.coat.thickness.mm();
        let plate_bottom_z = plate_top_z - p.plate.thickness.mm();
        // An equidistant lens: a pixel in the middle stands for so many radians.
        let camera = &p.camera;
        let diagonal_px = f64::from(camera.width_px).hypot(f64::from(camera.height_px));
        let distance = camera.pixel_pitch.mm() * diagonal_px / camera.field_of_view.rad();
        let pupil_z = seen_z - distance;
        let lens_front_z = pupil_z + camera.pupil_behind_front.mm();
        let board_top_z = lens_front_z - camera.lens_height.mm();
        let board_bottom_z = board_top_z - camera.board_thickness.mm();
        let joint_z = board_bottom_z - camera.back_clearance.mm();
        let step_z = match p.leds.from {
            // The packages end where the camera begins to see.
            LightFrom::Below => pupil_z - p.leds.package_height.mm(),
            LightFrom::Sides => board_top_z + super::joints::CAMERA_SCREW.head_height_mm() + slide,
        };
        Self {
            pad,
            gel,
            opening,
            plate: opening.shrunk(slide),
            chamber: Block { half: narrow, corner },
            lower: Block { half: wide, corner },
            outside: Block { half: out, corner: p.shell.corner.mm() },
            top_z,
            seen_z,
            plate_top_z,
            plate_bottom_z,
            strip_z: plate_bottom_z - p.leds.below_plate.mm() - p.leds.width.mm() / 2.0,
            step_z,
            pupil_z,
            lens_front_z,
            board_top_z,
            board_bottom_z,
            joint_z,
            bottom_z: joint_z - p.base.thickness.mm(),
            screw,
        }
    }

    /// Which axis the camera's room is longer along.
    pub fn longer(&self) -> usize {
        usize::from(self.lower.half[1] > self.lower.half[0])
    }

    /// How far from the middle the camera sees the gel under the coat, along x and y, mm: up to its
    /// picture's edge, the plate's ledge or the LEDs, through plate and gel.
    pub fn seen_mm(&self, p: &FlatGel) -> [f64; 2] {
        let size = [f64::from(p.camera.width_px), f64::from(p.camera.height_px)];
        let rad_per_px = p.camera.field_of_view.rad() / size[0].hypot(size[1]);
        let air = self.plate_bottom_z - self.pupil_z;
        [0, 1].map(|i| {
            let picture = (size[i] / 2.0 * rad_per_px).min(1.5).tan();
            let mut slope = picture.min(self.chamber.half[i] / air);
            if p.leds.from == LightFrom::Sides {
                let front =
                    self.chamber.half[i] - p.leds.board_thickness.mm() - p.leds.package_height.mm();
                slope = slope.min(front / (self.strip_z + p.leds.width.mm() / 2.0 - self.pupil_z));
            }
            let inside = self.seen_z - self.plate_bottom_z;
            let n2 = PLATE_INDEX.powi(2);
            air * slope + inside * slope / (n2 + (n2 - 1.0) * slope.powi(2)).sqrt()
        })
    }
}

/// The smallest radius of an inner corner that leaves `wall_mm` to a point that stands `beyond` both
/// of its sides: (r + x)^2 + (r + y)^2 = (r + wall)^2.
fn corner_inside_mm([x, y]: [f64; 2], wall_mm: f64) -> f64 {
    let half_b = x + y - wall_mm;
    let c = x * x + y * y - wall_mm * wall_mm;
    (-half_b + (half_b * half_b - c).max(0.0).sqrt()).max(1.0)
}
