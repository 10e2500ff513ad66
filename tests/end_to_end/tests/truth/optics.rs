//! Light through the built-in sensors as they are drawn.

use std::sync::Arc;

use fabkit_application::depth::ground_truth::{PixelRays, ReferenceSurface, Uncertainty};
use fabkit_application::fixtures;
use fabkit_application::ground_truth::Viewpoint;
use fabkit_camera::{JointEstimate, Point2};
use fabkit_designs::builtin_yaml;
use fabkit_geometry::{Angle, NominalCamera, Point3, Pose, Ray, Sensor, Vector3};
use fabkit_optics::{
    CameraView, OpticalStack, PointProjection, RayEnd, TILE, TileTracing, Tracer, ViewStacks,
};
use fabkit_tests::{build_design, tested_sensors};

/// The ray of each pixel, row by row, with columns and rows.
fn rays(sensor: &Sensor) -> (Vec<Option<Ray>>, [u32; 2]) {
    let rays = Viewpoint::new(&sensor.camera, None, None).unwrap().rays(1);
    let size = [rays.width_px(), rays.height_px()];
    ((0..rays.len()).map(|pixel| rays.ray(pixel)).collect(), size)
}

#[test]
fn every_camera_looks_through_media_that_are_known() {
    for name in tested_sensors() {
        let sensor = build_design(name, &[]).sensor;
        let stack =
            OpticalStack::from_sensor(&sensor).unwrap_or_else(|error| panic!("{name}: {error}"));
        let (rays, _) = rays(&sensor);
        let mut tracer = Tracer::new(&stack);
        // Few of many, all of few; no multiple of the columns.
        let step = (rays.len() / 900) | 1;
        let paths = rays.iter().step_by(step).flatten().map(|ray| tracer.follow(ray).end);
        let ends: Vec<RayEnd> = paths.collect();
        let surface = ends.iter().filter(|end| **end == RayEnd::Surface).count();
        let least = match name {
            // Between its pins, past its LED board; and what is seen of an endless sheet.
            "tactip" => 0.3,
            // A circle of 311 of its 400 pixels.
            "uvdtact" => 0.45,
            "fluidic" => 0.0,
            _ => 0.7,
        };
        let share = surface as f64 / ends.len() as f64;
        assert!(share >= least, "{name}: {share}");
        assert!(!ends.contains(&RayEnd::Nothing) || name == "fluidic", "{name} sees out of itself");
    }
}

/// Tiles over the middle, the corner and the rim of each image.
#[test]
fn together_and_alone_rays_end_at_the_same_points() {
    for name in tested_sensors() {
        let sensor = build_design(name, &[]).sensor;
        let stack = OpticalStack::from_sensor(&sensor).unwrap();
        let bundles = TileTracing::new(&stack);
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
                assert_eq!(stack.name_of(path.end), stack.name_of(expected.end), "{place}");
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
        let stack = OpticalStack::from_sensor(sensor).unwrap();
        let (rays, _) = rays(sensor);
        let mut tracer = Tracer::new(&stack);
        let ends: Vec<RayEnd> =
            rays.iter().step_by(211).flatten().map(|ray| tracer.follow(ray).end).collect();
        let by = |name: &str| {
            let count = ends.iter().filter(|end| stack.name_of(**end) == name).count();
            count as f64 / ends.len() as f64
        };
        [by("surface"), by("diffuser")]
    };
    let [usual, narrow] = [share(&[]), share(&["diffuser.bore_radius=4.5mm"])];
    assert!(narrow[0] < usual[0] - 0.2 && narrow[1] > usual[1] + 0.2, "{usual:?} {narrow:?}");
}

/// Gel shows the touch behind what is looked at, and hides it before that.
#[test]
fn black_gel_hides_what_is_behind_it() {
    let sensor = build_design(
        "rtac0",
        &["transparent_gel.material=Smooth-On Ecoflex 00-30 with black Silc-Pig"],
    )
    .sensor;
    let stack = OpticalStack::from_sensor(&sensor).unwrap();
    let (rays, _) = rays(&sensor);
    let mut tracer = Tracer::new(&stack);
    let ends = rays.iter().step_by(211).flatten().map(|ray| tracer.follow(ray).end);
    let ends: Vec<&str> = ends.map(|end| stack.name_of(end)).collect();
    assert!(!ends.contains(&"surface"));
    assert!(ends.contains(&"transparent-gel"));
    let viewpoint = Viewpoint::new(&sensor.camera, None, None).unwrap();
    let sights = ViewStacks::new(stack);
    let mut viewer = CameraView::new(viewpoint.camera(), &viewpoint.sensor_from_camera, &sights);
    let lost =
        viewer.visible_pixel(&Point3::new(0.0, 0.0, sensor.touch.as_ref().unwrap().apex_z_mm()));
    assert_eq!(lost.map_err(|lost| lost.label(sights.stack())), Err("transparent-gel"));
}

/// A small image, so that all of it is looked at in a moment.
fn small(sensor: &Sensor) -> NominalCamera {
    NominalCamera { width_px: 32, height_px: 24, ..sensor.camera.clone() }
}

/// From pixel to surface and back to the pixel; with what differences say of how it moves.
#[test]
fn places_are_seen_at_the_pixels_that_see_them() {
    for name in tested_sensors() {
        let sensor = build_design(name, &[]).sensor;
        let viewpoint = Viewpoint::new(&small(&sensor), None, None).unwrap();
        let sights = ViewStacks::new(viewpoint.stack(&sensor).unwrap());
        let mut viewer =
            CameraView::new(viewpoint.camera(), &viewpoint.sensor_from_camera, &sights);
        let mut count = 0;
        for (column, row) in (0..24).flat_map(|row| (0..32).map(move |column| (column, row))) {
            let pixel = Point2::new(f64::from(column) + 0.31, f64::from(row) - 0.17);
            let Ok(path) = viewer.path(&pixel) else { continue };
            if path.end != RayEnd::Surface {
                continue;
            }
            let place = path.last.at(path.end_mm);
            let look = viewer.project(&place).unwrap_or_else(|e| panic!("{name} {pixel}: {e}"));
            // Curved faces may focus: a place can have a second pixel, which then sees the same place.
            let back = viewer.path(&look.pixel).unwrap();
            let off = (back.last.at(back.end_mm) - place).norm();
            let apart = (look.pixel - pixel).norm();
            assert!(apart < 1e-9 || off < 1e-9, "{name} {pixel}: {apart:.1e} px, {off:.1e} mm");
            assert!(look.sight.hidden_by(1e-6).is_none(), "{name} {pixel}");
            count += 1;
            if count % 16 != 0 {
                continue;
            }
            let Some(by_place) = viewer.pixel_by_point(&place, &look) else { continue };
            // Half a micrometre to either side; at a seam between faces nothing is smooth.
            for axis in 0..3 {
                let by = Vector3::ith(axis, 5e-4);
                let sides = [place - by, place + by].map(|place| viewer.project(&place));
                let [Ok(before), Ok(after)] = sides else { continue };
                // Past other faces, or another of several rays.
                let is_other = |side: &PointProjection| {
                    side.sight.path.bends != look.sight.path.bends
                        || (side.pixel - look.pixel).norm() > 0.1
                };
                if is_other(&before) || is_other(&after) {
                    continue;
                }
                let error = by_place.column(axis) - (after.pixel - before.pixel) / 1e-3;
                assert!(error.norm() < 1e-6 * by_place.norm(), "{name} {pixel} {axis}: {error}");
            }
        }
        assert!(count > 50 || name == "fluidic", "{name}: {count}");
    }
}

/// The sigma of each pose parameter alone is what the range changes by, bent rays included.
#[test]
fn sigma_is_by_how_much_the_pose_moves_the_range() {
    const STEP: f64 = 1e-4;
    let sensor = build_design("rtac0", &[]).sensor;
    let touch = sensor.touch.as_ref().unwrap();
    let viewpoint = Viewpoint::new(&small(&sensor), None, None).unwrap();
    let sights = Arc::new(ViewStacks::new(viewpoint.stack(&sensor).unwrap()));
    let (camera, pose) = (viewpoint.camera(), &viewpoint.sensor_from_camera);
    let seen_from = |pose: &Pose| PixelRays::new(camera, pose).traced_through(&sights);
    let rays = seen_from(pose);
    let surface = ReferenceSurface::cast(touch, &rays).unwrap();
    let camera_from_sensor = pose.inverse();
    for parameter in 0..6 {
        let mut covariance = [[0.0; 6]; 6];
        covariance[parameter][parameter] = 1.0;
        let joint = JointEstimate::independent(&(*camera).into(), Some(&covariance)).unwrap();
        let uncertainty = Uncertainty { joint: Some(joint), shape_mm: 0.0 };
        let sigma_mm = surface
            .map_without_contact()
            .compute_standard_deviations(&uncertainty)
            .range_mm()
            .collect::<Vec<_>>();
        let moved = |by: f64| {
            let turn = Vector3::ith(parameter % 3, by);
            let translation = camera_from_sensor.translation_mm();
            let angle = Angle::from_rad(by).unwrap();
            let (turned, shift) = match parameter {
                0 => (Pose::rotation_x(angle), Vector3::zeros()),
                1 => (Pose::rotation_y(angle), Vector3::zeros()),
                2 => (Pose::rotation_z(angle), Vector3::zeros()),
                _ => (Pose::identity(), turn),
            };
            let rotation = turned.rotation() * camera_from_sensor.rotation();
            let moved = Pose::new(rotation, translation + shift).unwrap();
            let rays = seen_from(&moved.inverse());
            ReferenceSurface::cast(touch, &rays).unwrap().range_mm().to_vec()
        };
        let (before, after) = (moved(-STEP), moved(STEP));
        let mut compared = 0;
        for pixel in 0..rays.len() {
            let expected = ((after[pixel] - before[pixel]) / (2.0 * STEP)).abs();
            // Where a step leads over an edge, or around the place where it changes nothing.
            let is_smooth = expected.is_finite() && sigma_mm[pixel].is_finite();
            if !is_smooth {
                continue;
            }
            let error = (sigma_mm[pixel] - expected).abs();
            if error < 1e-4 * (1.0 + expected) {
                compared += 1;
            }
        }
        // All but those at creases of the surface and of the gel.
        let seen = surface.visible_pixels();
        assert!(compared * 100 > seen * 97, "{parameter}: {compared} of {seen}");
    }
}

/// A ray to a marker ends at its face, whatever bodies lie behind it.
#[test]
fn rays_to_markers_end_on_them() {
    let mut sensors = 0;
    for name in tested_sensors() {
        let sensor = build_design(name, &[]).sensor;
        let Some(body) = sensor.bodies.iter().find(|body| sensor.is_marker_body(&body.name)) else {
            continue;
        };
        sensors += 1;
        let sights = ViewStacks::new(OpticalStack::from_sensor(&sensor).unwrap());
        let pupil = sensor.camera.sensor_from_camera.point(Point3::origin());
        let mut solver = sights.sight_line_solver();
        let mut seen = 0;
        for mark in &sensor.marks {
            let Some(sight) = solver.find_sight_line(&pupil, &mark.point) else { continue };
            let end_mm = sight.path.lead_mm + sight.path.end_mm;
            if (end_mm - sight.way_mm).abs() < 1e-6 {
                assert_eq!(
                    sights.stack().name_of(sight.path.end),
                    body.name,
                    "{name} {}",
                    mark.name
                );
                seen += 1;
            } else {
                // Hidden before it, by another body or another marker.
                assert!(end_mm < sight.way_mm, "{name} {}: seen through", mark.name);
            }
        }
        assert!(2 * seen > sensor.marks.len(), "{name}: {seen} of {}", sensor.marks.len());
    }
    assert_eq!(sensors, 2);
}
