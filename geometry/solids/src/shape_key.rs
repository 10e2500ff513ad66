//! Structural comparison of solids, ignoring feature names.

use crate::{Path, Profile, Segment, Solid};

impl Solid {
    /// Returns a key that is equal for two solids exactly if they are the same tree with the same numbers, apart from
    /// names.
    ///
    /// ```
    /// use fabkit_geometry::Solid;
    /// let hole = Solid::cylinder(1.0, 5.0);
    /// assert_eq!(hole.clone().named("hole 1").shape_key(), hole.clone().named("hole 2").shape_key());
    /// // The same points, but another tree.
    /// assert_ne!(hole.clone().at_z(0.0).shape_key(), hole.shape_key());
    /// ```
    pub fn shape_key(&self) -> Vec<u64> {
        let mut key = Vec::new();
        write(self, &mut key);
        key
    }
}

fn write(solid: &Solid, key: &mut Vec<u64>) {
    let mut numbers = |tag: u64, values: &[f64]| {
        key.push(tag);
        key.extend(values.iter().map(|v| v.to_bits()));
    };
    match solid {
        Solid::Sphere(s) => numbers(0, &[s.radius_mm]),
        Solid::Ellipsoid(s) => numbers(1, &s.semi_axes_mm),
        Solid::Cylinder(s) => numbers(2, &[s.radius_mm, s.height_mm]),
        Solid::Cone(s) => numbers(3, &[s.bottom_radius_mm, s.top_radius_mm, s.height_mm]),
        Solid::Cuboid(s) => numbers(4, &s.size_mm),
        Solid::Torus(s) => numbers(5, &[s.ring_radius_mm, s.tube_radius_mm]),
        Solid::HalfSpace(_) => numbers(6, &[]),
        Solid::Extrusion(s) => {
            numbers(7, &[s.height_mm]);
            write_profile(&s.profile, key);
        }
        Solid::Revolution(s) => {
            numbers(8, &[]);
            write_profile(&s.profile, key);
        }
        Solid::EllipsoidOffset(s) => numbers(9, &[s.equatorial_mm, s.polar_mm, s.offset_mm]),
        Solid::Union(of) => write_many(10, of.iter(), key),
        Solid::Intersection(of) => write_many(11, of.iter(), key),
        Solid::Difference { of, minus } => {
            write_many(12, std::iter::once(&**of).chain(minus), key);
        }
        Solid::Placed { pose, of } => {
            numbers(13, pose.rotation().as_slice());
            key.extend(pose.translation_mm().iter().map(|v| v.to_bits()));
            write(of, key);
        }
        Solid::Feature { of, .. } => write(of, key),
    }
}

fn write_many<'a>(tag: u64, solids: impl Iterator<Item = &'a Solid>, key: &mut Vec<u64>) {
    key.push(tag);
    // The count separates this node's children from what follows.
    let count_at = key.len();
    key.push(0);
    for solid in solids {
        write(solid, key);
        key[count_at] += 1;
    }
}

fn write_profile(profile: &Profile, key: &mut Vec<u64>) {
    key.push(1 + profile.holes.len() as u64);
    profile.paths().for_each(|path| write_path(path, key));
}

fn write_path(path: &Path, key: &mut Vec<u64>) {
    key.push(path.segments.len() as u64);
    key.extend(path.start.map(f64::to_bits));
    for segment in &path.segments {
        let (tag, centre, semi_axes_mm) = match segment {
            Segment::Line { .. } => (0, [0.0; 2], [0.0; 2]),
            Segment::Arc { centre, ccw, .. } => (1 + u64::from(*ccw), *centre, [0.0; 2]),
            Segment::EllipticArc { centre, semi_axes_mm, ccw, .. } => {
                (3 + u64::from(*ccw), *centre, *semi_axes_mm)
            }
        };
        key.push(tag);
        key.extend([segment.to(), centre, semi_axes_mm].as_flattened().iter().map(|v| v.to_bits()));
    }
}
