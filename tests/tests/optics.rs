//! Light through the built-in sensors as they are drawn.

use fabkit_application::fixtures;
use fabkit_application::ground_truth::Viewpoint;
use fabkit_designs::{builtin_names, builtin_yaml};
use fabkit_geometry::{Ray, Sensor};
use fabkit_optics::{Bundles, End, Stack, TILE, Tracer};
use fabkit_tests::built;

/// The ray of each pixel, row by row, with columns and rows.
fn rays(sensor: &Sensor) -> (Vec<Option<Ray>>, [u32; 2]) {
    let rays = Viewpoint::new(&sensor.camera, None, None).unwrap().rays(1);
    let size = [rays.width_px(), rays.height_px()];
    ((0..rays.len()).map(|pixel| rays.ray(pixel)).collect(), size)
}

/// What a pixel sees, by name.
fn seen(stack: &Stack, end: End) -> &str {
    match end {
        End::Surface => "surface",
        End::Body(body) => &stack.names()[usize::from(body)],
        End::Mirror(_) => "mirror",
        End::Nothing => "nothing",
    }
}

#[test]
fn every_camera_looks_through_media_that_are_known() {
    for name in builtin_names() {
        let sensor = built(name, &[]).sensor;
        let stack = Stack::of(&sensor).unwrap_or_else(|error| panic!("{name}: {error}"));
        let (rays, _) = rays(&sensor);
        let mut tracer = Tracer::new(&stack);
        // Few of many, all of few; no multiple of the columns.
        let step = (rays.len() / 900) | 1;
        let paths = rays.iter().step_by(step).flatten().map(|ray| tracer.follow(ray).end);
        let ends: Vec<End> = paths.collect();
        let surface = ends.iter().filter(|end| **end == End::Surface).count();
        let least = match name {
            // Between its pins, past its LED board; and what is seen of an endless sheet.
            "tactip" => 0.3,
            "fluidic" => 0.0,
            _ => 0.7,
        };
        let share = surface as f64 / ends.len() as f64;
        assert!(share >= least, "{name}: {share}");
        assert!(!ends.contains(&End::Nothing) || name == "fluidic", "{name} sees out of itself");
    }
}

/// Tiles over the middle, the corner and the rim of each picture.
#[test]
fn together_and_alone_rays_end_at_the_same_points() {
    for name in builtin_names() {
        let sensor = built(name, &[]).sensor;
        let stack = Stack::of(&sensor).unwrap();
        let bundles = Bundles::new(&stack);
        let (rays, [width, height]) = rays(&sensor);
        let mut alone = Tracer::new(&stack);
        let at = |share: f64, length: u32| (share * f64::from(length.saturating_sub(TILE))) as u32;
        let mut together = bundles.tracer();
        let mut count = 0;
        let tiles = [
            [0.5, 0.5],
            [0.0, 0.0],
            [0.1, 0.45],
            [0.62, 0.8],
            [0.9, 0.1],
            [0.3, 0.33],
            [0.75, 0.5],
        ];
        for [x, y] in tiles {
            let (left, top) = (at(x, width), at(y, height));
            let (right, bottom) = ((left + TILE).min(width), (top + TILE).min(height));
            let ray = |column: u32, row: u32| rays[(row * width + column) as usize];
            together.cast(left..right, top..bottom, &ray, &mut |column, row, path| {
                count += 1;
                let expected = alone.follow(&ray(column, row).unwrap());
                let place = format!("{name} ({column}, {row}): {path:?} {expected:?}");
                assert_eq!(seen(&stack, path.end), seen(&stack, expected.end), "{place}");
                assert_eq!(path.bends, expected.bends, "{place}");
                if path.end_mm.is_finite() {
                    let apart = path.last.at(path.end_mm) - expected.last.at(expected.end_mm);
                    assert!(apart.norm() < 1e-8, "{place}");
                }
            });
        }
        assert!(count > 500, "{name}: {count}");
    }
}

/// A bore that is made narrower hides what it did not hide.
#[test]
fn a_narrow_diffuser_hides_the_surface() {
    let share = |settings: &[&str]| {
        let yaml = builtin_yaml("rtac0").unwrap();
        let settings: Vec<String> = settings.iter().map(|set| (*set).to_owned()).collect();
        let project = fixtures::load("rtac0.yaml", yaml, &settings).unwrap();
        let sensor = &project.design.sensor;
        let stack = Stack::of(sensor).unwrap();
        let (rays, _) = rays(sensor);
        let mut tracer = Tracer::new(&stack);
        let ends: Vec<End> =
            rays.iter().step_by(211).flatten().map(|ray| tracer.follow(ray).end).collect();
        let by = |name: &str| {
            let count = ends.iter().filter(|end| seen(&stack, **end) == name).count();
            count as f64 / ends.len() as f64
        };
        [by("surface"), by("diffuser")]
    };
    let [usual, narrow] = [share(&[]), share(&["diffuser.bore_radius=4.5mm"])];
    assert!(narrow[0] < usual[0] - 0.2 && narrow[1] > usual[1] + 0.2, "{usual:?} {narrow:?}");
}
