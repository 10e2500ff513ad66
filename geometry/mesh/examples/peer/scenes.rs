//! Two parts that represent the hard cases: many small features on a curved surface.

use fabkit_geometry::{Path, Point3, Pose, Solid, Vector3};

/// Part whose volume is known in closed form.
pub struct PeerCase {
    /// Name, as used in file names.
    pub name: &'static str,
    /// Solid of the part.
    pub solid: Solid,
    /// Volume, mm^3.
    pub exact_mm3: f64,
    /// Number of through holes.
    #[allow(dead_code, reason = "only the tests look at it")]
    pub genus: i32,
}

/// Returns both parts.
pub fn all() -> [PeerCase; 2] {
    [dimpled_mold(), perforated_dome()]
}

/// Returns directions spread evenly over the zone of the unit sphere with z between two values.
fn fibonacci(count: usize, z_from: f64, z_to: f64) -> impl Iterator<Item = Vector3<f64>> {
    let golden_angle = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |k| {
        let z = z_from + (z_to - z_from) * (k as f64 + 0.5) / count as f64;
        let (s, c) = (k as f64 * golden_angle).sin_cos();
        let across = (1.0 - z * z).sqrt();
        Vector3::new(across * c, across * s, z)
    })
}

/// Creates a mold for a dimpled skin: a box 45 x 45 x 14 minus a spherical cap (base diameter 35, height 8) united with
/// 200 dimples: cylinders of diameter 0.45 with hemispherical tips that reach 0.5 beyond the sphere along its normal.
pub fn dimpled_mold() -> PeerCase {
    let (radius_mm, reach_mm, root_mm) = (0.225, 0.5, 0.3);
    let (cap_radius_mm, cap_height_mm) = (17.5f64, 8.0f64);
    let sphere_mm = (cap_radius_mm.powi(2) + cap_height_mm.powi(2)) / (2.0 * cap_height_mm);
    let centre_z_mm = cap_height_mm - sphere_mm;
    let centre = Point3::new(0.0, 0.0, centre_z_mm);
    // The cap starts at z = 0, the face of the box that it opens; below that it continues as a cylinder.
    let over_mm = 0.1;
    let cap = Solid::revolution(
        Path::from([0.0, -over_mm])
            .line([cap_radius_mm, -over_mm])
            .line([cap_radius_mm, 0.0])
            .arc([0.0, cap_height_mm], [0.0, centre_z_mm], true)
            .close(),
    );
    let shaft_mm = root_mm + reach_mm - radius_mm;
    let dimple = Solid::revolution(
        Path::from([0.0, 0.0])
            .line([radius_mm, 0.0])
            .line([radius_mm, shaft_mm])
            .arc([0.0, shaft_mm + radius_mm], [0.0, shaft_mm], true)
            .close(),
    );
    let dimples = fibonacci(200, 46f64.to_radians().cos(), 1.0).map(|axis| {
        let root = centre + axis * (sphere_mm - root_mm);
        dimple.clone().placed(Pose::z_to(axis, root))
    });
    let tools = Solid::union(std::iter::once(cap).chain(dimples));
    let solid = Solid::cuboid(45.0, 45.0, 14.0).minus(tools);
    PeerCase { name: "dimpled-mold", solid, exact_mm3: 24219.930363, genus: 0 }
}

/// Creates a hollow hemisphere, outer radius 18, inner 15, minus 100 radial holes of diameter 1.
pub fn perforated_dome() -> PeerCase {
    let shell = Solid::revolution(
        Path::from([15.0, 0.0])
            .line([18.0, 0.0])
            .arc([0.0, 18.0], [0.0, 0.0], true)
            .line([0.0, 15.0])
            .arc([15.0, 0.0], [0.0, 0.0], false),
    );
    let hole = Solid::cylinder(0.5, 5.0);
    let holes = fibonacci(100, 0.1, 1.0)
        .map(|axis| hole.clone().placed(Pose::z_to(axis, Point3::from(axis * 14.0))));
    PeerCase {
        name: "perforated-dome",
        solid: shell.minus_all(holes),
        exact_mm3: 4910.254750,
        genus: 100,
    }
}
