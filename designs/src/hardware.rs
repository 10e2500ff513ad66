//! Bought fasteners and standard pieces, as solids and as the holes they need.
//!
//! A fastener's frame: origin where its head bears (pan) or ends flush (countersunk), z out of the
//! material, so that the shaft goes down -z. A hole's frame is its fastener's.

use fabkit_geometry::{CUT_OVERLAP_MM, Path, Solid};

/// Shape of a screw's head.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Head {
    /// ISO 7045, bears on a plane.
    Pan,
    /// ISO 7046, 90 degrees, ends flush with the surface.
    Countersunk,
}

/// A metric screw. `length_mm` counts as ordered: a countersunk head is part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screw {
    /// Nominal thread diameter, mm.
    pub thread_mm: f64,
    /// Ordered length, mm.
    pub length_mm: f64,
    /// Head.
    pub head: Head,
}

/// Dimensions that depend on the thread alone, mm.
struct Thread {
    nominal: f64,
    pan_head_diameter: f64,
    pan_head_height: f64,
    countersunk_diameter: f64,
    /// ISO 273, medium.
    clearance_hole: f64,
    /// Hole in plastic that the screw cuts its own thread into: about 0.82 of the nominal.
    pilot_hole: f64,
}

const THREADS: [Thread; 4] = [
    // Heads as JCIS 10-70: the ISO standards begin at M1.6.
    Thread {
        nominal: 1.2,
        pan_head_diameter: 2.2,
        pan_head_height: 0.8,
        countersunk_diameter: 2.2,
        clearance_hole: 1.4,
        pilot_hole: 1.0,
    },
    Thread {
        nominal: 1.6,
        pan_head_diameter: 3.2,
        pan_head_height: 1.3,
        countersunk_diameter: 3.0,
        clearance_hole: 1.8,
        pilot_hole: 1.3,
    },
    Thread {
        nominal: 2.0,
        pan_head_diameter: 4.0,
        pan_head_height: 1.6,
        countersunk_diameter: 3.8,
        clearance_hole: 2.4,
        pilot_hole: 1.65,
    },
    Thread {
        nominal: 3.0,
        pan_head_diameter: 5.6,
        pan_head_height: 2.4,
        countersunk_diameter: 5.5,
        clearance_hole: 3.4,
        pilot_hole: 2.5,
    },
];

impl Screw {
    /// M1.2 x 3, countersunk.
    pub const M1_2X3: Self = Self { thread_mm: 1.2, length_mm: 3.0, head: Head::Countersunk };
    /// M1.6 x 5, pan head.
    pub const M1_6X5: Self = Self { thread_mm: 1.6, length_mm: 5.0, head: Head::Pan };
    /// M2 x 4, countersunk.
    pub const M2X4: Self = Self { thread_mm: 2.0, length_mm: 4.0, head: Head::Countersunk };
    /// M3 x 4, pan head.
    pub const M3X4: Self = Self { thread_mm: 3.0, length_mm: 4.0, head: Head::Pan };
    /// M2 x 16, pan head.
    pub const M2X16: Self = Self { thread_mm: 2.0, length_mm: 16.0, head: Head::Pan };
    /// M3 x 16, pan head.
    pub const M3X16: Self = Self { thread_mm: 3.0, length_mm: 16.0, head: Head::Pan };

    /// M2 x 12, pan head.
    pub const M2X12: Self = Self { thread_mm: 2.0, length_mm: 12.0, head: Head::Pan };
    /// M3 x 12, pan head.
    pub const M3X12: Self = Self { thread_mm: 3.0, length_mm: 12.0, head: Head::Pan };

    fn thread(&self) -> &'static Thread {
        // Screws are made from the constants above, whose threads are all in the table.
        THREADS.iter().find(|t| t.nominal == self.thread_mm).unwrap_or(&THREADS[0])
    }

    /// Diameter of a hole that it passes through, mm.
    pub fn clearance_hole_mm(&self) -> f64 {
        self.thread().clearance_hole
    }

    /// Diameter of a hole in plastic that it cuts its thread into, mm.
    pub fn pilot_hole_mm(&self) -> f64 {
        self.thread().pilot_hole
    }

    /// Diameter of the head, mm.
    pub fn head_diameter_mm(&self) -> f64 {
        match self.head {
            Head::Pan => self.thread().pan_head_diameter,
            Head::Countersunk => self.thread().countersunk_diameter,
        }
    }

    /// How far the head stands above the surface it bears on, mm.
    pub fn head_height_mm(&self) -> f64 {
        match self.head {
            Head::Pan => self.thread().pan_head_height,
            Head::Countersunk => 0.0,
        }
    }

    /// How much a thread that is cut into plastic overlaps it, mm per side.
    pub fn thread_overlap_mm(&self) -> f64 {
        (self.thread_mm - self.pilot_hole_mm()) / 2.0
    }

    /// The screw.
    pub fn solid(&self) -> Solid {
        let (shaft, head, length) =
            (self.thread_mm / 2.0, self.head_diameter_mm() / 2.0, self.length_mm);
        let outline = match self.head {
            Head::Pan => {
                let height = self.thread().pan_head_height;
                let top = [[head, 0.0], [head, height], [0.0, height]];
                [vec![[0.0, -length], [shaft, -length], [shaft, 0.0]], top.to_vec()].concat()
            }
            Head::Countersunk => {
                let cone = head - shaft;
                vec![[0.0, -length], [shaft, -length], [shaft, -cone], [head, 0.0], [0.0, 0.0]]
            }
        };
        Solid::revolution(Path::polygon(&outline)).named("screw")
    }

    /// The passage through a plate of `depth_mm` below the origin, open above. A countersunk head
    /// gets a cone `gap_mm` wider than itself, which goes on upwards so that it leaves a curved
    /// face too.
    pub fn clearance_tool(&self, depth_mm: f64, gap_mm: f64) -> Solid {
        let hole = self.clearance_hole_mm() / 2.0;
        let bottom = -depth_mm - CUT_OVERLAP_MM;
        let outline = match self.head {
            Head::Pan => {
                vec![[0.0, bottom], [hole, bottom], [hole, CUT_OVERLAP_MM], [0.0, CUT_OVERLAP_MM]]
            }
            Head::Countersunk => {
                let rim = self.head_diameter_mm() / 2.0 + gap_mm;
                let above = 1.0;
                vec![
                    [0.0, bottom],
                    [hole, bottom],
                    [hole, hole - rim],
                    [rim + above, above],
                    [0.0, above],
                ]
            }
        };
        Solid::revolution(Path::polygon(&outline))
    }

    /// The hole that the screw cuts its thread into, `depth_mm` deep below the origin.
    pub fn pilot_tool(&self, depth_mm: f64) -> Solid {
        Solid::cylinder(self.pilot_hole_mm() / 2.0, depth_mm + CUT_OVERLAP_MM)
            .at(0.0, 0.0, -depth_mm)
    }
}

/// A brass nut that is melted into plastic, M2 x 3 x 3.2: open at z = 0, going down -z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatSetNut {
    /// Thread, mm.
    pub thread_mm: f64,
    /// Outer diameter over the knurl, mm.
    pub diameter_mm: f64,
    /// Length, mm.
    pub length_mm: f64,
    /// Diameter of the hole it is melted into, mm.
    pub hole_mm: f64,
}

impl HeatSetNut {
    /// M2, 3 mm long, 3.2 mm over the knurl, into a 3.0 mm hole.
    pub const M2: Self = Self { thread_mm: 2.0, diameter_mm: 3.2, length_mm: 3.0, hole_mm: 3.0 };

    /// Play of the screw in the modelled bore, mm per side: a thread that neither binds nor shows.
    const BORE_PLAY_MM: f64 = 0.02;

    /// The nut.
    pub fn solid(&self) -> Solid {
        let bore = self.thread_mm / 2.0 + Self::BORE_PLAY_MM;
        Solid::cylinder(self.diameter_mm / 2.0, self.length_mm)
            .at(0.0, 0.0, -self.length_mm)
            .minus(Solid::cylinder(bore, self.length_mm + 2.0 * CUT_OVERLAP_MM).at(
                0.0,
                0.0,
                -self.length_mm - CUT_OVERLAP_MM,
            ))
            .named("nut")
    }

    /// Its hole, `spare_mm` deeper than the nut: room for molten plastic and the screw's tip.
    pub fn tool(&self, spare_mm: f64) -> Solid {
        let depth = self.length_mm + spare_mm;
        Solid::cylinder(self.hole_mm / 2.0, depth + CUT_OVERLAP_MM).at(0.0, 0.0, -depth)
    }

    /// Overlap with its hole before the plastic melts, mm per side.
    pub fn overlap_mm(&self) -> f64 {
        (self.diameter_mm - self.hole_mm) / 2.0
    }
}

/// Play of a screw in a modelled thread, mm per side: it neither binds nor shows.
const THREAD_PLAY_MM: f64 = 0.02;

/// From the axis of a hexagon to a corner, mm.
fn corner_mm(across_flats_mm: f64) -> f64 {
    across_flats_mm / f64::sqrt(3.0)
}

/// A hexagon around z, standing on z = 0, a corner on +x.
fn hexagon(across_flats_mm: f64, height_mm: f64) -> Solid {
    let corner = |i: usize| {
        let angle = (60.0 * i as f64).to_radians();
        [corner_mm(across_flats_mm) * angle.cos(), corner_mm(across_flats_mm) * angle.sin()]
    };
    Solid::extrusion(Path::polygon(&std::array::from_fn::<_, 6, _>(corner)), height_mm)
}

/// A hexagon with a bore for a thread.
fn threaded_hexagon(across_flats_mm: f64, height_mm: f64, thread_mm: f64) -> Solid {
    let bore = Solid::cylinder(thread_mm / 2.0 + THREAD_PLAY_MM, height_mm + 2.0 * CUT_OVERLAP_MM);
    hexagon(across_flats_mm, height_mm).minus(bore.at(0.0, 0.0, -CUT_OVERLAP_MM))
}

/// A hexagon nut, ISO 4032: bears at z = 0, goes up to its height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HexNut {
    /// Thread, mm.
    pub thread_mm: f64,
    /// Across flats, mm.
    pub across_flats_mm: f64,
    /// Height, mm.
    pub height_mm: f64,
}

impl HexNut {
    /// M2.
    pub const M2: Self = Self { thread_mm: 2.0, across_flats_mm: 4.0, height_mm: 1.6 };
    /// M3.
    pub const M3: Self = Self { thread_mm: 3.0, across_flats_mm: 5.5, height_mm: 2.4 };

    /// The nut.
    pub fn solid(&self) -> Solid {
        threaded_hexagon(self.across_flats_mm, self.height_mm, self.thread_mm).named("nut")
    }

    /// Distance of a corner from the axis, mm, for flats `gap_mm` farther out than the nut's.
    pub fn corner_mm(&self, gap_mm: f64) -> f64 {
        corner_mm(self.across_flats_mm + 2.0 * gap_mm)
    }

    /// A pocket that keeps it from turning, from its bearing face up to a surface at `depth_mm`.
    pub fn tool(&self, gap_mm: f64, depth_mm: f64) -> Solid {
        hexagon(self.across_flats_mm + 2.0 * gap_mm, depth_mm + CUT_OVERLAP_MM)
    }
}

/// A hexagonal spacer with a thread at either end: stands on z = 0. Lengths come from the design.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HexSpacer {
    /// Thread, mm.
    pub thread_mm: f64,
    /// Across flats, mm.
    pub across_flats_mm: f64,
    /// Depth of the thread at either end, mm.
    pub thread_depth_mm: f64,
}

impl HexSpacer {
    /// M3, 5.5 mm across flats.
    pub const M3: Self = Self { thread_mm: 3.0, across_flats_mm: 5.5, thread_depth_mm: 10.0 };

    /// From the axis to a corner, mm.
    pub fn corner_radius_mm(&self) -> f64 {
        corner_mm(self.across_flats_mm)
    }

    /// The spacer, bored through.
    pub fn solid(&self, length_mm: f64) -> Solid {
        threaded_hexagon(self.across_flats_mm, length_mm, self.thread_mm).named("spacer")
    }
}
