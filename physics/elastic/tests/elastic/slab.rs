//! Slabs against plate theory, and air columns against the gas law.

use fabkit_elastic::{BrickContents, ElasticError, ElasticMaterial, Slab};
use fabkit_geometry::Point3;

/// Grid lines from -half to half, and from 0 to a thickness.
fn lines(half_mm: [f64; 2], thickness_mm: f64, counts: [usize; 3]) -> [Vec<f64>; 3] {
    let even = |from: f64, to: f64, count: usize| {
        (0..=count).map(|i| from + (to - from) * i as f64 / count as f64).collect()
    };
    [
        even(-half_mm[0], half_mm[0], counts[0]),
        even(-half_mm[1], half_mm[1], counts[1]),
        even(0.0, thickness_mm, counts[2]),
    ]
}

/// Deflection in the middle of a clamped plate under uniform pressure, mm; `is_in` tells which bricks belong to the
/// plate.
fn middle_mm(
    lines_mm: [Vec<f64>; 3],
    material: ElasticMaterial,
    pressure_mpa: f64,
    is_in: impl Fn(f64, f64) -> bool,
) -> Result<f64, ElasticError> {
    let middle = |line: &[f64], i: usize| (line[i] + line[i + 1]) / 2.0;
    let [xs, ys, zs] = lines_mm.clone();
    let cell = |[i, j, _]: [usize; 3]| BrickContents {
        solid: is_in(middle(&xs, i), middle(&ys, j)).then_some((material, 1.0)),
        cavities: Vec::new(),
    };
    // A node is fixed where one of the bricks beside it is missing.
    let step = [xs[1] - xs[0], ys[1] - ys[0]];
    let held = |place: Point3<f64>| {
        [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].iter().any(|[x, y]| {
            let (x, y) = (place.x + x * step[0] / 2.0, place.y + y * step[1] / 2.0);
            x.abs() > -xs[0] || y.abs() > -ys[0] || !is_in(x, y)
        })
    };
    let slab = Slab::new(lines_mm, 0, cell, held)?;
    let mut forces = Vec::new();
    for j in 0..ys.len() - 1 {
        for i in 0..xs.len() - 1 {
            if is_in(middle(&xs, i), middle(&ys, j)) {
                for [a, b] in [[0, 0], [1, 0], [0, 1], [1, 1]] {
                    let node = slab.node([i + a, j + b, zs.len() - 1]);
                    forces.push((node, -pressure_mpa * step[0] * step[1] / 4.0));
                }
            }
        }
    }
    let field = slab.solve(&forces, &[]);
    let node = slab.node([xs.len() / 2, ys.len() / 2, zs.len() / 2]);
    Ok(-slab.displacement_mm(&field, node).z)
}

/// Flexural rigidity, N mm.
fn rigidity(material: &ElasticMaterial, thickness_mm: f64) -> f64 {
    let nu = material.poisson();
    material.young_mpa() * thickness_mm.powi(3) / (12.0 * (1.0 - nu * nu))
}

/// Contribution of shear to the deflection in the middle of a circle, mm (Timoshenko and Woinowsky-Krieger, Theory of
/// Plates and Shells, 1959, article 20; shear factor 5/6).
fn sheared_mm(
    material: &ElasticMaterial,
    thickness_mm: f64,
    pressure_mpa: f64,
    radius_mm: f64,
) -> f64 {
    pressure_mpa * radius_mm.powi(2)
        / (4.0 * 5.0 / 6.0 * material.shear_modulus_mpa() * thickness_mm)
}

#[test]
fn a_clamped_circle_bends_as_timoshenko_says() {
    let (material, thickness, radius, pressure) =
        (ElasticMaterial::new(1.0, 0.3).unwrap(), 3.0, 30.0, 1e-6);
    let lines = lines([radius; 2], thickness, [60, 60, 4]);
    let found = middle_mm(lines, material, pressure, |x, y| x.hypot(y) < radius).unwrap();
    // q a^4 / 64 D, article 17.
    let bent = pressure * radius.powi(4) / (64.0 * rigidity(&material, thickness));
    let exact = bent + sheared_mm(&material, thickness, pressure, radius);
    // The circle is approximated by steps of 1 mm.
    assert!((found / exact - 1.0).abs() < 0.04, "{found} {exact}");
}

#[test]
fn a_clamped_square_bends_as_timoshenko_says() {
    let (material, thickness, side, pressure) =
        (ElasticMaterial::new(1.0, 0.3).unwrap(), 3.0, 60.0, 1e-6);
    let lines = lines([side / 2.0; 2], thickness, [60, 60, 4]);
    let found = middle_mm(lines, material, pressure, |_, _| true).unwrap();
    // Table 35: 0.00126 q a^4 / D, with about the shear contribution of the inscribed circle.
    let bent = 0.00126 * pressure * side.powi(4) / rigidity(&material, thickness);
    let exact = bent + 1.18 * sheared_mm(&material, thickness, pressure, side / 2.0);
    assert!((found / exact - 1.0).abs() < 0.03, "{found} {exact}");
}

#[test]
fn a_long_strip_bends_as_a_clamped_beam_of_plane_strain() {
    // The middle of a strip four times as long as wide is not affected by its ends.
    for (poisson, bound) in [(0.3, 0.03), (0.495, 0.03)] {
        let material = ElasticMaterial::new(1.0, poisson).unwrap();
        let (thickness, width, pressure) = (1.5, 24.0, 1e-6);
        let lines = lines([2.0 * width, width / 2.0], thickness, [96, 48, 3]);
        let found = middle_mm(lines, material, pressure, |_, _| true).unwrap();
        // q b^4 / 384 D, article 1, and q b^2 / 8 by shear.
        let bent = pressure * width.powi(4) / (384.0 * rigidity(&material, thickness));
        let sheared =
            pressure * width.powi(2) / (8.0 * 5.0 / 6.0 * material.shear_modulus_mpa() * thickness);
        assert!(
            (found / (bent + sheared) - 1.0).abs() < bound,
            "{poisson}: {found} {bent} {sheared}"
        );
    }
}

#[test]
fn displaced_volume_is_reciprocal() {
    // Reciprocity (Betti): the volume that a force displaces equals the displacement that a pressure causes.
    let material = ElasticMaterial::new(0.05, 0.49).unwrap();
    let lines = lines([6.0, 4.0], 6.0, [12, 8, 6]);
    let cell = |[i, j, k]: [usize; 3]| {
        let is_open = (2..10).contains(&i) && (3..5).contains(&j) && (2..4).contains(&k);
        BrickContents {
            solid: (!is_open).then_some((material, 1.0)),
            cavities: if is_open { vec![(0, 1.0)] } else { Vec::new() },
        }
    };
    let slab = Slab::new(lines, 1, cell, |place| place.z == 0.0).unwrap();
    let node = slab.node([5, 4, 6]);
    let by_force = slab.solve(&[(node, -2.0)], &[0.0]);
    let by_pressure = slab.solve(&[], &[3.0]);
    let squeezed = slab.growth_mm3(0, &by_force) * 3.0;
    let moved = slab.displacement_mm(&by_pressure, node).z * -2.0;
    assert!(squeezed < 0.0 && (squeezed / moved - 1.0).abs() < 1e-9, "{squeezed} {moved}");
}

#[test]
fn too_many_bricks_are_refused() {
    let material = ElasticMaterial::new(0.05, 0.49).unwrap();
    let lines = lines([50.0; 2], 9.0, [120, 120, 9]);
    let cell = |_| BrickContents { solid: Some((material, 1.0)), cavities: Vec::new() };
    let error = Slab::new(lines, 0, cell, |place| place.z == 0.0).unwrap_err();
    assert!(
        matches!(error, ElasticError::TooFine { unknowns, .. } if unknowns == 395_307),
        "{error}"
    );
}
