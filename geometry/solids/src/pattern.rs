//! Patterns of repeated features, as data.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::sequences::GOLDEN_ANGLE_RAD;

use serde::{Deserialize, Serialize};

use crate::{EllipsoidOffset, Pose, Solid};

/// Largest number of features in a pattern.
pub const MAX_FEATURES: usize = 20_000;

/// Pattern of repeated features.
///
/// Each place is a [`Pose`] whose z axis is the feature's axis and whose x axis points away from the pattern's centre
/// line; in a grid, all x axes are parallel to the pattern's. Places are listed from the centre outwards, in a fixed
/// order.
///
/// ```
/// use fabkit_geometry::{Pattern, Point3};
/// let bolts = Pattern::Ring { count: 4, radius_mm: 10.0, phase_rad: 0.0 };
/// let places = bolts.poses()?;
/// assert_eq!(places[1].point(Point3::origin()), Point3::new(0.0, 10.0, 0.0));
/// # Ok::<(), fabkit_geometry::InvalidPattern>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Pattern {
    /// Circle in the plane z = 0, axes along z.
    Ring {
        /// Number of places, at least 1.
        count: u32,
        /// Radius of the circle, mm.
        radius_mm: f64,
        /// Direction of the first place, from x toward y.
        phase_rad: f64,
    },
    /// Circles around the origin in the plane z = 0, axes along z: `counts[k]` places on the circle of radius `k *
    /// spacing_mm`. The first entry stands for the centre: 0 or 1.
    Rings {
        /// Distance from circle to circle, mm.
        spacing_mm: f64,
        /// Number of places on each circle.
        counts: Vec<u32>,
    },
    /// Rectangular grid in the plane z = 0, centred on the origin, axes along z.
    Grid {
        /// Number of places along x and y.
        counts: [u32; 2],
        /// Distance between neighbours along x and y, mm.
        spacing_mm: [f64; 2],
    },
    /// Fibonacci lattice on a spherical cap around +z, axes radially outwards: equal area for each place, no rows
    /// (Gonzalez, "Measurement of areas on a sphere using Fibonacci and latitude-longitude lattices", Mathematical
    /// Geosciences 2010).
    Fibonacci {
        /// Number of places, at least 1.
        count: u32,
        /// Radius of the sphere around the origin, mm.
        radius_mm: f64,
        /// Angle between +z and the cap's rim, up to pi.
        half_angle_rad: f64,
    },
    /// Circles of latitude around +z on a surface of revolution, axes along the outward normals:
    /// `counts[k]` on the circle at the distance `k * spacing_mm` from the tip, measured along the
    /// surface. The first entry stands for the tip: 0 or 1.
    SurfaceRings {
        /// Surface of revolution: a sphere, an ellipsoid (offset 0) or a parallel surface of one.
        surface: EllipsoidOffset,
        /// Distance from circle to circle along the surface, mm.
        spacing_mm: f64,
        /// Number of places on each circle.
        counts: Vec<u32>,
    },
}

/// Reason why a pattern is invalid.
///
/// ```
/// use fabkit_geometry::{InvalidPattern, Pattern};
/// let crowded = Pattern::Rings { spacing_mm: 2.0, counts: vec![3, 6] };
/// assert_eq!(crowded.poses(), Err(InvalidPattern::CrowdedCentre { count: 3 }));
/// let huge = Pattern::Grid { counts: [200, 200], spacing_mm: [1.0, 1.0] };
/// let told = huge.poses().unwrap_err().to_string();
/// assert_eq!(told, "the pattern holds 40000 features; the limit is 20000");
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InvalidPattern {
    /// No feature.
    #[error("the pattern holds no feature; at least one is needed")]
    Empty,
    /// More features than [`MAX_FEATURES`], a limit that keeps meshes small enough.
    #[error("the pattern holds {count} features; the limit is {MAX_FEATURES}")]
    TooMany {
        /// Requested number.
        count: u64,
    },
    /// Parameter out of its range.
    #[error("{name} is {value}; it must be {allowed}")]
    OutOfRange {
        /// Name of the parameter.
        name: &'static str,
        /// Requested value.
        value: f64,
        /// Allowed range, as text.
        allowed: &'static str,
    },
    /// More than one feature at a centre.
    #[error("{count} features at the centre; there is room for 0 or 1")]
    CrowdedCentre {
        /// Requested number.
        count: u32,
    },
    /// Outermost circle beyond the far pole.
    #[error(
        "the outermost circle lies {distance_mm} mm from the tip; the surface ends after {limit_mm} mm"
    )]
    BeyondSurface {
        /// Requested distance from the tip, mm along the surface.
        distance_mm: f64,
        /// Length from pole to pole, mm along the surface.
        limit_mm: f64,
    },
}

/// Returns an error unless the value is finite and above 0.
fn positive(name: &'static str, value: f64) -> Result<(), InvalidPattern> {
    let fine = value.is_finite() && value > 0.0;
    let allowed = "finite and above 0";
    if fine { Ok(()) } else { Err(InvalidPattern::OutOfRange { name, value, allowed }) }
}

impl Pattern {
    /// Creates a pattern of the centre and `rings` circles around it with 6, 12, 18, ... places: every place is about
    /// `spacing_mm` from its neighbours.
    ///
    /// ```
    /// use fabkit_geometry::Pattern;
    /// assert_eq!(Pattern::six_per_ring(2, 1.5).count(), 1 + 6 + 12);
    /// let alone = Pattern::Rings { spacing_mm: 1.5, counts: vec![1] };
    /// assert_eq!(Pattern::six_per_ring(0, 1.5), alone);
    /// ```
    pub fn six_per_ring(rings: u32, spacing_mm: f64) -> Self {
        let counts = (0..=rings).map(|k| if k == 0 { 1 } else { 6 * k }).collect();
        Self::Rings { spacing_mm, counts }
    }

    /// Creates a pattern of the tip and `rings` circles around it on a surface. The number of places on each circle
    /// brings the distance of neighbours along the circle as near as possible to `spacing_mm`.
    ///
    /// # Errors
    /// Same as for [`Pattern::poses`].
    ///
    /// ```
    /// use fabkit_geometry::{EllipsoidOffset, Pattern};
    /// let ball = EllipsoidOffset { equatorial_mm: 10.0, polar_mm: 10.0, offset_mm: 0.0 };
    /// let spacing_mm = 10.0 * 30f64.to_radians(); // a circle at every 30 degrees from the tip
    /// let to_equator = Pattern::even_surface_rings(ball.clone(), 3, spacing_mm)?;
    /// // Circles of radius 5, 8.66 and 10 mm have room for 6, 10.4 and 12 times 5.24 mm.
    /// assert_eq!(to_equator.count(), 1 + 6 + 10 + 12);
    /// // The far pole is 180 degrees from the tip: there is no seventh circle.
    /// assert!(Pattern::even_surface_rings(ball, 7, spacing_mm).is_err());
    /// # Ok::<(), fabkit_geometry::InvalidPattern>(())
    /// ```
    pub fn even_surface_rings(
        surface: EllipsoidOffset,
        rings: u32,
        spacing_mm: f64,
    ) -> Result<Self, InvalidPattern> {
        positive("spacing", spacing_mm)?;
        if rings as usize >= MAX_FEATURES {
            return Err(InvalidPattern::TooMany { count: u64::from(rings) });
        }
        let meridian = Meridian::new(&surface)?;
        meridian.check_reach(f64::from(rings) * spacing_mm)?;
        let counts = (0..=rings)
            .map(|k| {
                let radius_mm = meridian.at_distance(f64::from(k) * spacing_mm).0[0];
                // A ring has at least one place; the number is rounded to the nearest integer.
                (TAU * radius_mm / spacing_mm).round().max(1.0) as u32
            })
            .collect();
        Ok(Self::SurfaceRings { surface, spacing_mm, counts })
    }

    /// Returns the number of features.
    pub fn count(&self) -> u64 {
        match self {
            Self::Ring { count, .. } | Self::Fibonacci { count, .. } => u64::from(*count),
            Self::Grid { counts, .. } => counts.iter().map(|&n| u64::from(n)).product(),
            Self::Rings { counts, .. } | Self::SurfaceRings { counts, .. } => {
                counts.iter().map(|&n| u64::from(n)).sum()
            }
        }
    }

    /// Returns the places, from the centre outwards, in the pattern's frame.
    ///
    /// # Errors
    /// No or too many features, sizes that are not finite and positive, circles beyond the surface.
    pub fn poses(&self) -> Result<Vec<Pose>, InvalidPattern> {
        match self.count() {
            0 => return Err(InvalidPattern::Empty),
            count if count > MAX_FEATURES as u64 => return Err(InvalidPattern::TooMany { count }),
            _ => {}
        }
        match self {
            Self::Ring { count, radius_mm, phase_rad } => {
                positive("radius", *radius_mm)?;
                if !phase_rad.is_finite() {
                    let (name, value) = ("phase", *phase_rad);
                    return Err(InvalidPattern::OutOfRange { name, value, allowed: "finite" });
                }
                Ok(around(*count, *phase_rad, [*radius_mm, 0.0], 0.0).collect())
            }
            Self::Rings { spacing_mm, counts } => {
                positive("spacing", *spacing_mm)?;
                room_at_centre(counts)?;
                let ring = |(k, &count): (usize, &u32)| {
                    around(count, 0.0, [k as f64 * spacing_mm, 0.0], 0.0)
                };
                Ok(counts.iter().enumerate().flat_map(ring).collect())
            }
            Self::Grid { counts, spacing_mm } => {
                positive("spacing", spacing_mm[0])?;
                positive("spacing", spacing_mm[1])?;
                Ok(grid(*counts, *spacing_mm))
            }
            Self::Fibonacci { count, radius_mm, half_angle_rad } => {
                positive("radius", *radius_mm)?;
                positive("half angle", *half_angle_rad)?;
                if *half_angle_rad > PI {
                    let (name, value) = ("half angle", *half_angle_rad);
                    return Err(InvalidPattern::OutOfRange { name, value, allowed: "at most pi" });
                }
                Ok(fibonacci(*count, *radius_mm, *half_angle_rad))
            }
            Self::SurfaceRings { surface, spacing_mm, counts } => {
                positive("spacing", *spacing_mm)?;
                room_at_centre(counts)?;
                let meridian = Meridian::new(surface)?;
                meridian.check_reach((counts.len() - 1) as f64 * spacing_mm)?;
                let ring = |(k, &count): (usize, &u32)| {
                    let (point, tilt_rad) = meridian.at_distance(k as f64 * spacing_mm);
                    around(count, 0.0, point, tilt_rad)
                };
                Ok(counts.iter().enumerate().flat_map(ring).collect())
            }
        }
    }

    /// Returns one copy of `feature` at each place, named `word 1`, `word 2`, ... from the centre outwards.
    ///
    /// # Errors
    /// Same as for [`Pattern::poses`].
    ///
    /// ```
    /// use fabkit_geometry::{Pattern, Solid};
    /// let bolts = Pattern::Ring { count: 3, radius_mm: 8.0, phase_rad: 0.0 };
    /// let holes = bolts.features("hole", &Solid::cylinder(1.5, 4.0).at_z(-1.0))?;
    /// let plate = Solid::cylinder(12.0, 2.0).minus_all(holes);
    /// let names: Vec<&str> = plate.leaves().iter().map(|leaf| leaf.feature).collect();
    /// assert_eq!(names, ["", "hole 1", "hole 2", "hole 3"]);
    /// # Ok::<(), fabkit_geometry::InvalidPattern>(())
    /// ```
    pub fn features(&self, word: &str, feature: &Solid) -> Result<Vec<Solid>, InvalidPattern> {
        let place =
            |(i, pose)| feature.clone().placed(pose).named(format!("{word} {}", i + 1usize));
        Ok(self.poses()?.into_iter().enumerate().map(place).collect())
    }
}

fn room_at_centre(counts: &[u32]) -> Result<(), InvalidPattern> {
    match counts {
        &[count, ..] if count > 1 => Err(InvalidPattern::CrowdedCentre { count }),
        _ => Ok(()),
    }
}

/// Returns the pose at a point of the half plane at the angle `azimuth` from x, with the axis tilted from z away from
/// the centre line.
fn pose_at_azimuth(azimuth: f64, point: [f64; 2], tilt_rad: f64) -> Pose {
    let turn = |angle, about: fn(crate::Angle) -> Pose| {
        crate::Angle::from_rad(angle).map_or(Pose::identity(), about)
    };
    turn(azimuth, Pose::rotation_z)
        .then_in(Pose::translation(point[0], 0.0, point[1]))
        .then_in(turn(tilt_rad, Pose::rotation_y))
}

fn around(count: u32, phase: f64, point: [f64; 2], tilt: f64) -> impl Iterator<Item = Pose> {
    let azimuth = move |i: u32| phase + TAU * (f64::from(i) / f64::from(count));
    (0..count).map(move |i| pose_at_azimuth(azimuth(i), point, tilt))
}

/// Returns the places sorted by distance from the centre, then row by row.
fn grid(counts: [u32; 2], spacing_mm: [f64; 2]) -> Vec<Pose> {
    let at = |i: u32, n: u32, step: f64| (f64::from(i) - 0.5 * f64::from(n - 1)) * step;
    let mut places: Vec<[f64; 2]> = (0..counts[1])
        .flat_map(|row| (0..counts[0]).map(move |column| [column, row]))
        .map(|[i, j]| [at(i, counts[0], spacing_mm[0]), at(j, counts[1], spacing_mm[1])])
        .collect();
    // The sort is stable. Equal distances have equal bits because the grid is symmetric.
    places.sort_by(|p, q| p[0].hypot(p[1]).total_cmp(&q[0].hypot(q[1])));
    places.into_iter().map(|[x, y]| Pose::translation(x, y, 0.0)).collect()
}

fn fibonacci(count: u32, radius_mm: f64, half_angle_rad: f64) -> Vec<Pose> {
    // 1 - cos(half angle), without cancellation for small caps.
    let cap_height = 2.0 * (0.5 * half_angle_rad).sin().powi(2);
    (0..count)
        .map(|i| {
            // Equal steps of height give equal areas on a sphere (Archimedes).
            let height = cap_height * (f64::from(i) + 0.5) / f64::from(count);
            let tilt = 2.0 * (0.5 * height).sqrt().min(1.0).asin();
            let point = [radius_mm * tilt.sin(), radius_mm * tilt.cos()];
            pose_at_azimuth(GOLDEN_ANGLE_RAD * f64::from(i), point, tilt)
        })
        .collect()
}

/// Number of panels per quarter of the meridian, each integrated by Gauss-Legendre quadrature with five nodes: exact to
/// rounding for half axes up to 1:20.
const QUARTER_PANELS: usize = 64;

/// Meridian from pole to pole of a parallel surface of an ellipsoid of revolution, parametrised by the ellipse's
/// eccentric angle: 0 at the upper pole, pi at the lower.
struct Meridian {
    equatorial_mm: f64,
    polar_mm: f64,
    offset_mm: f64,
    length_mm: f64,
    /// Distances from the upper pole to the start of each panel, and to the lower pole.
    begins_mm: Vec<f64>,
}

impl Meridian {
    fn new(surface: &EllipsoidOffset) -> Result<Self, InvalidPattern> {
        let EllipsoidOffset { equatorial_mm, polar_mm, offset_mm } = *surface;
        positive("equatorial half axis", equatorial_mm)?;
        positive("polar half axis", polar_mm)?;
        let (long, short) = (equatorial_mm.max(polar_mm), equatorial_mm.min(polar_mm));
        if !(offset_mm.is_finite() && offset_mm > -short * short / long) {
            let allowed = "above minus the ellipsoid's smallest radius of curvature";
            return Err(InvalidPattern::OutOfRange { name: "offset", value: offset_mm, allowed });
        }
        let begins_mm = Vec::with_capacity(2 * QUARTER_PANELS + 1);
        let mut meridian = Self { equatorial_mm, polar_mm, offset_mm, length_mm: 0.0, begins_mm };
        let mut ellipse_mm = 0.0;
        for panel in 0..=2 * QUARTER_PANELS {
            let (begin, end) = (Self::begin(panel), Self::begin(panel + 1));
            // Steiner: a parallel curve is longer by the offset times the angle its normal turns through.
            meridian.begins_mm.push(ellipse_mm + offset_mm * meridian.tilt(begin));
            ellipse_mm += meridian.ellipse_mm(begin, end);
        }
        // The meridian is symmetric about the equator.
        meridian.length_mm = 2.0 * meridian.begins_mm[QUARTER_PANELS];
        Ok(meridian)
    }

    fn check_reach(&self, distance_mm: f64) -> Result<(), InvalidPattern> {
        let limit_mm = self.length_mm;
        // Compared this way so that NaN is refused too.
        if distance_mm < limit_mm {
            Ok(())
        } else {
            Err(InvalidPattern::BeyondSurface { distance_mm, limit_mm })
        }
    }

    /// Returns the eccentric angle at which a panel begins.
    fn begin(panel: usize) -> f64 {
        FRAC_PI_2 * panel as f64 / QUARTER_PANELS as f64
    }

    /// Computes the angle between z and the normal.
    fn tilt(&self, eccentric: f64) -> f64 {
        (self.polar_mm * eccentric.sin()).atan2(self.equatorial_mm * eccentric.cos())
    }

    /// Computes the arc length of the ellipse per radian of eccentric angle, mm.
    fn speed(&self, eccentric: f64) -> f64 {
        (self.equatorial_mm * eccentric.cos()).hypot(self.polar_mm * eccentric.sin())
    }

    /// Computes the length of the ellipse between two eccentric angles of one panel.
    fn ellipse_mm(&self, begin: f64, end: f64) -> f64 {
        // Nodes and weights of five-point Gauss-Legendre quadrature on [-1, 1].
        const NODES: [(f64, f64); 3] = [
            (0.0, 0.568_888_888_888_888_9),
            (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        ];
        let (middle, half) = (0.5 * (begin + end), 0.5 * (end - begin));
        let both = |x: f64| self.speed(middle - half * x) + self.speed(middle + half * x);
        let node = |&(x, weight): &(f64, f64)| {
            weight * if x == 0.0 { self.speed(middle) } else { both(x) }
        };
        half * NODES.iter().map(node).sum::<f64>()
    }

    /// Returns the point (distance from z, height) at a distance from the upper pole along the parallel surface, and
    /// the tilt of its normal. The distance is the ellipse's own arc length plus the offset times the angle through
    /// which the normal has turned (Steiner).
    fn at_distance(&self, distance_mm: f64) -> ([f64; 2], f64) {
        let eccentric = self.eccentric(distance_mm);
        let tilt = self.tilt(eccentric);
        let point = [
            self.equatorial_mm * eccentric.sin() + self.offset_mm * tilt.sin(),
            self.polar_mm * eccentric.cos() + self.offset_mm * tilt.cos(),
        ];
        (point, tilt)
    }

    /// Finds the eccentric angle for a distance by Newton's method within the panel, safeguarded by bisection: the
    /// distance increases monotonically.
    fn eccentric(&self, distance_mm: f64) -> f64 {
        /// Largest number of iterations; this many halvings alone exhaust the digits.
        const MOST_STEPS: usize = 60;
        if distance_mm == 0.0 {
            return 0.0;
        }
        let panel = self.begins_mm.partition_point(|&begin| begin <= distance_mm);
        let panel = panel.clamp(1, 2 * QUARTER_PANELS) - 1;
        let begin = Self::begin(panel);
        // Distance within the panel, plus the share of the normal at its start.
        let rest = distance_mm - self.begins_mm[panel] + self.offset_mm * self.tilt(begin);
        let (mut low, mut high) = (begin, Self::begin(panel + 1));
        let mut eccentric = 0.5 * (low + high);
        for _ in 0..MOST_STEPS {
            let missing =
                rest - self.ellipse_mm(begin, eccentric) - self.offset_mm * self.tilt(eccentric);
            if missing > 0.0 {
                low = eccentric
            } else {
                high = eccentric
            }
            let speed = self.speed(eccentric);
            // Derivative of the tilt with respect to the eccentric angle.
            let turning = self.equatorial_mm * self.polar_mm / speed.powi(2);
            let next = eccentric + missing / (speed + self.offset_mm * turning);
            let next = if (low..=high).contains(&next) { next } else { 0.5 * (low + high) };
            if next == eccentric {
                break;
            }
            eccentric = next;
        }
        eccentric
    }
}
