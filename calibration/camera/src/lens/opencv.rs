//! Pinhole with OpenCV's distortion.

use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};

use super::{Intrinsics, LensModel, MAX_COEFFICIENTS, Normalised, Projector, check, check_limit};
use crate::error::InvalidCamera;
use crate::roots::{find_increasing_root, first_zero};

const NAMES: [&str; 8] = ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"];

/// Largest `tan(theta)` for which the domain is examined (89.994 degrees). A pixel beyond would be thousands of image
/// widths away.
const LARGEST_TANGENT: f64 = 1e4;

/// Pinhole with tangential distortion and radial distortion, polynomial (5 terms) or rational (8 terms).
///
/// The model of OpenCV's `calib3d` (`plumb_bob` and `rational_polynomial` in ROS), after Brown,
/// "Decentering Distortion of Lenses", 1966. With `u = x^2 + y^2` of the pinhole point `(x, y)`,
/// `s = (1 + k1 u + k2 u^2 + k3 u^3) / (1 + k4 u + k5 u^2 + k6 u^3)` and `p = (p2, p1)` the
/// distorted point is `s (x, y) + u p + 2 ((x, y) . p) (x, y)`.
///
/// # Domain
/// Far from the axis the distorted image folds back, and one pixel belongs to several directions. The derivative of the
/// distortion is a symmetric matrix. Where it is positive definite on a disc, the distortion is the gradient of a
/// strictly convex function and cannot fold. The domain is the largest such disc, for the worst azimuth of the
/// tangential terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenCv {
    pub(super) intrinsics: Intrinsics,
    k: [f64; 8],
    /// Number of coefficients, 5 or 8.
    terms: usize,
    limit_rad: f64,
    limit_tangent: f64,
    /// Distorted radius at the limit, without tangential terms; infinite at a pole.
    limit_radius: f64,
}

/// Distorted point with its derivative.
struct Distorted {
    at: Vector2<f64>,
    by_point: Matrix2<f64>,
}

impl OpenCv {
    /// Creates a lens with OpenCV's coefficients `k1 k2 p1 p2 k3 k4 k5 k6`.
    ///
    /// With 0, 4 or 5 numbers it is the polynomial model of five terms, with 8 the rational model.
    ///
    /// # Errors
    /// Fails for another number of coefficients, and for values that are not finite or absurd, naming each.
    ///
    /// ```
    /// use fabkit_camera::{Intrinsics, Lens, OpenCv};
    /// let intrinsics = Intrinsics { fx_px: 500.0, fy_px: 500.0, cx_px: 319.5, cy_px: 239.5 };
    /// let four = Lens::OpenCv(OpenCv::new(intrinsics, &[-0.2, 0.05, 1e-3, 2e-4])?);
    /// assert_eq!(four.coefficients(), [-0.2, 0.05, 1e-3, 2e-4, 0.0]);
    /// assert_eq!(four.coefficient_names(), ["k1", "k2", "p1", "p2", "k3"]);
    /// assert!(OpenCv::new(intrinsics, &[-0.2, 0.05]).is_err());
    /// # Ok::<(), fabkit_camera::InvalidCamera>(())
    /// ```
    pub fn new(intrinsics: Intrinsics, coefficients: &[f64]) -> Result<Self, InvalidCamera> {
        let count = coefficients.len();
        let mut rules = check(&intrinsics, &NAMES, coefficients);
        rules.require(
            matches!(count, 0 | 4 | 5 | 8),
            "number of distortion coefficients",
            count as f64,
            "must be 0, 4, 5 or 8",
        );
        rules.finish()?;
        let mut k = [0.0; 8];
        k[..count].copy_from_slice(coefficients);
        // Missing coefficients are zero: four numbers are five with k3 = 0.
        let terms = if count == 8 { 8 } else { 5 };
        let (limit_tangent, is_pole) = limit_tangent(&k);
        let limit_rad = limit_tangent.atan();
        check_limit((NAMES[0], k[0]), limit_rad)?;
        let limit_radius = f64::INFINITY;
        let mut lens = Self { intrinsics, k, terms, limit_rad, limit_tangent, limit_radius };
        if !is_pole {
            lens.limit_radius = limit_tangent * lens.radial_factor(limit_tangent * limit_tangent).0;
        }
        Ok(lens)
    }

    /// Computes the radial factor `s` and its derivative by `u`.
    fn radial_factor(&self, u: f64) -> (f64, f64) {
        let [k1, k2, _, _, k3, k4, k5, k6] = self.k;
        let numerator = 1.0 + u * (k1 + u * (k2 + u * k3));
        let by_u = k1 + u * (2.0 * k2 + u * 3.0 * k3);
        if self.terms == 5 {
            return (numerator, by_u);
        }
        let denominator = 1.0 + u * (k4 + u * (k5 + u * k6));
        let stretch = numerator / denominator;
        (stretch, (by_u - stretch * (k4 + u * (2.0 * k5 + u * 3.0 * k6))) / denominator)
    }

    fn tangential(&self) -> Vector2<f64> {
        Vector2::new(self.k[3], self.k[2])
    }

    /// Computes the distorted point of a pinhole point, with its derivative.
    fn distort(&self, point: &Vector2<f64>) -> Distorted {
        let u = point.norm_squared();
        let (s, s_by_u) = self.radial_factor(u);
        let p = self.tangential();
        let twice = 2.0 * point.dot(&p);
        let outer = point * p.transpose();
        Distorted {
            at: point * (s + twice) + p * u,
            by_point: Matrix2::identity() * (s + twice)
                + point * point.transpose() * (2.0 * s_by_u)
                + (outer + outer.transpose()) * 2.0,
        }
    }

    /// Finds the point of the domain's disc that is distorted to `target`.
    fn undistort(&self, target: &Vector2<f64>) -> Option<Vector2<f64>> {
        let radius = target.norm();
        if radius == 0.0 {
            return Some(Vector2::zeros());
        }
        let excess = |r: f64| {
            let (s, s_by_u) = self.radial_factor(r * r);
            (r * s - radius, s + 2.0 * r * r * s_by_u)
        };
        let within = radius <= self.limit_radius;
        // Tangential terms shift a point at radius r by at most 3 P r^2.
        let margin = 3.0 * self.tangential().norm() * self.limit_tangent * self.limit_tangent;
        if radius > self.limit_radius + margin {
            return None;
        }
        // The limit itself may be a pole: start anywhere but there.
        let start = if radius < self.limit_tangent { radius } else { 0.5 * self.limit_tangent };
        // The radial part alone gives a start for the tangential terms.
        let r = if within {
            find_increasing_root(excess, 0.0, self.limit_tangent, start)
        } else {
            self.limit_tangent
        };
        let point = target * (r / radius);
        if margin == 0.0 {
            return Some(point);
        }
        self.descend(point, target)
    }

    /// Refines a nearby point by Newton's method within the disc: two or three steps for real lenses.
    ///
    /// A step is halved until the distorted point comes closer to its target, because near a fold or a pole a full step
    /// may not.
    fn descend(&self, start: Vector2<f64>, target: &Vector2<f64>) -> Option<Vector2<f64>> {
        let mut point = start;
        let mut here = self.distort(&point);
        let mut miss = target - here.at;
        let mut step = Vector2::zeros();
        for _ in 0..60 {
            step = here.by_point.try_inverse()? * miss;
            // A few units in the last place: closer is not possible.
            if step.norm() <= 4e-16 * point.norm() {
                return Some(point);
            }
            let closer = (0..30).find_map(|halvings| {
                let mut next = point + step * 0.5f64.powi(halvings);
                let beyond = next.norm() / self.limit_tangent;
                // Beyond the disc the distortion folds: steps end on its rim.
                if beyond > 1.0 {
                    next /= beyond;
                }
                let there = self.distort(&next);
                let left = target - there.at;
                (left.norm_squared() < miss.norm_squared()).then_some((next, there, left))
            });
            match closer {
                Some(found) => (point, here, miss) = found,
                None => break,
            }
        }
        // Either converged as far as rounding allows, or, for a pixel outside the image, stuck on the rim.
        let close = step.norm() <= 1e-12 * (1.0 + point.norm());
        (close || miss.norm() <= 1e-13 * (1.0 + target.norm())).then_some(point)
    }
}

/// Computes the largest `tan(theta)` up to which the distortion's derivative is positive definite at every azimuth, and
/// whether the rational function has a pole there.
///
/// With `N / D = s`, `P = |p|` and `c` the cosine between the point and `p`, the derivative at radius `r` is a 2 x 2
/// matrix in radial and tangential direction: `(r s)' + 6 r P c` and `s + 2 r P c` on the diagonal, `2 r P sqrt(1 -
/// c^2)` off it. Its determinant is a parabola in `c`. If `s > 10/3 r P` and `(r s)' > 6 r P`, the parabola's vertex
/// lies below `c = -1`, where the determinant is `((r s)' - 6 r P) (s - 2 r P) > 0`. For tangential terms of real
/// lenses the second condition fails first, so that it is exact.
fn limit_tangent(k: &[f64; 8]) -> (f64, bool) {
    let [k1, k2, p1, p2, k3, k4, k5, k6] = *k;
    let tangential = p1.hypot(p2);
    let numerator = Polynomial::even([1.0, k1, k2, k3]);
    let denominator = Polynomial::even([1.0, k4, k5, k6]);
    // Both conditions, multiplied by powers of D to make them polynomials in r.
    let slope = numerator
        .times_x()
        .derivative()
        .times(&denominator)
        .minus(&numerator.times_x().times(&denominator.derivative()))
        .minus(&denominator.times(&denominator).times_x().scaled(6.0 * tangential));
    let across = numerator.minus(&denominator.times_x().scaled(10.0 / 3.0 * tangential));
    let first = |polynomial: &Polynomial| first_zero(&polynomial.0, LARGEST_TANGENT);
    let pole = first(&denominator).unwrap_or(f64::INFINITY);
    let fold = [slope, across].iter().filter_map(first).fold(LARGEST_TANGENT, f64::min);
    (fold.min(pole), pole <= fold)
}

/// Polynomial; `self.0[i]` belongs to `x^i`.
struct Polynomial(Vec<f64>);

impl Polynomial {
    /// Creates an even polynomial from the coefficients of `x^0, x^2, x^4, x^6`.
    fn even(coefficients: [f64; 4]) -> Self {
        let [a, b, c, d] = coefficients;
        Self(vec![a, 0.0, b, 0.0, c, 0.0, d])
    }

    fn times_x(&self) -> Self {
        Self([&[0.0], &self.0[..]].concat())
    }

    fn scaled(self, factor: f64) -> Self {
        Self(self.0.into_iter().map(|c| c * factor).collect())
    }

    fn derivative(&self) -> Self {
        Self(self.0.iter().enumerate().skip(1).map(|(i, c)| i as f64 * c).collect())
    }

    /// Multiplies two polynomials.
    fn times(&self, other: &Self) -> Self {
        let mut product = vec![0.0; self.0.len() + other.0.len() - 1];
        for (i, a) in self.0.iter().enumerate() {
            for (j, b) in other.0.iter().enumerate() {
                product[i + j] += a * b;
            }
        }
        Self(product)
    }

    fn minus(mut self, other: &Self) -> Self {
        self.0.resize(self.0.len().max(other.0.len()), 0.0);
        self.0.iter_mut().zip(&other.0).for_each(|(a, b)| *a -= b);
        self
    }
}

#[allow(non_upper_case_globals, reason = "models are told apart as kinds are")]
impl LensModel {
    /// OpenCV's polynomial model, `k1 k2 p1 p2 k3`.
    pub const OpenCv5: Self = Self {
        name: "opencv-5",
        family: OpenCv::NAME,
        coefficients: NAMES.split_at(5).0,
        start_coefficients: &[0.0; 5],
    };

    /// OpenCV's rational model, `k1 k2 p1 p2 k3 k4 k5 k6`.
    pub const OpenCv8: Self = Self {
        name: "opencv-8",
        family: OpenCv::NAME,
        coefficients: &NAMES,
        start_coefficients: &[0.0; 8],
    };
}

impl Projector for OpenCv {
    const NAME: &'static str = "opencv";

    fn from_coefficients(
        intrinsics: Intrinsics,
        coefficients: &[f64],
    ) -> Result<Self, InvalidCamera> {
        Self::new(intrinsics, coefficients)
    }

    fn names(&self) -> &'static [&'static str] {
        &NAMES[..self.terms]
    }

    fn coefficients(&self) -> &[f64] {
        &self.k[..self.terms]
    }

    fn limit_rad(&self) -> f64 {
        self.limit_rad
    }

    fn contains(&self, direction: &Vector3<f64>) -> bool {
        direction.z > 0.0 && direction.xy().norm() <= self.limit_tangent * direction.z
    }

    fn normalise(&self, direction: &Vector3<f64>) -> Vector2<f64> {
        let point = direction.xy() / direction.z;
        let u = point.norm_squared();
        let p = self.tangential();
        point * (self.radial_factor(u).0 + 2.0 * point.dot(&p)) + p * u
    }

    fn differentiate(&self, direction: &Vector3<f64>) -> Normalised {
        let point = direction.xy() / direction.z;
        let Distorted { at, by_point } = self.distort(&point);
        let pinhole_by_direction =
            Matrix2x3::new(1.0, 0.0, -point.x, 0.0, 1.0, -point.y) / direction.z;

        let u = point.norm_squared();
        let [.., k4, k5, k6] = self.k;
        let denominator = 1.0 + u * (k4 + u * (k5 + u * k6));
        // Derivatives of the radial factor: those of the numerator, then those of the denominator.
        let by_k = point / denominator;
        let by_denominator = -by_k * self.radial_factor(u).0;
        let twice_xy = 2.0 * point.x * point.y;
        let by_coefficients: [Vector2<f64>; MAX_COEFFICIENTS] = [
            by_k * u,
            by_k * (u * u),
            Vector2::new(twice_xy, u + 2.0 * point.y * point.y),
            Vector2::new(u + 2.0 * point.x * point.x, twice_xy),
            by_k * (u * u * u),
            by_denominator * u,
            by_denominator * (u * u),
            by_denominator * (u * u * u),
        ];
        Normalised { at, by_direction: by_point * pinhole_by_direction, by_coefficients }
    }

    fn direction(&self, normalised: &Vector2<f64>) -> Option<Vector3<f64>> {
        let point = self.undistort(normalised)?;
        Some(Vector3::new(point.x, point.y, 1.0))
    }
}
