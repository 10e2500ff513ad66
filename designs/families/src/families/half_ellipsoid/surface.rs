//! The half ellipsoid, its parallel surfaces, and the inside of the shell.
//!
//! An ellipse of half axes a (across) and c (along z) has, at the eccentric angle t from its tip, the
//! point (a sin t, c cos t) and the outward normal along (sin t / a, cos t / c).

use std::f64::consts::{FRAC_PI_2, PI};

use fabkit_geometry::{CUT_OVERLAP_MM, EllipsoidOffset, Path, Solid};

/// Biarcs along the shell's inside: with these, its distance from the parallel surface stays below
/// 0.1 um for every ellipsoid up to 1 : 4.
const BIARCS: u32 = 32;

/// The ellipsoid from which all layers are offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Half axis across, mm.
    pub equatorial: f64,
    /// Half axis along z, mm; longer.
    pub polar: f64,
}

impl Ellipsoid {
    /// The smallest radius of curvature, mm, at the tip: no smooth parallel surface lies deeper.
    pub fn tip_curvature_radius(&self) -> f64 {
        self.equatorial.powi(2) / self.polar
    }

    /// The surface at `offset` mm outside.
    pub fn parallel(&self, offset: f64) -> EllipsoidOffset {
        EllipsoidOffset { equatorial_mm: self.equatorial, polar_mm: self.polar, offset_mm: offset }
    }

    /// Everything within that surface, below the base circle too.
    pub fn whole(&self, offset: f64) -> Solid {
        Solid::EllipsoidOffset(self.parallel(offset))
    }

    /// A dome within that surface that goes on below the base circle by the overlap of cuts.
    pub fn dome_tool(&self, offset: f64) -> Solid {
        self.whole(offset).minus(Solid::below(-CUT_OVERLAP_MM))
    }

    /// Point and unit normal of the meridian at an eccentric angle, as (radius, z).
    fn meridian(&self, eccentric: f64) -> ([f64; 2], [f64; 2]) {
        let (s, c) = eccentric.sin_cos();
        let normal = [s / self.equatorial, c / self.polar];
        let length = normal[0].hypot(normal[1]);
        ([self.equatorial * s, self.polar * c], normal.map(|v| v / length))
    }

    /// Where the surface at `depth` mm inside meets the axis, as an eccentric angle; 0 where it is
    /// smooth there.
    ///
    /// The normal from angle t meets the axis after a^2 |(sin t / a, cos t / c)|.
    fn fold(&self, depth: f64) -> f64 {
        let (a, c) = (self.equatorial, self.polar);
        let square = ((depth / a.powi(2)).powi(2) - c.powi(-2)) / (a.powi(-2) - c.powi(-2));
        square.clamp(0.0, 1.0).sqrt().asin()
    }

    /// Height of the tip of a cavity `depth` mm inside with a tip no sharper than `tip_radius`, mm.
    pub fn cavity_tip_z(&self, depth: f64, tip_radius: f64) -> f64 {
        let fold = self.fold(depth + tip_radius);
        if fold == 0.0 {
            return self.polar - depth;
        }
        self.ball_centre_z(depth + tip_radius) + tip_radius
    }

    /// Height of the highest ball of `radius` mm that touches the ellipsoid from inside, for radii
    /// beyond the tip's radius of curvature.
    fn ball_centre_z(&self, radius: f64) -> f64 {
        self.fold(radius).cos() * (self.polar - self.tip_curvature_radius())
    }

    /// What a ball mill of `tip_radius` mm leaves free when it stays `depth` mm away from the
    /// ellipsoid, with a bore down to `bottom_z`: the parallel surface, rounded at the tip, where it
    /// would fold because it lies deeper than the tip's radius of curvature.
    ///
    /// The parallel surface is made of circular arcs that share its normals at 65 places (biarcs:
    /// Bolton, "Biarc curves", Computer-Aided Design 7, 1975).
    pub fn cavity(&self, depth: f64, tip_radius: f64, bottom_z: f64) -> Solid {
        let fold = self.fold(depth + tip_radius);
        let node = |i: u32| {
            let eccentric = FRAC_PI_2 + (fold - FRAC_PI_2) * f64::from(i) / f64::from(BIARCS);
            let (point, normal) = self.meridian(eccentric);
            ([point[0] - depth * normal[0], point[1] - depth * normal[1]], normal)
        };
        let bore = self.equatorial - depth;
        let mut path = Path::from([0.0, bottom_z]).line([bore, bottom_z]).line([bore, 0.0]);
        // Exactly on the base circle, where rounding would leave 1e-16.
        let (mut from, mut from_normal) = ([bore, 0.0], [1.0, 0.0]);
        for i in 1..=BIARCS {
            let (mut to, to_normal) = node(i);
            if i == BIARCS && fold == 0.0 {
                to[0] = 0.0;
            }
            let [first, joint, second] = biarc(from, from_normal, to, to_normal);
            path = path.arc(joint, first, true).arc(to, second, true);
            (from, from_normal) = (to, to_normal);
        }
        if fold > 0.0 {
            let centre_z = self.ball_centre_z(depth + tip_radius);
            path = path.arc([0.0, centre_z + tip_radius], [0.0, centre_z], true);
        }
        Solid::revolution(path.close())
    }

    /// Area above the base circle of the surface at `offset`, mm2, to about a thousandth: for
    /// choosing, not for measuring.
    pub fn area_estimate(&self, offset: f64) -> f64 {
        const STEPS: u32 = 100;
        let point = |i: u32| {
            let (p, n) = self.meridian(FRAC_PI_2 * f64::from(i) / f64::from(STEPS));
            [p[0] + offset * n[0], p[1] + offset * n[1]]
        };
        let band = |i: u32| {
            let ([r, z], [s, w]) = (point(i), point(i + 1));
            PI * (r + s) * (r - s).hypot(z - w)
        };
        (0..STEPS).map(band).sum()
    }

    /// Length of the meridian from the tip to the base circle on the surface at `offset`, mm: the
    /// ellipse's own, and the offset times the quarter turn of the normal (Steiner).
    pub fn meridian_length(&self, offset: f64) -> f64 {
        // The trapezoidal rule converges geometrically on a quarter of a period.
        const PANELS: u32 = 256;
        let speed = |i: u32| {
            let (s, c) = (FRAC_PI_2 * f64::from(i) / f64::from(PANELS)).sin_cos();
            (self.equatorial * c).hypot(self.polar * s)
        };
        let ends = (speed(0) + speed(PANELS)) / 2.0;
        let sum = ends + (1..PANELS).map(speed).sum::<f64>();
        FRAC_PI_2 * (sum / f64::from(PANELS) + offset)
    }
}

/// Two arcs from one point to another with given normals: first centre, joint, second centre. At the
/// joint both have the normal half way between.
fn biarc(p: [f64; 2], n: [f64; 2], q: [f64; 2], m: [f64; 2]) -> [[f64; 2]; 3] {
    let middle = [n[0] + m[0], n[1] + m[1]];
    let length = middle[0].hypot(middle[1]);
    let middle = middle.map(|v| v / length);
    // p + r (middle - n) + s (m - middle) = q, for the radii r and s.
    let (u, v) = ([middle[0] - n[0], middle[1] - n[1]], [m[0] - middle[0], m[1] - middle[1]]);
    let d = [q[0] - p[0], q[1] - p[1]];
    let cross = |x: [f64; 2], y: [f64; 2]| x[0] * y[1] - x[1] * y[0];
    let r = cross(d, v) / cross(u, v);
    let s = cross(u, d) / cross(u, v);
    let first = [p[0] - r * n[0], p[1] - r * n[1]];
    let joint = [first[0] + r * middle[0], first[1] + r * middle[1]];
    [first, joint, [q[0] - s * m[0], q[1] - s * m[1]]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use fabkit_geometry::{CompiledSolid, Point3, Ray, Vector3};

    const UVDTACT: Ellipsoid = Ellipsoid { equatorial: 9.0, polar: 24.0 };

    #[test]
    fn the_cavity_is_parallel_to_a_tenth_of_a_micrometre_below_its_rounded_tip() {
        for (ellipsoid, depth, tip_radius) in [
            (UVDTACT, 4.4, 1.5),
            (UVDTACT, 4.0, 0.5),
            (Ellipsoid { equatorial: 10.0, polar: 40.0 }, 4.4, 1.5),
            (Ellipsoid { equatorial: 20.0, polar: 24.0 }, 3.0, 1.5),
        ] {
            let body = CompiledSolid::new(&ellipsoid.cavity(depth, tip_radius, -3.0)).unwrap();
            let fold = ellipsoid.fold(depth + tip_radius);
            for i in 0..500 {
                let eccentric = fold + (FRAC_PI_2 - fold) * (f64::from(i) + 0.5) / 500.0;
                let (point, normal) = ellipsoid.meridian(eccentric);
                // From the ellipsoid inwards along its own normal, in an odd half plane.
                let (s, c) = 0.3f64.sin_cos();
                let at = |v: [f64; 2]| Vector3::new(v[0] * c, v[0] * s, v[1]);
                let ray = Ray { origin: Point3::from(at(point)), direction: -at(normal) };
                let thickness = body.crossings(&ray)[0].t;
                assert!((thickness - depth).abs() < 1e-4, "{ellipsoid:?} {eccentric}: {thickness}");
            }
            // The tip: as far as it says, and nowhere nearer to the ellipsoid than the depth.
            let down = Ray { origin: Point3::new(0.0, 0.0, 99.0), direction: -Vector3::z() };
            let tip_z = 99.0 - body.crossings(&down)[0].t;
            assert!((tip_z - ellipsoid.cavity_tip_z(depth, tip_radius)).abs() < 1e-6);
            assert!(tip_z <= ellipsoid.polar - depth + 1e-9);
        }
    }

    #[test]
    fn the_meridian_of_a_near_sphere_is_a_quarter_circle() {
        let sphere = Ellipsoid { equatorial: 10.0, polar: 10.0 };
        assert!((sphere.meridian_length(-2.0) - FRAC_PI_2 * 8.0).abs() < 1e-12);
        // Ramanujan's second formula, good to 1e-7 here.
        let h = ((24.0 - 9.0f64) / (24.0 + 9.0)).powi(2);
        let perimeter = PI * 33.0 * (1.0 + 3.0 * h / (10.0 + (4.0 - 3.0 * h).sqrt()));
        assert!((UVDTACT.meridian_length(0.0) - perimeter / 4.0).abs() < 1e-4);
    }
}
