//! Tiles of rays compared with rays traced one by one, where directions have components of 0 and rays only touch
//! bodies.

use fabkit_geometry::{
    Assembly, Body, MaterialProperties, NominalCamera, OpticalClarity, Placement, Point3, Pose,
    Ray, Sensor, Solid, Vector3,
};
use fabkit_optics::{LightPath, OpticalStack, RayEnd, TILE, TileTracing, Tracer};
use proptest::prelude::*;

/// A body in place; a medium if it has a refractive index.
fn body(name: &str, index: Option<f64>, solid: Solid) -> Body {
    let body = Body::bought(name, "", solid).placed([Placement::in_place(Assembly::sensor())]);
    let Some(index) = index else { return body };
    let mut clear = body.with_clarity(OpticalClarity::Clear);
    clear.substance =
        MaterialProperties { refractive_index: Some(index), ..MaterialProperties::default() };
    clear
}

fn stack(bodies: impl IntoIterator<Item = Body>) -> OpticalStack {
    let camera = NominalCamera {
        sensor_from_camera: Pose::identity(),
        width_px: 64,
        height_px: 64,
        field_of_view: fabkit_geometry::Angle::from_deg(90.0).unwrap(),
        lens: Default::default(),
    };
    OpticalStack::from_sensor(&Sensor::new("test", "", "", camera, bodies)).unwrap()
}

/// Image of a pinhole at the origin that looks along a coordinate axis. Steps between rays are powers of two, so that the
/// rays of the middle column, row and pixel have components of exactly 0.
#[derive(Clone, Copy, Debug)]
struct View {
    axis: usize,
    sign: f64,
    size_px: [u32; 2],
    /// Pixel on the axis.
    middle_px: [u32; 2],
    step: f64,
}

impl View {
    fn ray(&self, column: u32, row: u32) -> Ray {
        let off =
            |px: u32, axis: usize| (f64::from(px) - f64::from(self.middle_px[axis])) * self.step;
        let mut direction = Vector3::zeros();
        direction[self.axis] = self.sign;
        direction[(self.axis + 1) % 3] = off(column, 0);
        direction[(self.axis + 2) % 3] = off(row, 1);
        Ray { origin: Point3::origin(), direction: direction.normalize() }
    }

    /// Traces all rays in tiles and one by one, and returns the number of rays that meet something. Ends and bends are
    /// the same; places agree within 1e-9 mm, far above the rounding of coordinates of about 100 mm, 1e-14 mm each.
    fn compare(&self, stack: &OpticalStack) -> Result<usize, TestCaseError> {
        let tracing = TileTracing::new(stack);
        let (mut together, mut alone) = (tracing.tracer(), Tracer::new(stack));
        let [width, height] = self.size_px;
        let mut paths: Vec<([u32; 2], LightPath)> = Vec::new();
        for top in (0..height).step_by(TILE as usize) {
            for left in (0..width).step_by(TILE as usize) {
                let (columns, rows) =
                    (left..(left + TILE).min(width), top..(top + TILE).min(height));
                let ray = |column: u32, row: u32| Some(self.ray(column, row));
                together.cast(columns, rows, &ray, &mut |column, row, path| {
                    paths.push(([column, row], path));
                });
            }
        }
        prop_assert_eq!(paths.len(), (width * height) as usize);
        let mut hits = 0;
        for ([column, row], path) in paths {
            let expected = alone.follow(&self.ray(column, row));
            let place = format!("{column} {row} {path:?} {expected:?}");
            prop_assert_eq!((path.end, path.bends), (expected.end, expected.bends), "{}", place);
            if expected.end_mm.is_finite() {
                let apart = path.last.at(path.end_mm) - expected.last.at(expected.end_mm);
                prop_assert!(apart.norm() < 1e-9, "{}", place);
            }
            prop_assert_eq!(path.end_mm.is_finite(), expected.end_mm.is_finite(), "{}", place);
            hits += usize::from(expected.end != RayEnd::Nothing);
        }
        Ok(hits)
    }
}

/// A tile around the axis whose middle ray passes beside a disc, and on into nothing. Of its rays, those that meet the
/// disc have slopes up to 2 / 10: with steps of 1/64 those up to 12.8 pixels from the axis.
#[test]
fn a_tile_whose_first_ray_leaves_the_sensor_meets_the_disc_before_it() {
    let disc = Solid::cylinder(2.0, 1.0).at_z(10.0);
    let stack = stack([body("disc", None, disc)]);
    let view = |middle_px: [u32; 2]| View {
        axis: 2,
        sign: 1.0,
        size_px: [32, 32],
        middle_px,
        step: 1.0 / 64.0,
    };
    // The tile's middle ray is that of column 0 in row 16, 15 or more pixels from the axis: it leaves the sensor.
    for middle_px in [[15, 16], [16, 16], [15, 15], [20, 16], [31, 16]] {
        let hits = view(middle_px).compare(&stack).unwrap();
        let inside = |column: i64, row: i64| {
            let [x, y] = [column - i64::from(middle_px[0]), row - i64::from(middle_px[1])];
            // (2 / 10)^2 64^2 = 163.84
            x * x + y * y <= 163
        };
        let expected = (0..32 * 32).filter(|i| inside(i % 32, i / 32)).count();
        assert_eq!(hits, expected, "{middle_px:?}");
    }
}

/// Rays through a hole whose tool begins before the plate pass no face of the tool within the plate's box before they come
/// to the plate's lower face, where others end: only what lies between both tells them apart.
#[test]
fn a_hole_is_open_though_its_tool_begins_before_the_plate() {
    let plate = Solid::cuboid(8.0, 8.0, 1.0).minus(Solid::cuboid(2.0, 2.0, 4.0).at_z(-2.0));
    let stack = stack([body("plate", None, plate.at_z(6.0))]);
    for middle_px in [[15, 16], [3, 15], [28, 5]] {
        let view = View { axis: 2, sign: 1.0, size_px: [33, 31], middle_px, step: 1.0 / 64.0 };
        let hits = view.compare(&stack).unwrap();
        // The hole's upper edge, 1 mm aside at 7 mm, hides what its lower edge lets in: slopes below 1 / 7 go through,
        // those of up to 9 pixels, and slopes up to 4 / 6 meet the plate, which all rays have.
        let open = |k: usize, middle: u32| (k as i64 - i64::from(middle)).abs() <= 9;
        let is_open = |i: &usize| open(i % 33, middle_px[0]) && open(i / 33, middle_px[1]);
        assert_eq!(hits, 33 * 31 - (0..33 * 31).filter(is_open).count(), "{middle_px:?}");
    }
}

/// Solids within 3 mm from z = 0, whose sides lie at multiples of 0.5 mm: rays along the axes touch them, or run within
/// their faces. Tools reach 2 mm beyond what they cut, to before the pane.
fn solid() -> impl Strategy<Value = Solid> {
    let half = |range: std::ops::RangeInclusive<i32>| range.prop_map(|k| f64::from(k) / 2.0);
    let place = [half(-8..=8).boxed(), half(-8..=8).boxed(), half(0..=0).boxed()];
    let size = [half(1..=6), half(1..=6), half(1..=6)];
    (0..4usize, place, size).prop_map(|(kind, [x, y, z], [a, b, c])| match kind {
        0 => Solid::cuboid_between([x - a, y - b, z], [x + a, y + b, z + c]),
        1 => Solid::cylinder(a, c).at(x, y, z),
        2 => Solid::sphere(a.min(1.5)).at(x, y, 1.5),
        _ => Solid::cuboid(2.0 * a, 2.0 * b, c)
            .minus(Solid::cuboid(a, b, c + 4.0).at_z(-2.0))
            .at(x, y, z),
    })
}

/// Turns the z axis to another one, by exact exchanges of coordinates.
fn along(solid: Solid, axis: usize, sign: f64) -> Solid {
    let turn = fabkit_geometry::Angle::from_deg(90.0).unwrap();
    let back = fabkit_geometry::Angle::from_deg(180.0).unwrap();
    let solid = if sign < 0.0 { solid.turned_x(back) } else { solid };
    match axis {
        0 => solid.turned_y(turn),
        1 => solid.turned_x(turn),
        _ => solid,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn tiles_and_single_rays_meet_the_same_bodies(
        solids in prop::collection::vec(solid(), 1..5),
        pane in prop::option::of(1.3..1.6f64),
        axis in 0..3usize,
        sign in prop::sample::select(vec![1.0, -1.0]),
        size_px in [1..70u32, 1..70u32],
        middle in [0.0..1.0f64, 0.0..1.0],
        step in prop::sample::select(vec![1.0 / 16.0, 1.0 / 32.0, 1.0 / 64.0]),
    ) {
        let pane = pane.map(|index| {
            let pane = Solid::cuboid_between([-40.0, -40.0, 0.5], [40.0, 40.0, 1.5]);
            body("pane", Some(index), along(pane, axis, sign))
        });
        let all = solids.into_iter().enumerate();
        // One behind the other: of two stops with a common face, rounding says which is first.
        let all = all.map(|(i, solid)| {
            let solid = along(solid.at_z(2.5 + 3.5 * i as f64), axis, sign);
            body(&format!("stop-{i}"), None, solid)
        });
        let stack = stack(pane.into_iter().chain(all));
        // Often in the middle of a tile, sometimes at its edge.
        let middle_px = [0, 1].map(|k| (middle[k] * f64::from(size_px[k])) as u32);
        View { axis, sign, size_px, middle_px, step }.compare(&stack)?;
    }
}
