//! Space that hands and tools need at fasteners, each in the fastener's own frame, z out of the material.

use fabkit_geometry::{Angle, Occasion, Pose, Solid, ToolAccess};

use super::{Dowel, HeatSetNut, HexNut, Screw, SocketScrew};
use crate::blocks::{INTO_MM, copies, ring};

/// Gap between a tool and the piece it touches, mm, so that their solids do not overlap.
const TIP_GAP_MM: f64 = 0.05;

/// Screwdrivers for cross recesses: upper bound of the thread, name, radius and length of the blade, mm.
///
/// Recess numbers of ISO 7045 and ISO 7046-1 by thread, blades of ISO 8764-2 (long ones; for PH00, which the standard
/// lacks, those of a maker).
const DRIVERS: [(f64, &str, f64, f64); 4] = [
    (1.4, "a PH00 screwdriver", 1.5, 60.0),
    (2.2, "a PH0 screwdriver", 1.5, 60.0),
    (3.2, "a PH1 screwdriver", 2.5, 80.0),
    (5.2, "a PH2 screwdriver", 3.0, 100.0),
];

/// Radius and length of a screwdriver's handle, mm; chosen, the slimmest that are sold for electronics.
const HANDLE_MM: [f64; 2] = [8.0, 60.0];

/// Outer diameters of sockets (ISO 2725-1, 6.3 mm square, d max) by the nut's width across flats, mm.
const SOCKETS: [(f64, f64); 4] = [(4.0, 6.9), (5.5, 8.8), (7.0, 11.0), (8.0, 12.2)];

/// Length of a socket, mm (ISO 2725-1).
const SOCKET_MM: f64 = 25.0;

/// Length of the straight approach by which a finger or a rod pushes a nut into its pocket, mm; chosen.
const PUSH_MM: f64 = 10.0;

/// Length of the soldering iron's tip that melts in a nut, mm; the tip is as wide as the nut. Chosen: tips that makers
/// sell for it.
const IRON_TIP_MM: f64 = 15.0;

/// Radius and length of the soldering iron behind its tip, mm; chosen.
const IRON_SHAFT_MM: [f64; 2] = [4.0, 60.0];

/// Hexagon keys: upper bound of the thread, name, radius over corners, long and short arm, mm. ISO 4762 has sockets of
/// 3, 4 and 5 mm in M4, M5 and M6; ISO 2936 the keys.
const KEYS: [(f64, &str, f64, [f64; 2]); 3] = [
    (4.5, "a hexagon key of 3 mm", 1.7, [63.0, 20.0]),
    (5.5, "a hexagon key of 4 mm", 2.3, [70.0, 25.0]),
    (6.5, "a hexagon key of 5 mm", 2.85, [80.0, 28.0]),
];

/// Largest tilt of a ball-ended key, degrees, as makers state.
const BALL_DEG: f64 = 25.0;

/// Radius and travel of the vise jaw or thumb that presses a dowel in, mm; chosen.
const PRESS_MM: [f64; 2] = [4.0, 12.0];

/// Length of a pin's head that fingers hold, their thickness beside it, and their reach above it, mm; chosen: tips of
/// thumb and index finger.
const PINCH_MM: [f64; 3] = [3.0, 6.0, 25.0];

/// Width of a fingertip that pinches on one side, mm; chosen: on edge, as for small things.
const EDGE_MM: f64 = 8.0;

/// Flat screwdriver for pry slots: thickness and width of its blade, radius and length of its shaft, mm (ISO 2380-1:
/// blade 0.8 x 4, the shaft as wide as the blade; ISO 2380-2: 100 mm).
const PRY_MM: ([f64; 2], [f64; 2]) = ([0.8, 4.0], [2.0, 100.0]);

/// Length of the flat, thin part of the blade in front of a slot, mm; chosen: blades are ground over two to three
/// widths.
const PRY_BLADE_MM: f64 = 8.0;

/// Syringe of 5 ml on its Luer tip: radius and length of its barrel; radius and length of the hand that holds it by its
/// flange and pushes; mm. Chosen: 13 to 14 mm outer diameter are usual, and a hand's three fingers beside it.
const SYRINGE_MM: [[f64; 2]; 2] = [[7.0, 55.0], [20.0, 60.0]];

/// Returns the space of a flat screwdriver in a pry slot of the given depth, mm: origin in the middle of the slot's
/// mouth, x axis out of it, z axis across its narrow side. The screwdriver is twisted about its own axis, which takes
/// no more room.
pub fn pry(mouth: Pose, depth_mm: f64) -> ToolAccess {
    let ([thickness, width], shaft) = PRY_MM;
    let blade = Solid::cuboid(width, thickness, depth_mm + PRY_BLADE_MM - TIP_GAP_MM);
    let behind = shafted(PRY_BLADE_MM - INTO_MM, shaft, HANDLE_MM);
    let quarter = Angle::from_deg(-90.0).expect("a quarter of a turn is finite");
    let out = Pose::rotation_z(quarter).then_in(Pose::rotation_x(quarter));
    let solid = blade.at_z(TIP_GAP_MM - depth_mm).plus(behind).placed(mouth.then_in(out));
    ToolAccess::new("the screwdriver that pries", solid).with_occasion(Occasion::Removal)
}

/// Returns the space of a syringe whose tip ends `stands_out_mm` outside its seat: origin in the seat's mouth, z
/// towards the hand.
pub fn syringe(mouth: Pose, stands_out_mm: f64) -> ToolAccess {
    let [barrel, hand] = SYRINGE_MM;
    let behind = Solid::cylinder(barrel[0], barrel[1])
        .plus(Solid::cylinder(hand[0], hand[1]).at_z(barrel[1] - INTO_MM));
    let solid = behind.at_z(stands_out_mm + TIP_GAP_MM).placed(mouth);
    ToolAccess::new("the syringe", solid).with_occasion(Occasion::Pour)
}

/// Returns a shaft with a handle behind it, from a height upwards. It ends in a cone with flanks 26.5 degrees from the
/// axis, as the points of ISO 8764-1 do.
fn shafted(from_z: f64, [radius, length]: [f64; 2], [handle, handle_length]: [f64; 2]) -> Solid {
    let outline = [
        [0.0, from_z],
        [radius / 2.0, from_z],
        [radius, from_z + radius],
        [radius, from_z + length],
        [handle, from_z + length],
        [handle, from_z + length + handle_length],
        [0.0, from_z + length + handle_length],
    ];
    Solid::revolution(fabkit_geometry::Path::polygon(&outline))
}

impl Screw {
    /// Returns the space of the screwdriver.
    pub fn driver(&self) -> ToolAccess {
        let fits = DRIVERS.iter().find(|(thread, ..)| self.thread_mm < *thread);
        let &(_, tool, radius, length) = fits.unwrap_or(&DRIVERS[DRIVERS.len() - 1]);
        let from_z = self.head_height_mm() + TIP_GAP_MM;
        ToolAccess::driver(tool, shafted(from_z, [radius, length], HANDLE_MM))
    }
}

impl SocketScrew {
    /// Returns the space of the hexagon key, held by its long arm: upright, or tilted to any of four sides on its ball
    /// end.
    pub fn driver(&self) -> ToolAccess {
        let fits = KEYS.iter().find(|(thread, ..)| self.thread_mm < *thread);
        let &(_, tool, radius, [long, short]) = fits.unwrap_or(&KEYS[KEYS.len() - 1]);
        let from_z = self.head_height_mm + TIP_GAP_MM;
        // The short arm sweeps a full circle above the screw.
        let arm = 2.0 * radius;
        let key = Solid::cylinder(radius, long)
            .plus(Solid::cylinder(short, arm).at_z(long - arm))
            .named("key");
        let upright = ToolAccess::driver(tool, key.clone().at_z(from_z));
        let lean = Pose::rotation_y(Angle::from_deg(BALL_DEG).expect("finite"));
        // The lower edge of a tilted key must clear the head.
        let over = from_z + radius * BALL_DEG.to_radians().sin();
        let sides = ring(4, 0.0, Pose::identity()).into_iter().map(|turn| turn.then_in(lean));
        sides.fold(upright, |reach, side| {
            reach.with_alternative(key.clone().placed(side).at_z(over))
        })
    }
}

impl Dowel {
    /// Returns the space of a vise jaw or thumb that presses the dowel in, from either end.
    ///
    /// ```
    /// use fabkit_designs::Dowel;
    /// use fabkit_geometry::CompiledSolid;
    /// let access = Dowel { diameter_mm: 3.0, length_mm: 10.0 }.press_access();
    /// // The pin reaches to z = 5; the jaw comes from above it or, alternatively, from below.
    /// assert!(CompiledSolid::new(&access.solid)?.bounds().min.z > 5.0);
    /// assert!(CompiledSolid::new(&access.alternatives[0])?.bounds().max.z < -5.0);
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn press_access(&self) -> ToolAccess {
        let [radius, way] = PRESS_MM;
        let from_z = self.length_mm / 2.0 + TIP_GAP_MM;
        let jaw = Solid::cylinder(radius, way);
        let below = jaw.clone().at_z(-from_z - way);
        ToolAccess::new("what presses the dowel in", jaw.at_z(from_z)).with_alternative(below)
    }
}

/// Returns the space of fingers that pull a pin out by its head, z along its axis to the hand: all around the pin or,
/// where something is in the way, on two opposite sides. `radius_mm` and `top_z` are radius and top of the head, mm.
///
/// If all holes hold pins, the neighbours are in the way; but a capture needs only a few pins, so copies are passed
/// through.
pub fn pinch(radius_mm: f64, top_z: f64) -> ToolAccess {
    let [deep, beside, out] = PINCH_MM;
    let [near, far] = [radius_mm + TIP_GAP_MM, radius_mm + beside];
    let (low, half) = (top_z - deep, EDGE_MM / 2.0);
    let around = tube([near, far], [low, top_z + out]);
    let tip = Solid::cuboid_between([near, -half, low], [far, half, top_z + out]);
    let tips = copies("fingertip", &ring(2, 0.0, Pose::identity()), &tip);
    let sides = Solid::union(tips);
    // Half of the eight directions, because two opposite fingertips are symmetric.
    let turns = ring(8, 0.0, Pose::identity()).into_iter().take(4);
    let anywhere = ToolAccess::new("the fingers that pull it out", around).ignoring_copies();
    turns.fold(anywhere, |reach, turn| reach.with_alternative(sides.clone().placed(turn)))
}

/// Returns a tube around z, between two radii and two heights, mm.
fn tube([inner, outer]: [f64; 2], [low, high]: [f64; 2]) -> Solid {
    let outline = [[inner, low], [outer, low], [outer, high], [inner, high]];
    Solid::revolution(fabkit_geometry::Path::polygon(&outline))
}

impl HexNut {
    /// Returns the space of a socket wrench around a nut that lies on a face.
    pub fn socket(&self) -> ToolAccess {
        let fits = SOCKETS.iter().find(|(flats, _)| self.across_flats_mm <= *flats);
        let &(_, diameter) = fits.unwrap_or(&SOCKETS[SOCKETS.len() - 1]);
        let around = Solid::cylinder(diameter / 2.0, SOCKET_MM).at_z(TIP_GAP_MM);
        ToolAccess::driver("a socket wrench", around)
    }

    /// Returns the space of a rod that pushes the nut into its pocket.
    pub fn pusher(&self) -> ToolAccess {
        let from_z = self.height_mm + TIP_GAP_MM;
        let rod = Solid::cylinder(self.across_flats_mm / 2.0, PUSH_MM).at_z(from_z);
        ToolAccess::driver("what pushes the nut in", rod)
    }
}

impl HeatSetNut {
    /// Returns the space of the soldering iron that melts the nut in.
    pub fn iron(&self) -> ToolAccess {
        let tip = [self.diameter_mm / 2.0, IRON_TIP_MM];
        ToolAccess::driver("a soldering iron", shafted(TIP_GAP_MM, tip, IRON_SHAFT_MM))
    }
}
