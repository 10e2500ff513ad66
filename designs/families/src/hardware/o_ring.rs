//! O-rings as they are stocked, and their shape in a groove.
//!
//! Rubber keeps its volume: the cord of a ring that is stretched over a groove gets thinner, and a cord that is
//! squeezed in height gets wider. Grooves follow ISO 3601-2: squeezed by 10 to 30 % and filled to 60 to 85 %, so that a
//! ring seals and has room to swell and to deform.

use std::f64::consts::{PI, TAU};

use fabkit_geometry::{Order, Path, Solid};

/// Largest momentary stretch of a ring while it is pulled over a flange, as a fraction; chosen: makers of silicone and
/// nitrile rings allow more than twice as much.
const STRETCH_SHARE: f64 = 0.3;

/// O-ring without load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ORing {
    /// Inside diameter, mm.
    pub inside_mm: f64,
    /// Diameter of the cord, mm.
    pub cord_mm: f64,
    /// Standard or kind of stock that lists the size.
    pub standard: &'static str,
}

/// Stocked rings of one cord diameter.
struct Series {
    cord_mm: f64,
    standard: &'static str,
    inside: Inside,
}

/// Stocked inside diameters, mm.
enum Inside {
    /// Every whole millimetre from the first to the last.
    Whole(u32, u32),
    /// Values of a standard's table.
    Listed(&'static [f64]),
}

/// Inside diameters of ISO 3601-1, size codes 004 to 050, mm.
const CORD_1_78: [f64; 47] = [
    1.78, 2.57, 2.90, 3.68, 4.47, 5.28, 6.07, 7.65, 9.25, 10.82, 12.42, 14.00, 15.60, 17.17, 18.77,
    20.35, 21.95, 23.52, 25.12, 26.70, 28.30, 29.87, 31.47, 33.05, 34.65, 37.82, 41.00, 44.17,
    47.35, 50.52, 53.70, 56.87, 60.05, 63.22, 66.40, 69.57, 72.75, 75.92, 82.27, 88.62, 94.97,
    101.32, 107.67, 114.02, 120.37, 126.72, 133.07,
];
/// Inside diameters of ISO 3601-1, size codes 102 to 130, mm.
const CORD_2_62: [f64; 29] = [
    1.24, 2.06, 2.84, 3.63, 4.42, 5.23, 6.02, 7.59, 9.19, 10.77, 12.37, 13.94, 15.54, 17.12, 18.72,
    20.29, 21.89, 23.47, 25.07, 26.64, 28.24, 29.82, 31.42, 32.99, 34.59, 36.17, 37.77, 39.34,
    40.94,
];
/// Inside diameters of ISO 3601-1, size codes 201 to 222, mm.
const CORD_3_53: [f64; 22] = [
    4.34, 5.94, 7.52, 9.12, 10.69, 12.29, 13.87, 15.47, 17.04, 18.64, 20.22, 21.82, 23.39, 24.99,
    26.57, 28.17, 29.74, 31.34, 32.92, 34.52, 36.09, 37.69,
];

/// Inside diameters of ISO 3601-1:1988, series G for general use, also GB/T 3452.1; the preferred ones from 10 mm, mm.
const CORD_1_80: [f64; 30] = [
    10.0, 10.6, 11.2, 11.8, 12.5, 13.2, 14.0, 15.0, 16.0, 17.0, 18.0, 19.0, 20.0, 21.2, 22.4, 23.6,
    25.0, 25.8, 26.5, 28.0, 30.0, 31.5, 32.5, 33.5, 34.5, 35.5, 36.5, 37.5, 38.7, 40.0,
];

const METRIC: &str = "metric stock size";
const ISO_3601: &str = "ISO 3601-1";

/// All stocked rings, by cord diameter.
const SERIES: [Series; 9] = [
    Series { cord_mm: 1.0, standard: METRIC, inside: Inside::Whole(3, 40) },
    Series { cord_mm: 1.5, standard: METRIC, inside: Inside::Whole(3, 60) },
    Series { cord_mm: 1.78, standard: ISO_3601, inside: Inside::Listed(&CORD_1_78) },
    Series { cord_mm: 1.8, standard: ISO_3601, inside: Inside::Listed(&CORD_1_80) },
    Series { cord_mm: 2.0, standard: METRIC, inside: Inside::Whole(3, 100) },
    Series { cord_mm: 2.5, standard: METRIC, inside: Inside::Whole(4, 100) },
    Series { cord_mm: 2.62, standard: ISO_3601, inside: Inside::Listed(&CORD_2_62) },
    Series { cord_mm: 3.0, standard: METRIC, inside: Inside::Whole(5, 100) },
    Series { cord_mm: 3.53, standard: ISO_3601, inside: Inside::Listed(&CORD_3_53) },
];

/// Largest permanent stretch of a ring, as a fraction; makers allow 5 %.
pub const MOST_STRETCH: f64 = 0.05;

/// Tolerance for rounding errors: a groove of 16.8 mm stretches a ring of 16 mm by exactly 5 %.
const ROUNDING: f64 = 1e-9;

/// Largest slack of a ring around its groove's bottom, as a fraction: the wall around it presses it back.
const MOST_SLACK: f64 = 0.01;

/// Play between a modelled ring and the faces that squeeze it, mm, so that the solids do not touch.
pub const SQUEEZED_PLAY_MM: f64 = 0.01;

/// Returns the stocked cord diameters, mm, for messages: `1, 1.5, 1.78`.
pub fn stocked_cords() -> String {
    SERIES.iter().map(|series| series.cord_mm.to_string()).collect::<Vec<_>>().join(", ")
}

impl ORing {
    /// Finds the stocked ring of a cord diameter for a groove with the given bottom diameter, mm: the widest one that
    /// is stretched, otherwise one that is slightly wider; `None` if none is stocked.
    ///
    /// ```
    /// use fabkit_designs::ORing;
    /// // Metric rings of this cord come in whole millimetres; 16 mm is stretched by 3 % to 16.5 mm.
    /// let ring = ORing::find_stocked(2.0, 16.5).ok_or("not stocked")?;
    /// assert_eq!((ring.inside_mm, ring.standard), (16.0, "metric stock size"));
    /// // No cord of 2.2 mm is stocked.
    /// assert_eq!(ORing::find_stocked(2.2, 16.5), None);
    /// # Ok::<(), &str>(())
    /// ```
    pub fn find_stocked(cord_mm: f64, bottom_mm: f64) -> Option<Self> {
        let series = SERIES.iter().find(|series| (series.cord_mm - cord_mm).abs() < 1e-9)?;
        let fits = |inside_mm: &f64| {
            let stretch = bottom_mm / inside_mm - 1.0;
            (-MOST_SLACK..=MOST_STRETCH + ROUNDING).contains(&stretch)
        };
        let best = |all: &mut dyn Iterator<Item = f64>| {
            let fitting: Vec<f64> = all.filter(fits).collect();
            // Sizes ascend, so this is the widest ring that is not loose.
            let stretched = fitting.iter().rev().find(|inside_mm| **inside_mm <= bottom_mm);
            stretched.or(fitting.first()).copied()
        };
        let inside_mm = match series.inside {
            Inside::Whole(from, to) => best(&mut (from..=to).map(f64::from)),
            Inside::Listed(listed) => best(&mut listed.iter().copied()),
        }?;
        Some(Self { inside_mm, cord_mm: series.cord_mm, standard: series.standard })
    }

    /// Finds the stocked ring, or returns one that is marked as not stocked; families report such a ring as a problem.
    pub fn or_unstocked(cord_mm: f64, bottom_mm: f64) -> Self {
        let unstocked = Self { inside_mm: bottom_mm, cord_mm, standard: "not stocked" };
        Self::find_stocked(cord_mm, bottom_mm).unwrap_or(unstocked)
    }

    /// Returns the size code in ISO 3601-1, which is the dash number in AS568; `None` for metric sizes.
    ///
    /// ```
    /// use fabkit_designs::ORing;
    /// let ring = ORing::find_stocked(1.78, 14.0).ok_or("not stocked")?;
    /// assert_eq!(ring.size_code(), Some(15));
    /// assert_eq!(ring.order().size, "14 x 1.78 mm (AS568-015)");
    /// # Ok::<(), &str>(())
    /// ```
    pub fn size_code(&self) -> Option<usize> {
        let coded: [(f64, &[f64], usize); 3] =
            [(1.78, &CORD_1_78, 4), (2.62, &CORD_2_62, 102), (3.53, &CORD_3_53, 201)];
        let (_, inside, first) = coded.into_iter().find(|(cord, ..)| *cord == self.cord_mm)?;
        Some(first + inside.iter().position(|inside_mm| *inside_mm == self.inside_mm)?)
    }

    /// Returns the order for a shop.
    pub fn order(&self) -> Order {
        let size = format!("{} x {} mm", self.inside_mm, self.cord_mm);
        match self.size_code() {
            Some(code) => Order::new("O-ring ISO 3601-1", format!("{size} (AS568-{code:03})")),
            None if self.standard == ISO_3601 => Order::new("O-ring ISO 3601-1", size),
            None => Order::new("O-ring, metric", size),
        }
    }

    /// Returns the volume, mm^3, which does not change in a groove.
    pub fn volume_mm3(&self) -> f64 {
        // Volume of a torus: its section times the length of its centre line.
        PI * PI / 4.0 * self.cord_mm.powi(2) * (self.inside_mm + self.cord_mm)
    }

    /// Returns the cross section of the cord, mm^2, when the ring is stretched to a middle radius.
    pub fn section_mm2(&self, middle_radius_mm: f64) -> f64 {
        self.volume_mm3() / (TAU * middle_radius_mm)
    }

    /// Returns how far the ring may be stretched outwards while it is pulled over a flange, mm of radius.
    pub fn max_stretch_mm(&self) -> f64 {
        STRETCH_SHARE * self.inside_mm / 2.0
    }

    /// Returns the diameter of the cord, mm, when the ring is stretched to an inside diameter.
    ///
    /// ```
    /// use fabkit_designs::ORing;
    /// let ring = ORing::find_stocked(2.0, 20.0).ok_or("not stocked")?;
    /// assert!((ring.stretched_cord_mm(20.0) - 2.0).abs() < 1e-9);
    /// // Rubber keeps its volume: the longer ring is thinner.
    /// let cord_mm = ring.stretched_cord_mm(21.0);
    /// assert!((cord_mm.powi(2) * (21.0 + cord_mm) - 2.0_f64.powi(2) * (20.0 + 2.0)).abs() < 1e-6);
    /// # Ok::<(), &str>(())
    /// ```
    pub fn stretched_cord_mm(&self, inside_mm: f64) -> f64 {
        // The middle radius depends slightly on the cord's diameter: a few fixed-point iterations converge.
        (0..8).fold(self.cord_mm, |cord, _| {
            (4.0 / PI * self.section_mm2((inside_mm + cord) / 2.0)).sqrt()
        })
    }

    /// Returns the solid of the ring around z, squeezed between two cylinders, its middle at z = 0: flat where they
    /// touch it, round at both ends. `radii_mm` are the radii of the inner and outer cylinder.
    ///
    /// ```
    /// use fabkit_designs::{ORing, SQUEEZED_PLAY_MM};
    /// use fabkit_geometry::CompiledSolid;
    /// // A cord of 2 mm between radii of 10 mm and 11.6 mm.
    /// let ring = ORing::find_stocked(2.0, 20.0).ok_or("not stocked")?;
    /// let bounds = CompiledSolid::new(&ring.between_cylinders([10.0, 11.6]))?.bounds();
    /// assert!((bounds.max.x - (11.6 - SQUEEZED_PLAY_MM)).abs() < 1e-9);
    /// // Squeezed by a fifth, it gets higher than its cord.
    /// assert!(bounds.max.z - bounds.min.z > 2.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn between_cylinders(&self, radii_mm: [f64; 2]) -> Solid {
        let [inner, outer] = [radii_mm[0] + SQUEEZED_PLAY_MM, radii_mm[1] - SQUEEZED_PLAY_MM];
        let (middle, half) = ((inner + outer) / 2.0, (outer - inner) / 2.0);
        let straight = self.straight_mm(2.0 * half, middle) / 2.0;
        let outline = Path::from([outer, -straight])
            .line([outer, straight])
            .arc([inner, straight], [middle, straight], true)
            .line([inner, -straight])
            .arc([outer, -straight], [middle, -straight], true)
            .close();
        Solid::revolution(outline)
    }

    /// Returns the solid of the ring around z, squeezed between two planes `height_mm` apart around z = 0; its inside
    /// rests on a cylinder of `inner_radius_mm`.
    pub fn between_planes(&self, inner_radius_mm: f64, height_mm: f64) -> Solid {
        let half = height_mm / 2.0 - SQUEEZED_PLAY_MM;
        let inner = inner_radius_mm + SQUEEZED_PLAY_MM;
        // A wider ring has a smaller section: a few fixed-point iterations converge.
        let straight = (0..8).fold(0.0, |straight: f64, _| {
            self.straight_mm(2.0 * half, inner + half + straight / 2.0)
        });
        let [from, to] = [inner + half, inner + half + straight];
        let outline = Path::from([from, -half])
            .line([to, -half])
            .arc([to, half], [to, 0.0], true)
            .line([from, half])
            .arc([from, -half], [from, 0.0], true)
            .close();
        Solid::revolution(outline)
    }

    /// Returns the length of the flats, mm, of a section that is squeezed to a height.
    fn straight_mm(&self, height_mm: f64, middle_radius_mm: f64) -> f64 {
        // The squeezed section is a stadium: two half discs and a rectangle between them.
        let round = PI / 4.0 * height_mm.powi(2);
        ((self.section_mm2(middle_radius_mm) - round) / height_mm).max(1e-3)
    }
}
