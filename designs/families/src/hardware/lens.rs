//! Lenses that focus by turning in their thread, and the space that fingers or tweezers need for it.

use fabkit_geometry::{Occasion, Path, Solid, ToolAccess};

/// Gap between fingers or tweezers and the part they hold, mm, so that their solids do not overlap.
const TOUCH_MM: f64 = 0.05;

/// Smallest barrel diameter that fingers turn, mm; chosen: M12 lenses have heads of 14 mm, those of small modules 6.5
/// to 8 mm.
const FINGERS_FROM_MM: f64 = 10.0;

/// Thumb and fingers around a barrel: length of barrel that they hold, their thickness, and their reach to the hand,
/// mm; chosen.
const FINGERS_MM: [f64; 3] = [3.0, 8.0, 35.0];

/// Radius and length of the hand behind the fingers, mm; chosen.
const HAND_MM: [f64; 2] = [25.0, 50.0];

/// Points of tweezers around a barrel: height of rim that they hold, their thickness and length, mm; chosen.
const TWEEZERS_MM: [f64; 3] = [0.5, 2.0, 50.0];

/// Radius and length of the hand that holds tweezers, mm; chosen.
const TWEEZERS_HAND_MM: [f64; 2] = [15.0, 60.0];

/// Finger from the side: width and height of the tip, length of the finger, mm; chosen.
const TIP_MM: [f64; 3] = [11.0, 12.0, 60.0];

/// Lens that turns in its thread, its axis along z, looking up.
///
/// ```
/// use fabkit_designs::hardware::ThreadedLens;
/// let lens = ThreadedLens { barrel_mm: 14.0, front_z: -20.0 };
/// assert_eq!(lens.front_access().tool, "the fingers that turn the lens");
/// // Fingers are too thick for a small lens.
/// let small = ThreadedLens { barrel_mm: 6.5, ..lens };
/// assert_eq!(small.front_access().tool, "the tweezers that turn the lens");
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ThreadedLens {
    /// Diameter of the barrel, mm.
    pub barrel_mm: f64,
    /// Height of the lens's front, mm.
    pub front_z: f64,
}

impl ThreadedLens {
    /// Returns the space for turning the lens from the front: by fingers around its barrel, or by tweezers at the rim
    /// of a small one.
    pub fn front_access(&self) -> ToolAccess {
        let (name, [grip, thick, reach], hand) = if self.barrel_mm >= FINGERS_FROM_MM {
            ("the fingers that turn the lens", FINGERS_MM, HAND_MM)
        } else {
            ("the tweezers that turn the lens", TWEEZERS_MM, TWEEZERS_HAND_MM)
        };
        let inner = self.barrel_mm / 2.0 + TOUCH_MM;
        let outer = inner + thick;
        let [hand, length] = [hand[0].max(outer), hand[1]];
        let [from, palm] = [self.front_z - grip, self.front_z + reach];
        // The hand stays beside the axis, so that the lens sees past it.
        let outline = [
            [inner, from],
            [outer, from],
            [outer, palm],
            [hand, palm],
            [hand, palm + length],
            [inner, palm + length],
        ];
        let solid = Solid::revolution(Path::polygon(&outline));
        ToolAccess::new(name, solid).with_occasion(Occasion::Adjustment)
    }

    /// Returns the space for turning the lens by two fingers from opposite sides, along x or along y, where the front
    /// is not accessible.
    pub fn side_access(&self) -> ToolAccess {
        let [width, height, long] = TIP_MM;
        let near = self.barrel_mm / 2.0 + TOUCH_MM;
        let low = self.front_z - FINGERS_MM[0];
        let finger = |from: [f64; 2], to: [f64; 2]| {
            Solid::cuboid_between([from[0], from[1], low], [to[0], to[1], low + height])
        };
        let [half, far] = [width / 2.0, near + long];
        let along_x = finger([near, -half], [far, half]).plus(finger([-far, -half], [-near, half]));
        let along_y = finger([-half, near], [half, far]).plus(finger([-half, -far], [half, -near]));
        ToolAccess::new("the two fingers that turn the lens", along_x)
            .with_alternative(along_y)
            .with_occasion(Occasion::Adjustment)
    }
}
