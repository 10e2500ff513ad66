//! Finite element with biquadratic displacements and a pressure that is linear within each element, discontinuous
//! between.
//!
//! The pair Q2-P1disc is stable for nearly incompressible materials (Boffi, Brezzi and Fortin, "Mixed finite element
//! methods and applications", 2013, section 8.6). Since pressures do not reach from element to element, each element
//! eliminates its own. The remaining system is symmetric and positive definite, and has the same solution as the whole
//! mixed system.

use nalgebra::{Matrix3, SMatrix};

use crate::ElasticMaterial;

/// Displacements of the nine nodes: radial, circumferential and axial each.
pub(crate) const UNKNOWNS: usize = 27;

/// Positions and weights of the four-point Gauss rule. It is exact to degree seven, which a linear displacement on a
/// curved element needs.
const GAUSS: [[f64; 2]; 4] = [
    [-0.861_136_311_594_052_6, 0.347_854_845_137_453_85],
    [-0.339_981_043_584_856_26, 0.652_145_154_862_546_1],
    [0.339_981_043_584_856_26, 0.652_145_154_862_546_1],
    [0.861_136_311_594_052_6, 0.347_854_845_137_453_85],
];

/// Positions and weights of the Gauss rule on -1 to 1.
pub(crate) fn gauss() -> &'static [[f64; 2]; 4] {
    &GAUSS
}

/// Values at `x` of the three quadratic functions on -1 to 1 that are 1 at -1, 0 and 1.
pub(crate) fn quadratic(x: f64) -> [f64; 3] {
    [0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)]
}

/// Derivatives of the functions of [`quadratic`].
pub(crate) fn quadratic_slope(x: f64) -> [f64; 3] {
    [x - 0.5, -2.0 * x, x + 0.5]
}

/// Shape functions and their derivatives at the Gauss points, in the element's reference coordinates.
pub(crate) struct Shape {
    points: Vec<ShapeAt>,
}

struct ShapeAt {
    value: [f64; 9],
    slope: [[f64; 2]; 9],
    weight: f64,
}

/// A Gauss point mapped to a real element.
pub(crate) struct Point {
    pub value: [f64; 9],
    /// Derivatives of the shape functions by radius and by height, 1/mm.
    pub slope: [[f64; 2]; 9],
    pub place: [f64; 2],
    /// Area in the meridian plane, mm2; negative where the element is folded.
    pub area: f64,
}

impl Shape {
    /// Evaluates the shape functions at the 4 x 4 Gauss points.
    pub fn new() -> Self {
        let mut points = Vec::with_capacity(16);
        for [x, weight_x] in GAUSS {
            for [y, weight_y] in GAUSS {
                // Rows run inwards, against the second coordinate, which keeps the Jacobian positive.
                let (along, across) = (quadratic(x), quadratic(-y));
                let (slope_along, slope_across) = (quadratic_slope(x), quadratic_slope(-y));
                points.push(ShapeAt {
                    value: std::array::from_fn(|i| along[i / 3] * across[i % 3]),
                    slope: std::array::from_fn(|i| {
                        [slope_along[i / 3] * across[i % 3], -along[i / 3] * slope_across[i % 3]]
                    }),
                    weight: weight_x * weight_y,
                });
            }
        }
        Self { points }
    }

    /// Maps the Gauss points to an element with nodes at these positions, mm.
    pub fn points<'a>(&'a self, places: &'a [[f64; 2]; 9]) -> impl Iterator<Item = Point> + 'a {
        self.points.iter().map(|at| {
            let sum = |by: &dyn Fn(usize) -> f64| (0..9).map(by).sum::<f64>();
            let jacobian: [[f64; 2]; 2] = std::array::from_fn(|i| {
                std::array::from_fn(|j| sum(&|node| at.slope[node][j] * places[node][i]))
            });
            let [[r_x, r_y], [z_x, z_y]] = jacobian;
            let determinant = r_x * z_y - r_y * z_x;
            let slope = at.slope.map(|[by_x, by_y]| {
                [(by_x * z_y - by_y * z_x) / determinant, (by_y * r_x - by_x * r_y) / determinant]
            });
            let place = std::array::from_fn(|i| sum(&|node| at.value[node] * places[node][i]));
            Point { value: at.value, slope, place, area: at.weight * determinant }
        })
    }

    /// Returns a Gauss point where the element's area is not positive or the radius is not, or `None` for a sound
    /// element.
    pub fn find_fold(&self, places: &[[f64; 2]; 9]) -> Option<[f64; 2]> {
        let is_good = |area: f64| area > 0.0 && area.is_finite();
        self.points(places)
            .find(|point| !is_good(point.area) || point.place[0] <= 0.0)
            .map(|p| p.place)
    }

    /// Computes the stiffness of an element for any harmonic of the azimuth, N/mm per radian.
    ///
    /// Displacements are `u_r = U cos m phi`, `u_phi = V sin m phi`, `u_z = W cos m phi`; the unknowns are U, V and W,
    /// node after node. Returns `None` for an element without area, whose pressures cannot be eliminated.
    pub fn stiffness(
        &self,
        places: &[[f64; 2]; 9],
        material: &ElasticMaterial,
    ) -> Option<StiffnessPolynomial> {
        let (shear, lame) = (material.shear_modulus_mpa(), material.lame_mpa());
        let (centre, scale) = centre(places);
        let mut parts = [Stiffness::zeros(); 3];
        let mut pressures = Matrix3::zeros();
        // Strains and volume changes are linear in m: index 0 is the constant part, index 1 the factor of m.
        let mut volumes = [SMatrix::<f64, 3, UNKNOWNS>::zeros(); 2];
        for point in self.points(places) {
            let [r, z] = point.place;
            let weight = point.area * r;
            // The three pressure modes, centred and scaled so that their mass matrix is well conditioned.
            let linear = [1.0, (r - centre[0]) / scale, (z - centre[1]) / scale];
            let mut strains = [SMatrix::<f64, 6, UNKNOWNS>::zeros(); 2];
            for node in 0..9 {
                // Rows: radial, circumferential and axial strain, then the shear strains rz, r-phi and phi-z.
                let (n, [n_r, n_z]) = (point.value[node], point.slope[node]);
                let [u, v, w] = [3 * node, 3 * node + 1, 3 * node + 2];
                let [even, by_m] = &mut strains;
                even[(0, u)] = n_r;
                even[(1, u)] = n / r;
                by_m[(1, v)] = n / r;
                even[(2, w)] = n_z;
                even[(3, u)] = n_z;
                even[(3, w)] = n_r;
                by_m[(4, u)] = -n / r;
                even[(4, v)] = n_r - n / r;
                even[(5, v)] = n_z;
                by_m[(5, w)] = -n / r;
            }
            for (volumes, strains) in volumes.iter_mut().zip(&strains) {
                for i in 0..UNKNOWNS {
                    let divergence = strains[(0, i)] + strains[(1, i)] + strains[(2, i)];
                    for (k, value) in linear.iter().enumerate() {
                        volumes[(k, i)] += weight * value * divergence;
                    }
                }
            }
            for i in 0..3 {
                for j in 0..3 {
                    pressures[(i, j)] += weight * linear[i] * linear[j];
                }
            }
            let mut weighted = strains;
            for strains in &mut weighted {
                // Normal strains weigh 2 G, engineering shear strains G.
                for (row, factor) in [2.0, 2.0, 2.0, 1.0, 1.0, 1.0].into_iter().enumerate() {
                    strains.row_mut(row).scale_mut(factor * shear * weight);
                }
            }
            add_products(&mut parts, 1.0, &strains, &weighted);
        }
        // Eliminates the pressures: divergence^T M^-1 divergence, times Lame's first constant.
        let inverse = pressures.try_inverse()?;
        add_products(&mut parts, lame, &volumes, &volumes.map(|volumes| inverse * volumes));
        Some(StiffnessPolynomial(parts))
    }

    /// Computes the change of the element's volume by each unknown of harmonic 0, mm2 per radian.
    pub fn dilation(&self, places: &[[f64; 2]; 9]) -> [f64; UNKNOWNS] {
        let mut dilation = [0.0; UNKNOWNS];
        for point in self.points(places) {
            let weight = point.area * point.place[0];
            for node in 0..9 {
                dilation[3 * node] +=
                    weight * (point.slope[node][0] + point.value[node] / point.place[0]);
                dilation[3 * node + 2] += weight * point.slope[node][1];
            }
        }
        dilation
    }
}

/// Symmetric stiffness matrix over an element's unknowns.
pub(crate) type Stiffness = SMatrix<f64, UNKNOWNS, UNKNOWNS>;

/// A stiffness that is quadratic in the harmonic m: the constant part and the factors of m and of m squared.
pub(crate) struct StiffnessPolynomial([Stiffness; 3]);

impl StiffnessPolynomial {
    /// Evaluates the stiffness for one harmonic.
    pub fn evaluate(&self, harmonic: usize) -> Stiffness {
        let m = harmonic as f64;
        let [even, by_m, by_square] = &self.0;
        even + m * (by_m + m * by_square)
    }
}

/// Adds `factor (A + m B)^T (C + m D)` to the parts, sorted by powers of m.
fn add_products<const ROWS: usize>(
    parts: &mut [Stiffness; 3],
    factor: f64,
    [a, b]: &[SMatrix<f64, ROWS, UNKNOWNS>; 2],
    [c, d]: &[SMatrix<f64, ROWS, UNKNOWNS>; 2],
) {
    for (power, left, right) in [(0, a, c), (1, a, d), (1, b, c), (2, b, d)] {
        parts[power].gemm_tr(factor, left, right, 1.0);
    }
}

/// Returns the middle node of an element and the largest distance of its nodes from there, mm.
pub(crate) fn centre(places: &[[f64; 2]; 9]) -> ([f64; 2], f64) {
    let middle = places[4];
    let far = |place: &[f64; 2]| (place[0] - middle[0]).hypot(place[1] - middle[1]);
    (middle, places.iter().map(far).fold(0.0, f64::max))
}
