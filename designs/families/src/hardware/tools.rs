//! The room that hands and tools need at fasteners, each in the fastener's own frame, z out of the
//! material.

use fabkit_geometry::{Angle, Occasion, Pose, Reach, Solid};

use super::{Dowel, HeatSetNut, HexNut, Screw, SocketScrew};
use crate::blocks::{INTO_MM, copies, ring};

/// A tool ends this far from what it works on, mm: it touches it, and bodies do not overlap.
const TIP_GAP_MM: f64 = 0.05;

/// A screwdriver for cross recesses: which screws, its name, radius and length of its blade, mm.
///
/// Recess numbers of ISO 7045 and ISO 7046-1 by thread, blades of ISO 8764-2 (long ones; of PH00,
/// which the standard does not have, a maker's).
const DRIVERS: [(f64, &str, f64, f64); 4] = [
    (1.4, "a PH00 screwdriver", 1.5, 60.0),
    (2.2, "a PH0 screwdriver", 1.5, 60.0),
    (3.2, "a PH1 screwdriver", 2.5, 80.0),
    (5.2, "a PH2 screwdriver", 3.0, 100.0),
];

/// Where fingers turn it: radius and length of a handle, mm; chosen, the slimmest that are sold for
/// electronics.
const HANDLE_MM: [f64; 2] = [8.0, 60.0];

/// Outside of a socket (ISO 2725-1, 6.3 mm square, d max) by the nut's width across flats, mm.
const SOCKETS: [(f64, f64); 4] = [(4.0, 6.9), (5.5, 8.8), (7.0, 11.0), (8.0, 12.2)];

/// Length of a socket, mm (ISO 2725-1).
const SOCKET_MM: f64 = 25.0;

/// How far a finger or a rod pushes a nut into its pocket from, mm; chosen.
const PUSH_MM: f64 = 10.0;

/// Length of the tip of a soldering iron that melts a nut in, mm; it is as wide as the nut. Chosen: tips
/// that makers sell for it.
const IRON_TIP_MM: f64 = 15.0;

/// Radius and length of the iron behind its tip, mm; chosen.
const IRON_SHAFT_MM: [f64; 2] = [4.0, 60.0];

/// Hexagon keys: which screws, name, radius over corners, long and short arm, mm. ISO 4762 has sockets of
/// 3, 4 and 5 mm in M4, M5 and M6; ISO 2936 the keys.
const KEYS: [(f64, &str, f64, [f64; 2]); 3] = [
    (4.5, "a hexagon key of 3 mm", 1.7, [63.0, 20.0]),
    (5.5, "a hexagon key of 4 mm", 2.3, [70.0, 25.0]),
    (6.5, "a hexagon key of 5 mm", 2.85, [80.0, 28.0]),
];

/// How far a ball-ended key may lean, degrees: what makers state.
const BALL_DEG: f64 = 25.0;

/// What presses a dowel in, a vise's jaw or a thumb: radius and way, mm; chosen.
const PRESS_MM: [f64; 2] = [4.0, 12.0];

/// How much of a pin's head fingers need to pull it out, how thick they are beside it, and how far they
/// stand out over it, mm; chosen: tips of thumb and index finger.
const PINCH_MM: [f64; 3] = [3.0, 6.0, 25.0];

/// Width of a fingertip that pinches on one side, mm; chosen: on edge, as for small things.
const EDGE_MM: f64 = 8.0;

/// A flat screwdriver for pry slots: thickness and width of its blade, radius and length of its shaft, mm
/// (ISO 2380-1: blade 0.8 x 4, the shaft as wide as the blade; ISO 2380-2: 100 mm).
const PRY_MM: ([f64; 2], [f64; 2]) = ([0.8, 4.0], [2.0, 100.0]);

/// What of the blade is flat and thin in front of a slot, mm; chosen: it is ground over two to three widths.
const PRY_BLADE_MM: f64 = 8.0;

/// A syringe of 5 ml on its Luer tip: radius and length of its barrel; radius and length of the hand that
/// holds it by its flange and pushes; mm. Chosen: 13 to 14 mm are usual outside, a hand's three fingers beside.
const SYRINGE_MM: [[f64; 2]; 2] = [[7.0, 55.0], [20.0, 60.0]];

/// A flat screwdriver in a slot that is so deep, mm: origin in the middle of the slot's mouth, x axis out of it,
/// z axis across its narrow side. It is levered by a turn about its axis, which takes no more room.
pub fn pry(mouth: Pose, depth_mm: f64) -> Reach {
    let ([thickness, width], shaft) = PRY_MM;
    let blade = Solid::cuboid(width, thickness, depth_mm + PRY_BLADE_MM - TIP_GAP_MM);
    let behind = shafted(PRY_BLADE_MM - INTO_MM, shaft, HANDLE_MM);
    let quarter = Angle::from_deg(-90.0).expect("a quarter of a turn is finite");
    let out = Pose::rotation_z(quarter).then_in(Pose::rotation_x(quarter));
    let solid = blade.at_z(TIP_GAP_MM - depth_mm).plus(behind).placed(mouth.then_in(out));
    Reach::room("the screwdriver that pries", solid).on(Occasion::Removal)
}

/// A syringe whose tip stands out of its seat by so much, mm: origin in the seat's mouth, z towards the hand.
pub fn syringe(mouth: Pose, stands_out_mm: f64) -> Reach {
    let [barrel, hand] = SYRINGE_MM;
    let behind = Solid::cylinder(barrel[0], barrel[1])
        .plus(Solid::cylinder(hand[0], hand[1]).at_z(barrel[1] - INTO_MM));
    let solid = behind.at_z(stands_out_mm + TIP_GAP_MM).placed(mouth);
    Reach::room("the syringe", solid).on(Occasion::Pour)
}

/// A rod with a handle behind it, from a height upwards. It ends in a cone with flanks 26.5 degrees
/// from the axis, as the points of ISO 8764-1 do.
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
    /// Its screwdriver.
    pub fn driver(&self) -> Reach {
        let fits = DRIVERS.iter().find(|(thread, ..)| self.thread_mm < *thread);
        let &(_, tool, radius, length) = fits.unwrap_or(&DRIVERS[DRIVERS.len() - 1]);
        let from_z = self.head_height_mm() + TIP_GAP_MM;
        Reach::driver(tool, shafted(from_z, [radius, length], HANDLE_MM))
    }
}

impl SocketScrew {
    /// Its hexagon key by the long arm, upright, or leaning to any side where it ends in a ball.
    pub fn driver(&self) -> Reach {
        let fits = KEYS.iter().find(|(thread, ..)| self.thread_mm < *thread);
        let &(_, tool, radius, [long, short]) = fits.unwrap_or(&KEYS[KEYS.len() - 1]);
        let from_z = self.head_height_mm + TIP_GAP_MM;
        // Over the screw, the other arm goes around.
        let arm = 2.0 * radius;
        let key = Solid::cylinder(radius, long)
            .plus(Solid::cylinder(short, arm).at_z(long - arm))
            .named("key");
        let upright = Reach::driver(tool, key.clone().at_z(from_z));
        let lean = Pose::rotation_y(Angle::from_deg(BALL_DEG).expect("finite"));
        // The edge of a leaning key must clear the head.
        let over = from_z + radius * BALL_DEG.to_radians().sin();
        let sides = ring(4, 0.0, Pose::identity()).into_iter().map(|turn| turn.then_in(lean));
        sides.fold(upright, |reach, side| reach.or(key.clone().placed(side).at_z(over)))
    }
}

impl Dowel {
    /// What presses it in, from either end.
    pub fn press(&self) -> Reach {
        let [radius, way] = PRESS_MM;
        let from_z = self.length_mm / 2.0 + TIP_GAP_MM;
        let jaw = Solid::cylinder(radius, way);
        let below = jaw.clone().at_z(-from_z - way);
        Reach::room("what presses the dowel in", jaw.at_z(from_z)).or(below)
    }
}

/// Fingers that pull a pin out by its head, z along its axis to the hand: radius and top of the head, mm.
/// All around it or, where something stands there, on two sides.
///
/// Where all holes are filled, neighbours are in the way; a picture takes a few pins.
pub fn pinch(radius_mm: f64, top_z: f64) -> Reach {
    let [deep, beside, out] = PINCH_MM;
    let [near, far] = [radius_mm + TIP_GAP_MM, radius_mm + beside];
    let (low, half) = (top_z - deep, EDGE_MM / 2.0);
    let around = tube([near, far], [low, top_z + out]);
    let tip = Solid::cuboid_between([near, -half, low], [far, half, top_z + out]);
    let tips = copies("fingertip", &ring(2, 0.0, Pose::identity()), &tip);
    let sides = Solid::union(tips);
    let turns = ring(8, 0.0, Pose::identity()).into_iter().take(4);
    let anywhere = Reach::room("the fingers that pull it out", around).past_copies();
    turns.fold(anywhere, |reach, turn| reach.or(sides.clone().placed(turn)))
}

/// What is around an axis, between two radii and two heights, mm.
fn tube([inner, outer]: [f64; 2], [low, high]: [f64; 2]) -> Solid {
    let outline = [[inner, low], [outer, low], [outer, high], [inner, high]];
    Solid::revolution(fabkit_geometry::Path::polygon(&outline))
}

impl HexNut {
    /// A socket wrench around it where it lies on a face.
    pub fn socket(&self) -> Reach {
        let fits = SOCKETS.iter().find(|(flats, _)| self.across_flats_mm <= *flats);
        let &(_, diameter) = fits.unwrap_or(&SOCKETS[SOCKETS.len() - 1]);
        let around = Solid::cylinder(diameter / 2.0, SOCKET_MM).at_z(TIP_GAP_MM);
        Reach::driver("a socket wrench", around)
    }

    /// What pushes it into its pocket.
    pub fn pusher(&self) -> Reach {
        let from_z = self.height_mm + TIP_GAP_MM;
        let rod = Solid::cylinder(self.across_flats_mm / 2.0, PUSH_MM).at_z(from_z);
        Reach::driver("what pushes the nut in", rod)
    }
}

impl HeatSetNut {
    /// The iron that melts it in.
    pub fn iron(&self) -> Reach {
        let tip = [self.diameter_mm / 2.0, IRON_TIP_MM];
        Reach::driver("a soldering iron", shafted(TIP_GAP_MM, tip, IRON_SHAFT_MM))
    }
}
