//! Tests that need the scale of an image or the surfaces that a ray sees.

use fabkit_geometry::{Angle, CompiledSolid, Point3, Pose, Solid, Vector3};

use super::lines::{Line, line_between};
use super::sample::{Setup, Tracer};
use super::tile::Tile;
use super::*;

fn actor(solid: &Solid) -> Actor {
    Actor::new(CompiledSolid::new(solid).expect("a solid"), [90, 140, 200])
}

/// A part with silhouettes, creases, holes and smooth joins, tilted so that nothing is aligned.
fn part() -> Actor {
    let solid = Solid::cylinder(10.0, 6.0)
        .plus(Solid::sphere(10.0))
        .minus(Solid::cuboid(6.0, 40.0, 3.0).at(0.0, 0.0, 1.0))
        .minus(Solid::cylinder(3.0, 40.0).at(2.0, 1.0, -20.0));
    let tilt = Angle::from_deg(17.0).expect("finite");
    actor(&solid).placed(Pose::rotation_x(tilt).then_in(Pose::rotation_y(tilt)))
}

/// Line between two positions in the image.
fn line(setup: &Setup<'_>, [x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) -> Line {
    let mut tracer = Tracer::new(setup);
    let (a, b) = (tracer.trace(x0, y0), tracer.trace(x1, y1));
    line_between(tracer.surfaces(&a), tracer.surfaces(&b), &setup.framing)
}

/// Projection of a scene point into an orthographic image, px.
fn place(framing: &Framing, point: Point3<f64>) -> [f64; 2] {
    let origin = framing.ray(0.0, 0.0).origin;
    let offset = (point - origin) / framing.per_px;
    [offset.dot(&framing.right), -offset.dot(&framing.up)]
}

/// Returns whether a pixel differs from the background, which has no red cast and is constant along rows.
fn is_drawn(image: &RenderedImage, x_px: u32, y_px: u32) -> bool {
    image.pixel(x_px, y_px) != image.pixel(0, y_px)
}

#[test]
fn a_balls_outline_is_its_radius() {
    let radius_mm = 7.0;
    let view = View::isometric(240, 200);
    let actors = [actor(&Solid::sphere(radius_mm))];
    let setup = prepare(&actors, &view).expect("a scene");
    let image = render(&actors, &view).expect("an image");
    let radius_px = radius_mm / setup.framing.per_px;
    let [x_px, y_px] = place(&setup.framing, Point3::origin());
    let centre_row = (0..240).filter(|&x| is_drawn(&image, x, y_px as u32)).count() as f64;
    let centre_column = (0..200).filter(|&y| is_drawn(&image, x_px as u32, y)).count() as f64;
    // The outline reaches up to 3/4 px beyond; a pixel that it touches counts whole.
    for diameter_px in [centre_row, centre_column] {
        assert!((diameter_px / 2.0 - radius_px - 0.5).abs() < 1.0, "{diameter_px} {radius_px}");
    }
    // The ball fills the image up to the margin (5 % of 200 px) and two cells of the extent's search.
    assert!(radius_px <= 90.0 && radius_px > 90.0 - 2.0, "{radius_px}");
}

#[test]
fn a_ball_is_bright_inside_and_dark_at_its_rim() {
    let view = View::front(200, 200);
    let actors = [actor(&Solid::sphere(7.0))];
    let setup = prepare(&actors, &view).expect("a scene");
    let image = render(&actors, &view).expect("an image");
    let green = |x_mm: f64| {
        let [x_px, y_px] = place(&setup.framing, Point3::new(x_mm, 0.0, 0.0));
        image.pixel(x_px as u32, y_px as u32)[1]
    };
    assert!(green(0.0) > green(6.5), "shade: {} {}", green(0.0), green(6.5));
    assert!(green(6.5) > green(7.0) + 40, "line: {} {}", green(6.5), green(7.0));
    assert!(image.pixel(1, 1).iter().all(|&channel| channel > 220), "background");
}

#[test]
fn tiles_fit_together_wherever_they_are_cut() {
    let actors = [part(), actor(&Solid::sphere(12.0)).with_opacity(0.3)];
    let view = View::isometric(150, 140);
    let mut setup = prepare(&actors, &view).expect("a scene");
    for size_px in [150, 1800] {
        setup.pen = Pen::from_view(&View::isometric(size_px, size_px));
        let whole = Tile { x_px: 0, y_px: 0, width_px: 150, height_px: 140 };
        let image = RenderedImage { width_px: 150, height_px: 140, rgb: whole.draw(&setup) };
        for (x_px, y_px, width_px, height_px) in
            [(37, 41, 50, 30), (61, 20, 1, 90), (0, 77, 150, 1), (70, 60, 3, 2)]
        {
            let rgb = Tile { x_px, y_px, width_px, height_px }.draw(&setup);
            let mut expected = Vec::new();
            for y in y_px..y_px + height_px {
                expected.extend((x_px..x_px + width_px).flat_map(|x| image.pixel(x, y)));
            }
            assert!(rgb == expected, "pen for {size_px} px, tile at {x_px}, {y_px}");
        }
    }
}

#[test]
fn smooth_joins_have_no_line_and_creases_do() {
    // A hemisphere on a wall of the same radius, as the sensor's own surface.
    let bullet = Solid::sphere(15.0).plus(Solid::cylinder(15.0, 10.0).at(0.0, 0.0, -10.0));
    let actors = [actor(&bullet)];
    let setup = prepare(&actors, &View::front(300, 300)).expect("a scene");
    let mut tracer = Tracer::new(&setup);
    let [x, y] = place(&setup.framing, Point3::new(4.0, 0.0, 0.0));
    let (above, below) = (tracer.trace(x, y - 0.5), tracer.trace(x, y + 0.5));
    assert_ne!(tracer.surfaces(&above)[0].leaf, tracer.surfaces(&below)[0].leaf);
    assert_eq!(line(&setup, [x, y - 0.5], [x, y + 0.5]), Line::NONE);

    let actors = [actor(&Solid::cuboid(10.0, 10.0, 10.0))];
    let setup = prepare(&actors, &View::isometric(300, 300)).expect("a scene");
    let [x, y] = place(&setup.framing, Point3::new(5.0, -5.0, 4.0));
    assert_eq!(line(&setup, [x - 0.5, y], [x + 0.5, y]), Line { outline: 0.0, crease: 1.0 });
    assert_eq!(line(&setup, [x + 0.5, y], [x + 1.5, y]), Line::NONE);
    let [x, y] = place(&setup.framing, Point3::new(5.0, 5.0, 4.0));
    assert_eq!(line(&setup, [x - 0.5, y], [x + 0.5, y]), Line { outline: 1.0, crease: 0.0 });
}

#[test]
fn a_step_between_parallel_faces_has_an_outline() {
    let pocket =
        Solid::cuboid(10.0, 10.0, 5.0).minus(Solid::cuboid(4.0, 4.0, 5.0).at(0.0, 0.0, 4.9));
    let actors = [actor(&pocket)];
    let setup = prepare(&actors, &View::top(300, 300)).expect("a scene");
    let [x, y] = place(&setup.framing, Point3::new(2.0, 0.0, 5.0));
    assert_eq!(line(&setup, [x - 0.5, y], [x + 0.5, y]), Line { outline: 1.0, crease: 0.0 });
}

#[test]
fn a_torus_has_an_outline_where_it_hides_itself() {
    // Up the middle column, the crest of the near arc hides the foot of the far wall of the hole. The small step must
    // be found however the samples fall around the crest, where slopes go to infinity.
    let actors = [actor(&Solid::torus(3.2, 3.0))];
    let view = View::along(Vector3::new(0.0, 1.0, -1.0), 400, 300);
    let setup = prepare(&actors, &view).expect("a scene");
    let [x, bottom] = place(&setup.framing, Point3::new(0.0, -3.2, 3.0));
    let [_, top] = place(&setup.framing, Point3::new(0.0, 3.2, 3.0));
    for phase in 0..50 {
        let bottom = bottom - f64::from(phase) / 50.0;
        let outlines = (0..(bottom - top) as u32)
            .map(|step| bottom - f64::from(step))
            .filter(|&y| line(&setup, [x, y], [x, y - 1.0]).outline > 0.0)
            .count();
        assert_eq!(outlines, 1, "phase {phase}");
    }
}

#[test]
fn a_step_seen_at_a_glancing_angle_has_an_outline() {
    let low = Solid::cuboid(20.0, 20.0, 1.0).at(0.0, 10.0, 0.0);
    let high = Solid::cuboid(20.0, 20.0, 3.0).at(0.0, -10.0, 0.0);
    let actors = [actor(&low.plus(high))];
    // 8 degrees above the tops: a chord across the step leaves either top by no more than that.
    let looking = Vector3::new(0.0, 1.0, -(8f64.to_radians().tan()));
    let setup = prepare(&actors, &View::along(looking, 300, 300)).expect("a scene");
    let [x, y] = place(&setup.framing, Point3::new(0.0, 0.0, 3.0));
    assert_eq!(line(&setup, [x, y - 0.5], [x, y + 0.5]), Line { outline: 1.0, crease: 0.0 });
}

#[test]
fn a_clear_bodys_lines_are_lighter_and_so_are_those_behind_it() {
    let ball = actor(&Solid::sphere(3.0));
    let glass = actor(&Solid::cuboid(20.0, 20.0, 20.0).at(0.0, 0.0, -10.0)).with_opacity(0.4);
    let actors = [glass, ball];
    let setup = prepare(&actors, &View::front(200, 200)).expect("a scene");
    let [x, y] = place(&setup.framing, Point3::new(10.0, 0.0, 0.0));
    let own = line(&setup, [x - 0.5, y], [x + 0.5, y]).outline;
    let [x, y] = place(&setup.framing, Point3::new(3.0, 0.0, 0.0));
    let behind = line(&setup, [x - 0.5, y], [x + 0.5, y]).outline;
    assert!(own > 0.2 && own < 0.8, "{own}");
    // Seen straight through one face of opacity 0.4.
    assert!((behind - 0.6).abs() < 1e-6, "{behind}");
}

#[test]
fn framing_a_cut_box_ends_at_the_cut() {
    let cut = SectionCut { point: Point3::new(0.0, 0.25, 0.0), outward: Vector3::y() * 5.0 };
    let bounds = fabkit_geometry::Aabb {
        min: Point3::new(-1.0, -2.0, -3.0),
        max: Point3::new(1.0, 2.0, 3.0),
    };
    let mut points = Vec::new();
    cut.clip_box(&crate::cast::corners(&bounds), &mut points);
    assert_eq!(points.len(), 8, "four corners stay, four edges are cut");
    let highest = points.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
    assert_eq!(highest, 0.25);
}

#[test]
fn narrow_places_look_deep_unless_what_was_in_front_is_cut_away() {
    let slotted =
        Solid::cuboid(20.0, 20.0, 20.0).minus(Solid::cuboid(1.0, 30.0, 30.0).at(0.0, 0.0, -5.0));
    let actors = [actor(&slotted)];
    let on_wall = Point3::new(-0.5, -8.0, 10.0);
    let green = |view: &View| {
        let setup = prepare(&actors, view).expect("a scene");
        let [x, y] = place(&setup.framing, on_wall);
        let mut tracer = Tracer::new(&setup);
        let sample = tracer.trace(x, y);
        assert!((tracer.surfaces(&sample)[0].point - on_wall).norm() < 1e-9);
        sample.color[1]
    };
    let whole = View::along(Vector3::new(-2.0, 20.0, 0.0), 200, 200);
    let halved = whole.clone().cut(Point3::new(-0.4, 0.0, 0.0), Vector3::x());
    // The slot's other wall is 1 mm away; shelter reaches 0.08 of the 34.6 mm diagonal.
    let shelter = 1.0 - 1.0 / (0.08 * 1200f32.sqrt());
    let ratio = green(&whole) / green(&halved);
    assert!((ratio - (1.0 - 0.6 * shelter * shelter)).abs() < 1e-3, "{ratio}");
}
