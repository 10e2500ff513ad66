//! Distances from the exact surfaces of primitives, in closed form if there is one. No code is shared with the
//! tessellator.

use fabkit_geometry::{Path, Profile, Segment, Solid};

/// Computes the distance of a point from one face of a primitive, extended beyond its edges, mm.
pub fn distance_mm(primitive: &Solid, face: u32, [x, y, z]: [f64; 3]) -> f64 {
    let across = x.hypot(y);
    let distance = match primitive {
        Solid::Sphere(s) => across.hypot(z) - s.radius_mm,
        Solid::Ellipsoid(s) => along_gradient(s.semi_axes_mm, [x, y, z]),
        Solid::Cylinder(s) => [across - s.radius_mm, z, z - s.height_mm][face as usize],
        Solid::Cone(s) => {
            let slope = (s.top_radius_mm - s.bottom_radius_mm) / s.height_mm;
            let side = (across - s.bottom_radius_mm - slope * z) / slope.hypot(1.0);
            [side, z, z - s.height_mm][face as usize]
        }
        Solid::Cuboid(s) => {
            let [a, b, c] = s.size_mm;
            [x + a / 2.0, x - a / 2.0, y + b / 2.0, y - b / 2.0, z, z - c][face as usize]
        }
        Solid::Torus(s) => (across - s.ring_radius_mm).hypot(z) - s.tube_radius_mm,
        Solid::Extrusion(s) => match face {
            0 => z,
            1 => z - s.height_mm,
            wall => from_segment(&s.profile, wall - 2, [x, y]),
        },
        Solid::Revolution(s) => from_segment(&s.profile, face, [across, z]),
        Solid::EllipsoidOffset(s) => {
            let semi_axes = [s.equatorial_mm, s.polar_mm];
            let inside = (across / semi_axes[0]).hypot(z / semi_axes[1]) < 1.0;
            let distance = from_ellipse(semi_axes, [across, z]);
            (if inside { -distance } else { distance }) - s.offset_mm
        }
        other => panic!("{other:?} is no bounded primitive"),
    };
    distance.abs()
}

fn from_segment(profile: &Profile, number: u32, point: [f64; 2]) -> f64 {
    let starts = profile.paths().flat_map(|path: &Path| {
        let ends = path.segments.iter().map(Segment::to);
        std::iter::once(path.start).chain(ends).zip(&path.segments)
    });
    let (from, segment) = starts.into_iter().nth(number as usize).expect("a face of the profile");
    let relative = |centre: &[f64; 2]| [point[0] - centre[0], point[1] - centre[1]];
    match segment {
        Segment::Line { to } => {
            let (d, p) = ([to[0] - from[0], to[1] - from[1]], relative(&from));
            (d[0] * p[1] - d[1] * p[0]) / d[0].hypot(d[1])
        }
        Segment::Arc { to, centre, .. } => {
            let [x, y] = relative(centre);
            x.hypot(y) - (to[0] - centre[0]).hypot(to[1] - centre[1])
        }
        Segment::EllipticArc { centre, semi_axes_mm, .. } => {
            from_ellipse(*semi_axes_mm, relative(centre))
        }
    }
}

/// Computes the distance from an ellipse about the origin by nested sampling of its parameter in the point's quadrant.
fn from_ellipse([a, b]: [f64; 2], point: [f64; 2]) -> f64 {
    let [x, y] = point.map(f64::abs);
    let distance = |t: f64| (a * t.cos() - x).hypot(b * t.sin() - y);
    let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
    for _ in 0..14 {
        let step = (high - low) / 12.0;
        let at = |i: i32| low + f64::from(i) * step;
        let nearest = (0..=12).min_by(|&i, &j| distance(at(i)).total_cmp(&distance(at(j))));
        let centre = at(nearest.unwrap_or(0));
        (low, high) = (f64::max(low, centre - step), f64::min(high, centre + step));
    }
    distance((low + high) / 2.0)
}

/// Computes the distance to an ellipsoid along the gradient: never less than the true distance, and equal to it except
/// for terms of third order.
fn along_gradient(semi_axes: [f64; 3], point: [f64; 3]) -> f64 {
    let gradient: [f64; 3] = std::array::from_fn(|i| point[i] / semi_axes[i].powi(2));
    let length = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
    // |p + t g|^2 = 1 in the scaled space: a quadratic equation in t.
    let sum = |f: &dyn Fn(usize) -> f64| (0..3).map(f).sum::<f64>();
    let square = |v: f64| v * v;
    let a = sum(&|i| square(gradient[i] / length / semi_axes[i]));
    let half_b = sum(&|i| gradient[i] / length * point[i] / square(semi_axes[i]));
    let c = sum(&|i| square(point[i] / semi_axes[i])) - 1.0;
    -c / (half_b + (half_b * half_b - a * c).max(0.0).sqrt())
}
