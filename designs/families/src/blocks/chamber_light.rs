//! Illumination of a rectangular chamber: LEDs on strips at its walls, or on a board around the lens below.

mod circuit;

use fabkit_geometry::{
    Angle, Body, Length, Order, Path, Pose, Process, Profile, Rgb, Solid, WHITE,
};

use super::lighting::RED_GREEN_BLUE;
use super::posted_camera::{self, PlacedCamera};
use super::{
    APART_MM, LED, LED_YELLOW, MASK_GREEN, PRINTED_WALL_MM, Rect, half_chord, landmarks_at, turn,
    upright,
};
use crate::blocks::circuit::{CHIP_0603, Electric};
use crate::chain_builder::AssemblyName;
use crate::parameters::{Inline, RuleReport, limits};
use crate::{choices, parameters};

choices! {
    /// Position of the LEDs.
    pub enum LedPosition {
        /// LEDs on strips at the chamber's walls, below the plate.
        Sides = "sides",
        /// LEDs on a board around the lens.
        Below = "below",
    }
}

parameters! {
    /// LEDs, on the chamber's walls or on a board around the lens.
    pub struct Leds {
        /// Position of the LEDs: `sides`, on strips at the chamber's walls below the plate, or `below`, on a board
        /// around the lens.
        from: LedPosition,
        /// For `sides`: number of walls with LEDs. For `below`: number of LEDs in each of the two rows.
        count: u32 = 1..=12,
        /// For `sides`: length of strip for each LED. For `below`: length of an LED's package.
        pitch: Length = 1.0..=40.0,
        /// For `sides`: width of the strip. For `below`: width of an LED's package.
        width: Length = 0.5..=12.0,
        /// Thickness of the strip or the board.
        board_thickness: Length = 0.1..=3.2,
        /// Height of an LED's package above the strip or the board.
        package_height: Length = 0.3..=4.0,
        /// For `sides`: distance of the strip's upper edge below the plate.
        below_plate: Length = 0.0..=10.0,
        /// For `below`: width by which the chamber's walls overlap the board that is glued to them.
        step: Length = 0.4..=6.0,
        /// Type of LED to buy.
        model: String = 1..=80,
        /// Electrical data of the LEDs.
        electric: Inline<Electric>,
    }
}

crate::bodies! {
    /// Board that carries the LEDs if they shine from below.
    pub LED_BOARD "led-board" "circuit board around the lens with the LEDs";
}

/// Smallest width of the board under the step that it is glued to, mm.
const LEAST_BEARING_MM: f64 = 0.4;

/// Smallest width of the board beside the lens's holder, mm.
const WEB_MM: f64 = 1.0;

/// Edge of a package as a fraction of its piece of strip.
const PACKAGE_SHARE: f64 = 0.7;

impl Leds {
    /// Returns the excess of the room below over the chamber, mm; 0 for strips.
    pub fn step_mm(&self) -> f64 {
        if self.from == LedPosition::Below { self.step.mm() } else { 0.0 }
    }

    /// Returns the height of a strip with its packages above the wall, mm; 0 for a board.
    pub fn out_mm(&self) -> f64 {
        match self.from {
            LedPosition::Sides => self.board_thickness.mm() + self.package_height.mm(),
            LedPosition::Below => 0.0,
        }
    }
}

/// Chamber with its LEDs; heights in the sensor frame, mm.
#[derive(Clone, Debug)]
pub struct ChamberLight<'a> {
    /// Parameters of the LEDs.
    pub leds: &'a Leds,
    /// Outline of the chamber.
    pub chamber: Rect,
    /// Outline of the room below the chamber.
    pub room: Rect,
    /// Height of the chamber's ceiling.
    pub ceiling_z: f64,
    /// Camera that looks up from below.
    pub camera: PlacedCamera<'a>,
    /// Play of a board in the room, mm.
    pub slide_mm: f64,
}

impl ChamberLight<'_> {
    /// Returns the height at which the chamber widens into the room below it: the top of the LED board.
    pub fn step_z(&self) -> f64 {
        match self.leds.from {
            // The packages end at the height of the pupil, so that the camera does not see their sides.
            LedPosition::Below => self.camera.pupil_z - self.leds.package_height.mm(),
            LedPosition::Sides => self.heads_z(),
        }
    }

    /// Returns the height that the heads of the camera's screws stay below.
    fn heads_z(&self) -> f64 {
        self.camera.top_z + posted_camera::SCREW.head_height_mm() + APART_MM
    }

    /// Returns the height of the strips' upper edge.
    pub fn strip_top_z(&self) -> f64 {
        self.ceiling_z - self.leds.below_plate.mm()
    }

    /// Returns the number of LEDs at a wall (0: +x, 1: +y, 2: -x, 3: -y).
    fn at_wall(&self, wall: usize) -> u32 {
        (self.chamber.straight(wall % 2) / self.leds.pitch.mm()).floor().max(0.0) as u32
    }

    /// Returns the distance of the board's rows of LEDs from the axis, mm.
    fn row_out_mm(&self) -> f64 {
        let half = self.chamber.half[self.chamber.longer()];
        half - self.leds.width.mm() / 2.0 - PRINTED_WALL_MM
    }

    /// Returns the pitch of the LEDs in a row on the board, mm: limited by the straight part of the walls, or by the
    /// round corners, which the outermost packages have to fit into.
    fn row_pitch_mm(&self) -> f64 {
        let (chamber, long) = (self.chamber, self.chamber.longer());
        // Farthest that the outer edge of a package lies beyond the centre of the corner's arc.
        let across = (chamber.corner - PRINTED_WALL_MM).max(0.0);
        let along = half_chord(chamber.corner - APART_MM, across) - self.leds.pitch.mm() / 2.0;
        let straight = chamber.straight(long);
        straight.min(straight + 2.0 * along) / f64::from(self.leds.count.max(2) - 1)
    }

    /// Returns the poses of the LEDs: origin behind the strip or on the board, z axis along the light.
    pub fn poses(&self) -> Vec<Pose> {
        let quarters = |n: f64| Angle::from_deg(90.0 * n).expect("finite");
        let spread = |count: u32, step: f64| {
            let middle = f64::from(count.saturating_sub(1)) / 2.0;
            (0..count).map(move |i| step * (f64::from(i) - middle))
        };
        let (leds, chamber) = (self.leds, self.chamber);
        match leds.from {
            LedPosition::Sides => {
                let inwards =
                    Pose::rotation_z(quarters(-1.0)).then_in(Pose::rotation_x(quarters(1.0)));
                let z = self.strip_top_z() - leds.width.mm() / 2.0;
                let wall = |wall: u32| {
                    let (i, back) = (wall as usize, chamber.half[wall as usize % 2]);
                    spread(self.at_wall(i), leds.pitch.mm()).map(move |along| {
                        let at = Pose::translation(back, along, z).then_in(inwards);
                        Pose::rotation_z(turn(wall, 4, 0.0)).then_in(at)
                    })
                };
                (0..leds.count.min(4)).flat_map(wall).collect()
            }
            LedPosition::Below => {
                // Rows at the ends of the longer axis.
                let (long, out) = (chamber.longer(), self.row_out_mm());
                let turned = Pose::rotation_z(quarters(1.0 - long as f64));
                let row = |out: f64| {
                    spread(leds.count, self.row_pitch_mm()).map(move |along| {
                        let at = if long == 0 { [out, along] } else { [along, out] };
                        upright(at, self.step_z()).then_in(turned)
                    })
                };
                [-out, out].into_iter().flat_map(row).collect()
            }
        }
    }

    /// Returns the colour of each LED in the order of [`ChamberLight::poses`]: strips are red, green, blue, and white on a
    /// fourth wall. A board has a single entry, white.
    pub fn colors(&self) -> Vec<Rgb> {
        match self.leds.from {
            LedPosition::Below => vec![WHITE],
            LedPosition::Sides => {
                let walls =
                    RED_GREEN_BLUE.into_iter().chain([WHITE]).take(self.leds.count as usize);
                let of_wall = |(i, color)| vec![color; self.at_wall(i) as usize];
                walls.enumerate().flat_map(of_wall).collect()
            }
        }
    }

    /// Returns the LEDs, and the board if they are on one.
    pub fn bodies(&self, assembly: AssemblyName) -> Vec<Body> {
        let leds = self.leds;
        let (length, width, height) = (leds.pitch.mm(), leds.width.mm(), leds.package_height.mm());
        let (led, package) = match leds.from {
            LedPosition::Below => {
                let package = Solid::cuboid(length, width, height);
                (package.clone(), package)
            }
            LedPosition::Sides => {
                let (thickness, size) =
                    (leds.board_thickness.mm(), PACKAGE_SHARE * length.min(width));
                let into = thickness / 2.0;
                let package = Solid::cuboid(size, size, height + into).at_z(thickness - into);
                let strip = Solid::cuboid(length, width, thickness);
                (Solid::union([strip, package.clone()]), package)
            }
        };
        let poses = self.poses();
        let drawn = poses.iter().map(|pose| assembly.at_exploded(pose, 2.0).lifted(-22.0));
        let order = match leds.from {
            LedPosition::Below => Order::new(&leds.model, ""),
            LedPosition::Sides => Order::new(&leds.model, "").cut_to(length),
        };
        let led = LED
            .bought(&leds.model, led, drawn)
            .with_order(order)
            .colored(LED_YELLOW)
            .with_light_source(package)
            .as_attached();
        let board = (leds.from == LedPosition::Below).then(|| self.board(assembly));
        [led].into_iter().chain(board).collect()
    }

    /// Returns the board's outline and the radius of its hole, mm.
    fn board_rect(&self) -> (Rect, f64) {
        (self.room.shrunk(self.slide_mm), self.camera.camera.bore_mm())
    }

    /// Returns the LED board.
    fn board(&self, assembly: AssemblyName) -> Body {
        let (rect, bore) = self.board_rect();
        let profile = Profile::new(rect.path()).with_hole(Path::circle([0.0; 2], bore));
        let top = self.step_z();
        let solid = Solid::prism(profile, [top - self.leds.board_thickness.mm(), top]);
        LED_BOARD
            .made(Process::Pcb, solid)
            .with_material("FR4")
            .placed([assembly.in_place().lifted(-22.0)])
            .with_landmarks(landmarks_at("led", &self.poses()))
            .colored(MASK_GREEN)
            .note("push it up against the shell's step and fix it with four drops of glue")
            .with_handles(1)
    }

    /// Reports LEDs that do not fit. The sections must be called `leds` and `camera`; `edges` are the paths of the
    /// parameters that set the chamber's edges along x and y, with their values.
    pub fn check(&self, edges: [(&str, Length); 2], report: &mut RuleReport) {
        match self.leds.from {
            LedPosition::Sides => self.check_strips(report),
            LedPosition::Below => self.check_board(edges, report),
        }
    }

    /// Reports LED strips that do not fit.
    fn check_strips(&self, report: &mut RuleReport) {
        let (leds, chamber, camera) = (self.leds, self.chamber, &*self.camera.camera.board);
        let straight = chamber.straight(0).min(chamber.straight(1));
        limits! { report:
            leds.count <= 4.0, "a chamber has 4 walls";
            leds.pitch <= straight, "a straight wall must take one piece of strip";
            leds.package_height <= chamber.corner - leds.board_thickness.mm(),
                "LEDs of neighbouring walls must not touch in the rounded corner";
            leds.below_plate <= self.ceiling_z - self.step_z() - leds.width.mm(),
                "the strips end above the heads of the camera's screws";
            camera.barrel_diameter <= 2.0 * (chamber.narrow() - leds.out_mm() - APART_MM),
                "the lens stands between the LEDs";
        }
    }

    /// Reports an LED board that does not fit.
    fn check_board(&self, edges: [(&str, Length); 2], report: &mut RuleReport) {
        let (leds, (board, bore)) = (self.leds, self.board_rect());
        let camera = &*self.camera.camera.board;
        leds.electric.check("leds.forward_volts", [1, 2 * leds.count], CHIP_0603, report);
        limits! { report:
            // The parameter is on both sides, so that the message states the value that satisfies the rule.
            camera.lens_height >= camera.lens_height.mm() + leds.board_thickness.mm()
                    + self.heads_z() - self.step_z(),
                "the LEDs' board lies above the heads of the camera's screws";
            leds.pitch <= self.row_pitch_mm() - APART_MM, "the LEDs of a row must not touch";
            leds.step >= self.slide_mm + LEAST_BEARING_MM,
                "the LEDs' board, with its play in the room, is glued to the step all around";
        }
        let long = self.chamber.longer();
        let (short_path, short) = edges[1 - long];
        // The camera's board may widen the room beyond the chamber: the missing width is counted from the chamber.
        let step = leds.step.mm() - self.slide_mm;
        let wider = bore + WEB_MM - (self.chamber.half[1 - long] + step);
        report.at_least(
            short_path,
            short,
            if board.narrow() < bore + WEB_MM { short.mm() + 2.0 * wider } else { short.mm() },
            "the LEDs' board needs a web beside the lens's holder",
        );
        let (long_path, long) = edges[long];
        report.at_least(
            long_path,
            long,
            long.mm() + 2.0 * (bore + leds.width.mm() / 2.0 + APART_MM - self.row_out_mm()),
            "the rows of LEDs lie beside the lens's holder",
        );
    }
}
