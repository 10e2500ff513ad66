//! Fasteners and standard pieces, as solids and as the holes they need.
//!
//! Heads and nuts are modelled at the largest size that their standard allows, because a part has to accept every piece
//! on the market; `designs/families/tests/families/hardware.rs` compares all of them with the standards' tables.
//! Threads are cylinders of their nominal diameter.
//!
//! Frame of a fastener: the origin lies where its head bears (pan) or ends flush (countersunk), z points out of the
//! material, so that the shaft extends along -z. A hole has the frame of its fastener.

mod dowel;
mod lens;
mod nuts;
mod o_ring;
pub mod tools;

use fabkit_geometry::{CUT_OVERLAP_MM, Order, Path, Solid};

pub use dowel::Dowel;
pub use lens::ThreadedLens;
pub use nuts::{HeatSetNut, HexNut, HexSpacer};
pub use o_ring::{ORing, SQUEEZED_PLAY_MM, stocked_cords};

/// Shape of a screw's head.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Head {
    /// Pan head, ISO 7045, which bears on a plane.
    Pan,
    /// Countersunk head, ISO 7046-1, with the 90 degree cone of ISO 7721; ends flush with the surface.
    Countersunk,
}

/// Metric screw. `length_mm` is the ordered length, which includes a countersunk head.
///
/// ```
/// use fabkit_designs::Screw;
/// let screw = Screw::M1_6X5;
/// assert_eq!(screw.name(), "screw-m1-6x5");
/// assert_eq!(screw.order_text(), "pan head screw ISO 7045 M1.6x5");
/// assert_eq!(screw.order().tools, ["screwdriver PH0"]);
/// assert!(screw.pilot_hole_mm() < screw.thread_mm && screw.thread_mm < screw.clearance_hole_mm());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screw {
    /// Nominal thread diameter, mm.
    pub thread_mm: f64,
    /// Ordered length, mm.
    pub length_mm: f64,
    /// Shape of the head.
    pub head: Head,
}

/// Dimensions that depend on the thread alone, mm.
struct Thread {
    nominal: f64,
    pan_head_diameter: f64,
    pan_head_height: f64,
    countersunk: Countersunk,
    /// Diameter of the clearance hole, ISO 273, medium.
    clearance_hole: f64,
    /// Diameter of the hole in plastic that the screw cuts its own thread into: about 0.82 of the nominal.
    pilot_hole: f64,
}

/// Dimensions of a countersunk head, mm. Its cone would end in a sharp edge, but a short cylinder cuts it off, so that
/// the rim is narrower than the countersink around it.
struct Countersunk {
    standard: &'static str,
    /// Diameter of the rim.
    diameter: f64,
    /// Diameter at which the cone would meet the head's flat face ("theoretical" in the standard).
    sharp_diameter: f64,
    /// Diameter of the smallest countersink, at the surface.
    sink_diameter: f64,
}

/// Table of threads: ISO 7045 (dk max, k max), ISO 7046-1 (dk max, theoretical dk max), ISO 15065 (Dc min).
const THREADS: [Thread; 7] = [
    // The ISO standards begin at M1.6. Pan: JCIS 10-70, type 3 (D, H max). Countersunk: DIN 963 (dk, and k = 0.72 mm
    // gives the sharp diameter); there is no standard countersink, so it fits the largest head.
    Thread {
        nominal: 1.2,
        pan_head_diameter: 2.05,
        pan_head_height: 0.75,
        countersunk: Countersunk {
            standard: "DIN 963",
            diameter: 2.3,
            sharp_diameter: 2.64,
            sink_diameter: 2.64,
        },
        clearance_hole: 1.4,
        pilot_hole: 1.0,
    },
    Thread {
        nominal: 1.6,
        pan_head_diameter: 3.2,
        pan_head_height: 1.3,
        countersunk: Countersunk {
            standard: "ISO 7046",
            diameter: 3.0,
            sharp_diameter: 3.6,
            sink_diameter: 3.6,
        },
        clearance_hole: 1.8,
        pilot_hole: 1.3,
    },
    Thread {
        nominal: 2.0,
        pan_head_diameter: 4.0,
        pan_head_height: 1.6,
        countersunk: Countersunk {
            standard: "ISO 7046",
            diameter: 3.8,
            sharp_diameter: 4.4,
            sink_diameter: 4.4,
        },
        clearance_hole: 2.4,
        pilot_hole: 1.65,
    },
    Thread {
        nominal: 2.5,
        pan_head_diameter: 5.0,
        pan_head_height: 2.1,
        countersunk: Countersunk {
            standard: "ISO 7046",
            diameter: 4.7,
            sharp_diameter: 5.5,
            sink_diameter: 5.5,
        },
        clearance_hole: 2.9,
        pilot_hole: 2.05,
    },
    Thread {
        nominal: 3.0,
        pan_head_diameter: 5.6,
        pan_head_height: 2.4,
        countersunk: Countersunk {
            standard: "ISO 7046",
            diameter: 5.5,
            sharp_diameter: 6.3,
            sink_diameter: 6.3,
        },
        clearance_hole: 3.4,
        pilot_hole: 2.5,
    },
    Thread {
        nominal: 4.0,
        pan_head_diameter: 8.0,
        pan_head_height: 3.1,
        countersunk: Countersunk {
            standard: "ISO 7046",
            diameter: 8.4,
            sharp_diameter: 9.4,
            sink_diameter: 9.4,
        },
        clearance_hole: 4.5,
        pilot_hole: 3.3,
    },
    Thread {
        nominal: 5.0,
        pan_head_diameter: 9.5,
        pan_head_height: 3.7,
        countersunk: Countersunk {
            standard: "ISO 7046",
            diameter: 9.3,
            sharp_diameter: 10.4,
            sink_diameter: 10.4,
        },
        clearance_hole: 5.5,
        pilot_hole: 4.2,
    },
];

impl Screw {
    /// M1.2 x 3, countersunk, DIN 963.
    pub const M1_2X3: Self = Self { thread_mm: 1.2, length_mm: 3.0, head: Head::Countersunk };
    /// M1.6 x 5, pan head.
    pub const M1_6X5: Self = Self { thread_mm: 1.6, length_mm: 5.0, head: Head::Pan };
    /// M1.6 x 6, pan head.
    pub const M1_6X6: Self = Self { thread_mm: 1.6, length_mm: 6.0, head: Head::Pan };
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

    /// Returns the table row of the thread.
    fn thread(&self) -> &'static Thread {
        // Screws are made from the constants above, whose threads are all in the table; the fallback is never used.
        THREADS.iter().find(|t| t.nominal == self.thread_mm).unwrap_or(&THREADS[0])
    }

    /// Returns the diameter of the clearance hole, mm.
    pub fn clearance_hole_mm(&self) -> f64 {
        self.thread().clearance_hole
    }

    /// Returns the diameter of a hole in plastic that the screw cuts its thread into, mm.
    pub fn pilot_hole_mm(&self) -> f64 {
        self.thread().pilot_hole
    }

    /// Returns the diameter of the head, mm.
    pub fn head_diameter_mm(&self) -> f64 {
        match self.head {
            Head::Pan => self.thread().pan_head_diameter,
            Head::Countersunk => self.thread().countersunk.diameter,
        }
    }

    /// Returns the standard that the screw is ordered by.
    pub fn standard(&self) -> &'static str {
        match self.head {
            Head::Pan if self.thread_mm < 1.6 => "JCIS 10-70",
            Head::Pan => "ISO 7045",
            Head::Countersunk => self.thread().countersunk.standard,
        }
    }

    /// Returns the name of the screw among a sensor's bodies, for example `screw-m1-6x5`.
    pub fn name(&self) -> String {
        format!("screw-m{}x{}", self.thread_mm, self.length_mm).replace('.', "-")
    }

    /// Returns the text that the screw is ordered by, for example `pan head screw ISO 7045 M1.6x5`.
    pub fn order_text(&self) -> String {
        self.order().article_and_size()
    }

    /// Returns the order for a shop, with the driver that turns the screw: ISO 4757 gives the cross recess of each
    /// thread.
    pub fn order(&self) -> Order {
        let head = match self.head {
            Head::Pan => "pan head",
            Head::Countersunk => "countersunk",
        };
        let driver = match self.thread_mm {
            _ if self.standard() == "DIN 963" => "screwdriver, slotted 0.3 mm thick",
            thread if thread < 2.2 => "screwdriver PH0",
            thread if thread < 3.6 => "screwdriver PH1",
            _ => "screwdriver PH2",
        };
        let size = format!("M{}x{}", self.thread_mm, self.length_mm);
        Order::new(format!("{head} screw {}", self.standard()), size).with_tool(driver)
    }

    /// Returns the diameter of the countersink at the surface, mm, for a countersunk head with clearance `gap_mm` per
    /// side; for other heads, the diameter of the clearance hole.
    pub fn sink_diameter_mm(&self, gap_mm: f64) -> f64 {
        match self.head {
            Head::Pan => self.clearance_hole_mm(),
            Head::Countersunk => self.thread().countersunk.sink_diameter + 2.0 * gap_mm,
        }
    }

    /// Returns the depth of the countersink, mm: from the surface to where its cone meets the hole.
    ///
    /// ```
    /// use fabkit_designs::Screw;
    /// // Flanks at 45 degrees, from a diameter of 4.4 mm at the surface to the hole of 2.4 mm.
    /// assert!((Screw::M2X4.sink_depth_mm(0.0) - 1.0).abs() < 1e-12);
    /// assert_eq!(Screw::M3X16.sink_depth_mm(0.0), 0.0);
    /// ```
    pub fn sink_depth_mm(&self, gap_mm: f64) -> f64 {
        // The cone has 90 degrees, so its depth is half the difference of the diameters.
        (self.sink_diameter_mm(gap_mm) - self.clearance_hole_mm()) / 2.0
    }

    /// Returns the height of the head above the surface it bears on, mm.
    pub fn head_height_mm(&self) -> f64 {
        match self.head {
            Head::Pan => self.thread().pan_head_height,
            Head::Countersunk => 0.0,
        }
    }

    /// Returns the overlap of a self-cut thread with the plastic, mm per side.
    ///
    /// ```
    /// use fabkit_designs::Screw;
    /// // M3 in a hole of 2.5 mm.
    /// assert_eq!(Screw::M3X12.thread_overlap_mm(), 0.25);
    /// ```
    pub fn thread_overlap_mm(&self) -> f64 {
        (self.thread_mm - self.pilot_hole_mm()) / 2.0
    }

    /// Returns the solid of the screw.
    ///
    /// ```
    /// use fabkit_designs::Screw;
    /// use fabkit_geometry::CompiledSolid;
    /// // The tip is 16 mm below the origin; the pan head stands above it.
    /// let screw = CompiledSolid::new(&Screw::M3X16.solid())?.bounds();
    /// assert_eq!([screw.min.z, screw.max.z], [-16.0, 2.4]);
    /// // The length of a countersunk screw includes its head, which ends flush.
    /// let sunk = CompiledSolid::new(&Screw::M2X4.solid())?.bounds();
    /// assert_eq!([sunk.min.z, sunk.max.z], [-4.0, 0.0]);
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
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
                // The cone has 90 degrees, so heights along it equal differences of radii.
                let sharp = self.thread().countersunk.sharp_diameter / 2.0;
                let (foot, rim) = (shaft - sharp, head - sharp);
                let shaft = [[0.0, -length], [shaft, -length], [shaft, foot]];
                [shaft.to_vec(), vec![[head, rim], [head, 0.0], [0.0, 0.0]]].concat()
            }
        };
        Solid::revolution(Path::polygon(&outline)).named("screw")
    }

    /// Returns the passage through a plate of `depth_mm` below the origin, open above. A countersunk head gets the
    /// smallest countersink of its standard plus `gap_mm` per side, so that even the largest head does not protrude.
    /// The cone continues upwards, so that it also cuts through a curved face.
    ///
    /// ```
    /// use fabkit_designs::Screw;
    /// use fabkit_geometry::{CompiledSolid, Point3, Solid};
    /// let plate = Solid::cuboid_between([-5.0, -5.0, -2.0], [5.0, 5.0, 0.0]);
    /// let plate = CompiledSolid::new(&plate.minus(Screw::M2X4.clearance_tool(2.0, 0.1)))?;
    /// // The hole has a radius of 1.2 mm, its countersink 2.3 mm at the surface.
    /// assert!(!plate.contains(&Point3::new(1.1, 0.0, -1.9)));
    /// assert!(plate.contains(&Point3::new(1.3, 0.0, -1.9)));
    /// assert!(!plate.contains(&Point3::new(2.2, 0.0, -0.01)));
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn clearance_tool(&self, depth_mm: f64, gap_mm: f64) -> Solid {
        let hole = self.clearance_hole_mm() / 2.0;
        let bottom = -depth_mm - CUT_OVERLAP_MM;
        let outline = match self.head {
            Head::Pan => {
                vec![[0.0, bottom], [hole, bottom], [hole, CUT_OVERLAP_MM], [0.0, CUT_OVERLAP_MM]]
            }
            Head::Countersunk => {
                let rim = self.sink_diameter_mm(gap_mm) / 2.0;
                // Height, mm, by which the cone continues above the surface.
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

    /// Returns the passage through `depth_mm` below the origin, with a counterbore `height_mm` high above it and
    /// clearance `gap_mm` around the head.
    pub fn counterbore_tool(&self, depth_mm: f64, height_mm: f64, gap_mm: f64) -> Solid {
        let (hole, head) = (self.clearance_hole_mm() / 2.0, self.head_diameter_mm() / 2.0 + gap_mm);
        let (bottom, top) = (-depth_mm - CUT_OVERLAP_MM, height_mm + CUT_OVERLAP_MM);
        Solid::revolution(Path::polygon(&[
            [0.0, bottom],
            [hole, bottom],
            [hole, 0.0],
            [head, 0.0],
            [head, top],
            [0.0, top],
        ]))
    }

    /// Returns the hole that the screw cuts its thread into, `depth_mm` deep below the origin.
    pub fn pilot_tool(&self, depth_mm: f64) -> Solid {
        Solid::cylinder(self.pilot_hole_mm() / 2.0, depth_mm + CUT_OVERLAP_MM).at_z(-depth_mm)
    }
}

/// Hexagon socket head screw, ISO 4762 (dk max of plain heads, k max).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SocketScrew {
    /// Nominal thread diameter, mm.
    pub thread_mm: f64,
    /// Diameter of the head, mm.
    pub head_diameter_mm: f64,
    /// Height of the head, mm.
    pub head_height_mm: f64,
    /// Diameter of the clearance hole, ISO 273 medium, mm.
    pub clearance_hole_mm: f64,
}

/// Lengths that ISO 4762 lists for M4 and M5 and, except the first, for M6, mm.
const SOCKET_LENGTHS_MM: [f64; 10] = [8.0, 10.0, 12.0, 16.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0];

impl SocketScrew {
    /// M4 socket screw.
    pub const M4: Self =
        Self { thread_mm: 4.0, head_diameter_mm: 7.0, head_height_mm: 4.0, clearance_hole_mm: 4.5 };

    /// M5 socket screw.
    pub const M5: Self =
        Self { thread_mm: 5.0, head_diameter_mm: 8.5, head_height_mm: 5.0, clearance_hole_mm: 5.5 };

    /// M6 socket screw.
    pub const M6: Self = Self {
        thread_mm: 6.0,
        head_diameter_mm: 10.0,
        head_height_mm: 6.0,
        clearance_hole_mm: 6.6,
    };

    /// Returns the standard length nearest to `wanted_mm`, mm.
    ///
    /// ```
    /// use fabkit_designs::SocketScrew;
    /// assert_eq!(SocketScrew::length_near_mm(13.0), 12.0);
    /// assert_eq!(
    ///     SocketScrew::M4.order(12.0).article_and_size(),
    ///     "socket head screw ISO 4762 M4x12"
    /// );
    /// ```
    pub fn length_near_mm(wanted_mm: f64) -> f64 {
        let off = |length: &f64| (length - wanted_mm).abs();
        let nearest = SOCKET_LENGTHS_MM.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.unwrap_or(wanted_mm)
    }

    /// Returns the order for a shop, with the hexagon key that turns the screw.
    pub fn order(&self, length_mm: f64) -> Order {
        // ISO 4762: 3, 4 and 5 mm for M4, M5 and M6.
        let key_mm = self.thread_mm - 1.0;
        Order::new("socket head screw ISO 4762", format!("M{}x{length_mm}", self.thread_mm))
            .with_tool(format!("hexagon key {key_mm} mm"))
    }

    /// Returns the solid of the screw, its head bearing at z = 0.
    pub fn solid(&self, length_mm: f64) -> Solid {
        let (shaft, head) = (self.thread_mm / 2.0, self.head_diameter_mm / 2.0);
        Solid::revolution(Path::polygon(&[
            [0.0, -length_mm],
            [shaft, -length_mm],
            [shaft, 0.0],
            [head, 0.0],
            [head, self.head_height_mm],
            [0.0, self.head_height_mm],
        ]))
    }
}
