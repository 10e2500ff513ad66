//! Exact figures of the samples against closed forms: each lies within its stated error, and each error is small enough
//! to be useful.

use std::f64::consts::PI;

use fabkit_export::{ExportError, SamplesDocument, samples};
use fabkit_geometry::{Angle, Matrix3, Path, Point3, Pose, Solid, Vector3};
use fabkit_geometry_testing::{cases, poses, primitives};
use proptest::prelude::*;
use serde_json::Value;

fn figures(solid: &Solid) -> Result<Value, ExportError> {
    let document = SamplesDocument {
        design_hash: "0123",
        sensor: "test",
        name: "body",
        solid,
        landmarks: &[],
    };
    let parsed: Value = serde_json::from_slice(&samples(&document)?).expect("samples are JSON");
    Ok(parsed["figures"].clone())
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("figures are numbers")
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::from_fn(|i, _| number(&value[i]))
}

fn matrix(value: &Value) -> Matrix3<f64> {
    Matrix3::from_fn(|row, column| number(&value[row][column]))
}

/// A solid with known integrals; inertia about the centroid, along the axes of its frame.
struct Known {
    solid: Solid,
    volume: f64,
    area: Option<f64>,
    centroid: [f64; 3],
    inertia: Option<[f64; 3]>,
    genus: i64,
    shells: u64,
}

impl Known {
    fn new(solid: Solid, volume: f64, area: f64, inertia: [f64; 3]) -> Self {
        let (area, inertia) = (Some(area), Some(inertia));
        Self { solid, volume, area, centroid: [0.0; 3], inertia, genus: 0, shells: 1 }
    }

    fn centre(self, z: f64) -> Self {
        Self { centroid: [0.0, 0.0, z], ..self }
    }

    fn topology(self, genus: i64, shells: u64) -> Self {
        Self { genus, shells, ..self }
    }
}

fn primitives_in_closed_form() -> Vec<Known> {
    let (r, h) = (3.0, 5.0);
    let cuboid = {
        let (a, b, c) = (2.0, 3.0, 4.0);
        let squares = [b * b + c * c, a * a + c * c, a * a + b * b];
        let area = 2.0 * (a * b + b * c + c * a);
        Known::new(Solid::cuboid(a, b, c), 24.0, area, squares.map(|s| 2.0 * s)).centre(2.0)
    };
    let cylinder = {
        let volume = PI * r * r * h;
        let across = volume * (3.0 * r * r + h * h) / 12.0;
        let inertia = [across, across, volume * r * r / 2.0];
        Known::new(Solid::cylinder(r, h), volume, 2.0 * PI * r * (r + h), inertia).centre(h / 2.0)
    };
    let cone = {
        let volume = PI * r * r * h / 3.0;
        let across = 3.0 / 80.0 * volume * (4.0 * r * r + h * h);
        let area = PI * r * (r + r.hypot(h));
        let inertia = [across, across, 0.3 * volume * r * r];
        Known::new(Solid::cone(r, 0.0, h), volume, area, inertia).centre(h / 4.0)
    };
    let ellipsoid = {
        let (a, b, c) = (2.0, 3.0, 4.0);
        let volume = 4.0 / 3.0 * PI * a * b * c;
        let squares = [b * b + c * c, a * a + c * c, a * a + b * b];
        let known =
            Known::new(Solid::ellipsoid([a, b, c]), volume, 0.0, squares.map(|s| volume / 5.0 * s));
        // The area is an elliptic integral, which is not compared.
        Known { area: None, ..known }
    };
    let torus = {
        let (ring, tube) = (4.0, 1.5);
        let volume = 2.0 * PI * PI * ring * tube * tube;
        let across = volume * (ring * ring / 2.0 + 0.625 * tube * tube);
        let along = volume * (ring * ring + 0.75 * tube * tube);
        let area = 4.0 * PI * PI * ring * tube;
        Known::new(Solid::torus(ring, tube), volume, area, [across, across, along]).topology(1, 1)
    };
    vec![cuboid, cylinder, cone, ellipsoid, torus]
}

fn composed_in_closed_form() -> Vec<Known> {
    let ball = |r: f64| 4.0 / 3.0 * PI * r.powi(3);
    let r = 5.0;
    let half_ball = {
        let volume = ball(r) / 2.0;
        // About the ball's centre, half of the ball's; the centroid lies 3/8 r below.
        let across = volume * r * r * (0.4 - 9.0 / 64.0);
        let inertia = [across, across, 0.4 * volume * r * r];
        let solid = Solid::sphere(r).and(Solid::below(0.0));
        Known::new(solid, volume, 3.0 * PI * r * r, inertia).centre(-0.375 * r)
    };
    let hollow_ball = {
        let inner = 3.0;
        let inertia = 0.4 * (ball(r) * r * r - ball(inner) * inner * inner);
        let solid = Solid::sphere(r).minus(Solid::sphere(inner));
        let area = 4.0 * PI * (r * r + inner * inner);
        Known::new(solid, ball(r) - ball(inner), area, [inertia; 3]).topology(0, 2)
    };
    let drilled_ball = {
        // Half of the bore is 4 long; the remainder has the volume of a ball of that radius.
        let (bore, half) = (3.0, 4.0_f64);
        let axial = 2.0 * PI * (2.0 / 3.0 * r * r * half.powi(3) - 0.4 * half.powi(5));
        let across = axial / 2.0 + 4.0 / 15.0 * PI * half.powi(5);
        let drill = Solid::cylinder(bore, 20.0).at(0.0, 0.0, -10.0);
        let area = 4.0 * PI * half * (r + bore);
        let inertia = [across, across, axial];
        Known::new(Solid::sphere(r).minus(drill), ball(half), area, inertia).topology(1, 1)
    };
    let screw = {
        // A countersunk head on a shank: two faces that meet in an edge, both with small radii.
        let path = Path::polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 4.0], [2.0, 5.0], [0.0, 5.0]]);
        let (shank, head) = (4.0 * PI, 7.0 / 3.0 * PI);
        // For a frustum with radii 1 and 2: (1 + 2 * 2 + 3 * 4) / (4 * 7) of its height.
        let centre = (shank * 2.0 + head * (4.0 + 17.0 / 28.0)) / (shank + head);
        let area = PI * (1.0 + 8.0 + 3.0 * 2.0_f64.sqrt() + 4.0);
        let known = Known::new(Solid::revolution(path), shank + head, area, [0.0; 3]);
        Known { inertia: None, ..known.centre(centre) }
    };
    let slot = {
        let section = 10.0 + PI;
        let path = Path::slot([-3.0, 0.0], [2.0, 0.0], 1.0);
        let area = 2.0 * section + 2.0 * (10.0 + 2.0 * PI);
        let known = Known::new(Solid::extrusion(path, 2.0), 2.0 * section, area, [0.0; 3]);
        Known { centroid: [-0.5, 0.0, 1.0], inertia: None, ..known }
    };
    vec![half_ball, hollow_ball, drilled_ball, screw, slot]
}

fn assert_figures(known: &Known, pose: Pose) {
    let solid = known.solid.clone().placed(pose);
    let found = figures(&solid).expect("it can be meshed");
    let within = |what: &str, off: f64, whole: f64, digits: f64| {
        let error = number(&found[what]);
        assert!(off <= error, "{what}: off by {off:e}, stated {error:e}: {:?}", known.solid);
        assert!(error < digits * whole, "{what} {error:e} says nothing: {:?}", known.solid);
    };
    let volume = number(&found["volume_mm3"]);
    within("volume_error_mm3", (volume - known.volume).abs(), known.volume, 1e-6);
    if let Some(area) = known.area {
        within("area_error_mm2", (number(&found["area_mm2"]) - area).abs(), area, 1e-5);
    }
    let centroid = pose.point(Point3::from(known.centroid)).coords;
    let off = (vector(&found["centroid_mm"]) - centroid).norm();
    within("centroid_error_mm", off, known.volume.cbrt(), 1e-6);
    if let Some(inertia) = known.inertia {
        let axes = Matrix3::from_columns(
            &[Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| pose.vector(axis)),
        );
        let exact = axes * Matrix3::from_diagonal(&Vector3::from(inertia)) * axes.transpose();
        let off = (matrix(&found["inertia_mm5"]) - exact).amax();
        within("inertia_error_mm5", off, exact.amax(), 1e-5);
    }
    assert_eq!(found["genus"], known.genus, "{:?}", known.solid);
    assert_eq!(found["shells"], known.shells, "{:?}", known.solid);
}

#[test]
fn figures_agree_with_closed_forms() {
    let turn = Pose::rotation_x(Angle::from_deg(20.0).unwrap());
    let askew = Pose::z_to(Vector3::new(0.3, -0.5, 0.7), Point3::new(8.0, -2.0, 3.0));
    for known in primitives_in_closed_form().iter().chain(&composed_in_closed_form()) {
        assert_figures(known, Pose::identity());
        assert_figures(known, askew.then_in(turn));
    }
}

#[test]
fn bounds_lie_within_their_error() {
    let (centre, r) = ([1.0, -2.0, 3.0], 4.0);
    let found = figures(&Solid::sphere(r).at(1.0, -2.0, 3.0)).unwrap();
    let error = number(&found["bounds_error_mm"]);
    assert!(error < 0.01);
    for (corner, side) in [(0, -1.0), (1, 1.0)] {
        let exact = Vector3::from(centre).add_scalar(side * r);
        assert!((vector(&found["bounds_mm"][corner]) - exact).amax() <= error);
    }
}

#[test]
fn what_cannot_be_meshed_is_refused_by_name() {
    let nothing = Solid::sphere(1.0).minus(Solid::sphere(2.0));
    for solid in [nothing, Solid::below(0.0), Solid::sphere(-1.0)] {
        match figures(&solid) {
            Err(ExportError::Samples { name, reason }) => {
                assert_eq!(name, "body");
                assert!(!reason.is_empty());
            }
            other => panic!("{solid:?}: {other:?}"),
        }
    }
}

proptest! {
    #![proptest_config(cases(8))]

    /// Volumes and moments of two solids equal those of their union plus those of their intersection.
    #[test]
    fn unions_and_intersections_add_up(a in primitives(), b in primitives(), pose in poses(2.0)) {
        let b = b.placed(pose);
        let Ok(common) = figures(&a.clone().and(b.clone())) else { return Ok(()) };
        let all = [figures(&a), figures(&b), figures(&a.plus(b))].map(Result::unwrap);
        let total = |what: &str| {
            let [a, b, union] = all.each_ref().map(|f| number(&f[what]));
            (a + b - union - number(&common[what])).abs()
        };
        let stated = |what: &str| {
            all.iter().chain([&common]).map(|f| number(&f[what])).sum::<f64>()
        };
        let moments = |f: &Value| number(&f["volume_mm3"]) * vector(&f["centroid_mm"]);
        let [a, b, union] = all.each_ref().map(moments);
        let first = (a + b - union - moments(&common)).norm();
        // Errors of centroid and volume combine, at most 15 mm from the origin.
        let first_error = all.iter().chain([&common]).map(|f| {
            number(&f["volume_mm3"]) * number(&f["centroid_error_mm"])
                + 15.0 * number(&f["volume_error_mm3"])
        });
        let (volume, volume_error) = (total("volume_mm3"), stated("volume_error_mm3"));
        prop_assert!(volume <= volume_error, "volume off by {volume:e}, stated {volume_error:e}");
        let (area, area_error) = (total("area_mm2"), stated("area_error_mm2"));
        prop_assert!(area <= area_error, "area off by {area:e}, stated {area_error:e}");
        let first_error: f64 = first_error.sum();
        prop_assert!(first <= first_error, "moment off by {first:e}, stated {first_error:e}");
    }
}
