//! Compensation of round holes in an exported copy, so that the printer makes them as wide as designed.

use fabkit_geometry::{Cylinder, Extrusion, Path, Pose, Profile, Segment, Solid};

use super::ProcessProfile;

/// Range in which the fitted line is trusted: measured diameters divided and multiplied by this factor.
const REACH: f64 = 2.0;

/// Cosine of the largest angle between the axis of an upright hole and the bed's normal.
const UPRIGHT: f64 = 0.9998;

/// Counts of the round holes of a part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HoleCount {
    /// Number of upright holes whose diameter was changed in the copy.
    pub fitted: usize,
    /// Number of round holes left as designed: not upright, or far from any measured diameter.
    pub unchanged: usize,
}

impl ProcessProfile {
    /// Returns a copy whose upright round holes come out of the printer with their designed diameter, provided that the
    /// copy is then scaled by [`ProcessProfile::scale`] along the bed's axes.
    ///
    /// Holes are cylinders that are cut away, and circles in the outlines of extrusions. Slots, countersinks and turned
    /// shapes stay as they are. `solid` is in the part's frame, `bed_from_part` is the pose in which it is printed;
    /// `cast_scale` is the factor by which a mold is enlarged in addition.
    ///
    /// ```
    /// use fabkit_designs::profile::{HoleCount, ProcessProfile};
    /// use fabkit_geometry::{CompiledSolid, Point3, Pose, Solid};
    /// // Holes come out 0.2 mm too narrow.
    /// let yaml = "
    /// format: 1
    /// name: my-printer
    /// process: fdm
    /// material: PLA
    /// shrinkage_percent: {x: 0.0, y: 0.0, z: 0.0}
    /// holes: {offset: -0.2 mm, gain: 1.0, smallest: 2 mm, largest: 12 mm}
    /// pins: {offset: 0.1 mm, gain: 1.0, smallest: 2 mm, largest: 8 mm}
    /// elephant_foot: 0.1 mm
    /// ";
    /// let profile = ProcessProfile::read("my-printer.yaml", yaml)?;
    /// let plate = Solid::cuboid(20.0, 20.0, 2.0).minus(Solid::cylinder(2.5, 4.0).at_z(-1.0));
    /// let (copy, count) = profile.fit_holes(&plate, &Pose::identity(), 1.0);
    /// assert_eq!(count, HoleCount { fitted: 1, unchanged: 0 });
    /// // The hole of 5 mm is written with 5.2 mm.
    /// let copy = CompiledSolid::new(&copy)?;
    /// assert!(
    ///     !copy.contains(&Point3::new(2.59, 0.0, 1.0))
    ///         && copy.contains(&Point3::new(2.61, 0.0, 1.0))
    /// );
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn fit_holes(
        &self,
        solid: &Solid,
        bed_from_part: &Pose,
        cast_scale: f64,
    ) -> (Solid, HoleCount) {
        // Upright holes are scaled along x and y only; the mean keeps them circular.
        let [x, y, _] = self.scale();
        let mut work = HoleCompensator {
            profile: self,
            cast_scale,
            scale: cast_scale * (x + y) / 2.0,
            count: HoleCount::default(),
        };
        let solid = work.solid(solid, bed_from_part, false);
        (solid, work.count)
    }
}

/// State of the compensation of one solid.
struct HoleCompensator<'a> {
    profile: &'a ProcessProfile,
    /// Factor from the designed size to the wanted one.
    cast_scale: f64,
    /// Factor from the size in the solid to that in the file.
    scale: f64,
    count: HoleCount,
}

impl HoleCompensator<'_> {
    /// Copies a solid with compensated holes; `is_cut` is true if the solid is cut away.
    fn solid(&mut self, solid: &Solid, bed_from_solid: &Pose, is_cut: bool) -> Solid {
        let mut all = |of: &[Solid], is_cut| -> Vec<Solid> {
            of.iter().map(|one| self.solid(one, bed_from_solid, is_cut)).collect()
        };
        match solid {
            Solid::Union(of) => Solid::Union(all(of, is_cut)),
            Solid::Intersection(of) => Solid::Intersection(all(of, is_cut)),
            Solid::Difference { of, minus } => {
                // Whatever is cut from a cutting body is material again.
                let minus = all(minus, !is_cut);
                Solid::Difference { of: Box::new(self.solid(of, bed_from_solid, is_cut)), minus }
            }
            Solid::Placed { pose, of } => Solid::Placed {
                pose: *pose,
                of: Box::new(self.solid(of, &bed_from_solid.then_in(*pose), is_cut)),
            },
            Solid::Feature { name, of } => {
                let of = Box::new(self.solid(of, bed_from_solid, is_cut));
                Solid::Feature { name: name.clone(), of }
            }
            Solid::Cylinder(cylinder) if is_cut => {
                let radius_mm = self.radius(cylinder.radius_mm, bed_from_solid);
                Solid::Cylinder(Cylinder { radius_mm, ..cylinder.clone() })
            }
            Solid::Extrusion(Extrusion { profile, height_mm }) => {
                let Profile { outer, holes } = profile;
                // A hole in the profile of a cutting body leaves a pin, which is not compensated.
                let outer = if is_cut { self.path(outer, bed_from_solid) } else { outer.clone() };
                let holes = if is_cut {
                    holes.clone()
                } else {
                    holes.iter().map(|hole| self.path(hole, bed_from_solid)).collect()
                };
                let profile = Profile { outer, holes };
                Solid::Extrusion(Extrusion { profile, height_mm: *height_mm })
            }
            other => other.clone(),
        }
    }

    /// Compensates a path if it is a full circle.
    fn path(&mut self, path: &Path, bed_from_path: &Pose) -> Path {
        match whole_circle(path) {
            Some((centre, radius)) => Path::circle(centre, self.radius(radius, bed_from_path)),
            None => path.clone(),
        }
    }

    /// Returns the compensated radius of a hole, mm, and counts it.
    fn radius(&mut self, designed_mm: f64, bed_from_hole: &Pose) -> f64 {
        let is_upright = bed_from_hole.rotation()[(2, 2)].abs() > UPRIGHT;
        let wanted_mm = 2.0 * designed_mm * self.cast_scale;
        let fit = &self.profile.holes;
        let known = fit.smallest.mm() / REACH..=fit.largest.mm() * REACH;
        if !is_upright || !known.contains(&wanted_mm) {
            self.count.unchanged += 1;
            return designed_mm;
        }
        self.count.fitted += 1;
        // The copy is scaled afterwards, so the scale is divided out here.
        self.profile.hole_mm(wanted_mm) / 2.0 / self.scale
    }
}

/// Returns centre and radius of a closed path that consists of arcs about one point.
fn whole_circle(path: &Path) -> Option<([f64; 2], f64)> {
    let mut circle = None;
    for segment in &path.segments {
        let Segment::Arc { to, centre, .. } = segment else { return None };
        let radius = (to[0] - centre[0]).hypot(to[1] - centre[1]);
        match circle {
            None => circle = Some((*centre, radius)),
            Some((first, r)) if first == *centre && (radius - r).abs() < 1e-9 => {}
            Some(_) => return None,
        }
    }
    circle.filter(|_| path.end() == path.start)
}
