//! Benchmark of line casting, in lines per second on one core, for a few bodies: `cargo run --release --example
//! lines_throughput`.

use std::time::Instant;

use fabkit_geometry::{CompiledSolid, Path, Point3, Ray, Scratch, Solid, Vector3};
use fabkit_geometry_testing::{dimpled_mold, perforated_dome};

fn main() {
    let bolt = Solid::cylinder(2.5, 2.0).plus(Solid::cylinder(1.0, 8.0).at(0.0, 0.0, -7.0));
    let shell = Solid::sphere(10.0)
        .minus(Solid::sphere(9.0))
        .minus(Solid::cylinder(2.0, 20.0).at(1.0, 0.0, 0.0));
    let plate = Path::rectangle([0.0, 0.0], [20.0, 12.0], 2.0);
    let bullet = Path::from([0.0, 0.0])
        .line([15.0, 0.0])
        .line([15.0, 6.0])
        .arc([0.0, 21.0], [0.0, 6.0], true)
        .close();
    let bodies = [
        ("sphere", Solid::sphere(10.0)),
        ("bolt", bolt),
        ("drilled shell", shell),
        ("torus", Solid::torus(10.0, 3.0)),
        ("offset ellipsoid", Solid::ellipsoid_offset(10.0, 6.0, 1.0)),
        ("rounded plate", Solid::extrusion(plate, 3.0)),
        ("bullet", Solid::revolution(bullet)),
        ("dome, 100 holes", perforated_dome().0),
        ("mold, 200 dimples", dimpled_mold().0),
    ];
    for (name, solid) in bodies {
        let body = CompiledSolid::new(&solid).expect("all of these are solids");
        let (lines, crossings, seconds) = cast(&body);
        let millions_per_s = f64::from(lines) / seconds / 1e6;
        println!("{name:20} {millions_per_s:6.2} M lines/s, {crossings} crossings");
    }
}

/// Casts 1000 x 1000 lines from a point obliquely above through a grid around the body's centre. Returns the number of
/// lines, the number of crossings and the time, s.
fn cast(body: &CompiledSolid) -> (u32, usize, f64) {
    const SIDE: u32 = 1000;
    let bounds = body.bounds();
    let (centre, size) = (bounds.centre(), bounds.size_mm());
    let eye = centre + Vector3::new(30.0, 40.0, 60.0);
    let (mut scratch, mut crossings) = (Scratch::default(), Vec::new());
    let start = Instant::now();
    let mut count = 0;
    for i in 0..SIDE {
        for j in 0..SIDE {
            let at = |k: u32, size: f64| (f64::from(k) / f64::from(SIDE) - 0.5) * size;
            let target: Point3<f64> = centre + Vector3::new(at(i, size[0]), at(j, size[1]), 0.0);
            let ray = Ray { origin: eye, direction: target - eye };
            body.crossings_into(&ray, &mut scratch, &mut crossings);
            count += crossings.len();
        }
    }
    (SIDE * SIDE, count, start.elapsed().as_secs_f64())
}
