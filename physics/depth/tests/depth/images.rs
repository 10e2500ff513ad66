//! Visible properties of rendered images, as numbers.

use std::sync::Mutex;

use fabkit_depth::{
    Actor, MAX_PIXELS, PixelContent, RenderError, RenderedImage, View, contact_sheet, render,
    render_camera_view,
};
use fabkit_geometry::{Angle, CompiledSolid, Point3, Pose, Ray, Solid, Vector3};

const RED: [u8; 3] = [220, 40, 40];
const BLUE: [u8; 3] = [60, 90, 220];

fn actor(solid: &Solid, color: [u8; 3]) -> Actor {
    Actor::new(CompiledSolid::new(solid).expect("a solid"), color)
}

fn redness(pixel: [u8; 3]) -> i32 {
    i32::from(pixel[0]) - i32::from(pixel[2])
}

/// A red ball in a closed blue box.
fn hidden_ball() -> [Actor; 2] {
    let hollow =
        Solid::cuboid(20.0, 20.0, 20.0).minus(Solid::cuboid(16.0, 16.0, 16.0).at(0.0, 0.0, 2.0));
    [actor(&hollow, BLUE), actor(&Solid::sphere(6.0).at(0.0, 0.0, 10.0), RED)]
}

fn render_with_threads(threads: usize, actors: &[Actor], view: &View) -> RenderedImage {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    pool.install(|| render(actors, view)).expect("an image")
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let [hollow, ball] = hidden_ball();
    let actors = [hollow.with_opacity(0.4), ball];
    let view = View::isometric(300, 280).perspective(Angle::from_deg(30.0).expect("finite"));
    let alone = render_with_threads(1, &actors, &view);
    assert!(alone == render_with_threads(2, &actors, &view));
    assert!(alone == render_with_threads(8, &actors, &view));
}

#[test]
fn a_cut_shows_what_is_inside() {
    let actors = hidden_ball();
    let whole = render(&actors, &View::front(160, 160)).expect("an image");
    assert!(redness(whole.pixel(80, 80)) < 0, "the box hides the ball");
    // In front of the ball: the ball stays whole. Through its centre: a flat, hatched face.
    let section = |y_mm| {
        let view = View::front(160, 160).cut(Point3::new(0.0, y_mm, 0.0), -Vector3::y());
        render(&actors, &view).expect("an image")
    };
    let (in_front, through) = (section(-7.0), section(0.0));
    assert!(redness(in_front.pixel(80, 80)) > 60);
    // A round ball is shaded from place to place; a cut one repeats the hatch's few colours.
    let colors = |image: &RenderedImage| {
        let mut found: Vec<_> = (60..100).map(|x| image.pixel(x, 81)).collect();
        found.sort_unstable();
        found.dedup();
        found.len()
    };
    let rows = |image: &RenderedImage| (60..100).map(|x| redness(image.pixel(x, 80))).min();
    assert!(rows(&through) > Some(0), "all red");
    assert!(colors(&in_front) > 20, "{}", colors(&in_front));
    let spread = |image: &RenderedImage| {
        let column = |x: u32| (62..78).map(|y| i32::from(image.pixel(x, y)[1])).sum::<i32>() / 16;
        (column(64) - column(95)).abs()
    };
    assert!(spread(&through) < spread(&in_front), "flat when cut");
}

#[test]
fn what_is_clear_lets_the_inside_show() {
    let [hollow, ball] = hidden_ball();
    let center = |opacity: f64| {
        let actors = [hollow.clone().with_opacity(opacity), ball.clone()];
        redness(render(&actors, &View::front(90, 90)).expect("an image").pixel(45, 45))
    };
    let seen: Vec<i32> = [0.0, 0.2, 0.5, 0.8, 1.0].map(center).into();
    assert!(seen.windows(2).all(|pair| pair[0] > pair[1] + 5), "less and less red: {seen:?}");
    assert!(seen[0] > 60 && seen[4] < 0, "{seen:?}");
}

#[test]
fn black_and_white_parts_show_their_faces_and_edges() {
    for color in [[0; 3], [255; 3]] {
        let cube = [actor(&Solid::cuboid(10.0, 10.0, 10.0), color)];
        let image = render(&cube, &View::isometric(200, 200)).expect("an image");
        // The three faces that an isometric view shows meet in the middle.
        let [top, left, right] =
            [[100, 60], [70, 120], [130, 120]].map(|[x, y]| i32::from(image.pixel(x, y)[1]));
        assert!(top > left + 8 && left > right + 8, "{color:?}: {top} {left} {right}");
        // The vertical edge: a pixel wide, shared by two columns.
        let edge = (95..105).map(|x| i32::from(image.pixel(x, 140)[1])).min().expect("pixels");
        assert!(10 * edge < 9 * right, "{color:?}: {edge} {right}");
    }
}

#[test]
fn touching_bodies_do_not_flicker() {
    // Both tops lie in one plane, reached by different arithmetic.
    let tilt = Angle::from_deg(31.0).expect("finite");
    let pose = Pose::rotation_x(tilt).then_in(Pose::rotation_z(tilt));
    let first = actor(&Solid::cuboid(10.0, 10.0, 0.3).at(0.0, 0.0, 0.7), RED).placed(pose);
    let second = actor(&Solid::cuboid(10.0, 10.0, 1.0), BLUE).placed(pose);
    let looking = pose.vector(-Vector3::z());
    let image = render(&[first, second], &View::along(looking, 120, 120)).expect("an image");
    for y in 50..70 {
        assert!((50..70).all(|x| redness(image.pixel(x, y)) > 60), "row {y}");
    }
}

#[test]
fn in_perspective_what_is_near_is_larger() {
    let place = |y_mm, x_mm| Pose::translation(x_mm, y_mm, 0.0);
    let near = actor(&Solid::sphere(3.0), RED).placed(place(-20.0, -10.0));
    let far = actor(&Solid::sphere(3.0), BLUE).placed(place(20.0, 10.0));
    let actors = [near, far];
    let areas = |view: &View| {
        let image = render(&actors, view).expect("an image");
        let mut areas = [0.0, 0.0];
        for pixel in image.rgb.chunks_exact(3) {
            let red = redness([pixel[0], pixel[1], pixel[2]]);
            areas[0] += f64::from(u8::from(red > 30));
            areas[1] += f64::from(u8::from(red < -30));
        }
        areas
    };
    let [near_px, far_px] = areas(&View::front(300, 200));
    assert!((near_px / far_px - 1.0).abs() < 0.1, "parallel rays: {near_px} {far_px}");
    let field_of_view = Angle::from_deg(40.0).expect("finite");
    let [near_px, far_px] = areas(&View::front(300, 200).perspective(field_of_view));
    // Bounds: x and z up to 13 and 3, y up to 23 from the middle; the eye stands r / sin(20 deg)
    // away. Areas go with the inverse square of the distance.
    let eye_mm =
        (13.0f64.powi(2) + 3.0f64.powi(2) + 23.0f64.powi(2)).sqrt() / 20f64.to_radians().sin();
    let expected = ((eye_mm + 20.0) / (eye_mm - 20.0)).powi(2);
    assert!((near_px / far_px / expected - 1.0).abs() < 0.1, "{near_px} {far_px} {expected}");
}

#[test]
fn views_have_the_axes_they_promise() {
    // A red bar along +x and a blue one along +z, from the origin.
    let along_x = actor(&Solid::cuboid_between([2.0, -1.0, -1.0], [20.0, 1.0, 1.0]), RED);
    let along_z = actor(&Solid::cuboid_between([-1.0, -1.0, 2.0], [1.0, 1.0, 20.0]), BLUE);
    let actors = [along_x, along_z];
    let image = render(&actors, &View::front(200, 200)).expect("an image");
    assert!(redness(image.pixel(150, 185)) > 60, "x to the right");
    assert!(redness(image.pixel(15, 60)) < -60, "z up");
    let along_y = actor(&Solid::cuboid_between([-1.0, 2.0, -1.0], [1.0, 20.0, 1.0]), BLUE);
    let actors = [actors[0].clone(), along_y];
    let image = render(&actors, &View::top(200, 200)).expect("an image");
    assert!(redness(image.pixel(150, 185)) > 60, "x to the right");
    assert!(redness(image.pixel(15, 60)) < -60, "y up");
}

#[test]
fn a_sheet_holds_all_images_in_order() {
    let flat = |width_px: u32, height_px: u32, color: [u8; 3]| RenderedImage {
        width_px,
        height_px,
        rgb: color.repeat((width_px * height_px) as usize),
    };
    let images = [flat(20, 10, RED), flat(10, 10, BLUE), flat(20, 6, RED)];
    let sheet = contact_sheet(&images, 2, 3).expect("a sheet");
    assert_eq!((sheet.width_px, sheet.height_px), (3 + 20 + 3 + 20 + 3, 3 + 10 + 3 + 10 + 3));
    assert_eq!(sheet.pixel(3, 3), RED);
    assert_eq!(sheet.pixel(22, 12), RED);
    let paper = sheet.pixel(0, 0);
    assert_eq!(sheet.pixel(23, 3), paper);
    assert_eq!(sheet.pixel(30, 3), paper, "smaller images are centred");
    assert_eq!(sheet.pixel(31, 3), BLUE);
    assert_eq!(sheet.pixel(3, 17), paper);
    assert_eq!(sheet.pixel(3, 18), RED);
    assert_eq!(sheet.pixel(40, 20), paper, "an empty cell");
    assert_eq!(contact_sheet(&[], 2, 3), Err(RenderError::NothingToDraw));
    assert_eq!(contact_sheet(&images, 0, 3), Err(RenderError::NothingToDraw));
    let huge = contact_sheet(&images, 2, u32::MAX);
    assert!(matches!(huge, Err(RenderError::TooLarge { .. })));
}

#[test]
fn impossible_images_are_refused() {
    let ball = [actor(&Solid::sphere(1.0), RED)];
    let view = View::isometric(40, 30);
    let refused = |actors: &[Actor], view: &View| render(actors, view).expect_err("no image");
    assert_eq!(refused(&[], &view), RenderError::NothingToDraw);
    assert_eq!(
        refused(&ball, &View::isometric(0, 30)),
        RenderError::NoPixels { width_px: 0, height_px: 30 }
    );
    let too_large = refused(&ball, &View::isometric(1 << 20, 1 << 20));
    assert!(matches!(too_large, RenderError::TooLarge { .. }));
    assert!(too_large.to_string().contains(&MAX_PIXELS.to_string()));
    let half_space = [ball[0].clone(), actor(&Solid::below(0.0), BLUE)];
    assert_eq!(refused(&half_space, &view), RenderError::Unbounded { actor: 1 });
    for looking in
        [Vector3::zeros(), Vector3::new(f64::NAN, 0.0, 1.0), Vector3::x() * f64::INFINITY]
    {
        assert_eq!(refused(&ball, &View::along(looking, 40, 30)), RenderError::NoDirection);
    }
    let cut = |point, outward| refused(&ball, &view.clone().cut(point, outward));
    assert_eq!(cut(Point3::origin(), Vector3::zeros()), RenderError::BadCut);
    assert_eq!(cut(Point3::new(0.0, f64::NAN, 0.0), Vector3::x()), RenderError::BadCut);
    assert_eq!(cut(Point3::new(-5.0, 0.0, 0.0), Vector3::x()), RenderError::NothingToDraw);
    for opacity in [-0.1, 1.1, f64::NAN] {
        let actors = [ball[0].clone().with_opacity(opacity)];
        assert!(matches!(refused(&actors, &view), RenderError::Opacity { actor: 0, .. }));
    }
    for degrees in [0.5, 121.0] {
        let field_of_view = Angle::from_deg(degrees).expect("finite");
        let wide = view.clone().perspective(field_of_view);
        assert!(matches!(refused(&ball, &wide), RenderError::FieldOfView { .. }));
    }
    let margin = View { margin: 0.5, ..view.clone() };
    assert_eq!(refused(&ball, &margin), RenderError::Margin { margin: 0.5 });
}

#[test]
fn even_the_smallest_image_is_drawn() {
    let ball = [actor(&Solid::sphere(1.0), RED)];
    let image = render(&ball, &View::isometric(1, 1)).expect("an image");
    assert!(redness(image.pixel(0, 0)) > 0);
}

/// A camera counts pixels from the centre of the first one: asked for a pixel, it is asked for whole coordinates.
#[test]
fn a_camera_is_asked_for_the_centres_of_its_pixels() {
    let asked = Mutex::new(Vec::new());
    let look = |(): &mut (), place: [f64; 2]| {
        asked.lock().unwrap().push(place);
        PixelContent::Plain([0; 3])
    };
    render_camera_view(&[], &Pose::identity(), [5, 3], || (), look, &|_, _| {}).unwrap();
    let mut asked = asked.into_inner().unwrap();
    asked.sort_by(|a, b| a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0])));
    let centres = (0..15).map(|i| [f64::from(i % 5), f64::from(i / 5)]);
    assert_eq!(asked, centres.collect::<Vec<_>>());
}

/// A pinhole whose principal point is the image's centre sees a ball on its axis: the image is its own mirror image, but
/// for the shading.
#[test]
fn what_lies_on_the_axis_is_in_the_middle_of_the_image() {
    let ball = actor(&Solid::sphere(2.0), RED).placed(Pose::translation(0.0, 0.0, 10.0));
    // 16 x 16 pixels: the centre lies between the eighth and the ninth. The edge at 0.2041 rad is 6.6 pixels from it.
    let look = |(): &mut (), [x_px, y_px]: [f64; 2]| {
        let direction = Vector3::new((x_px - 7.5) / 32.0, (y_px - 7.5) / 32.0, 1.0).normalize();
        PixelContent::Along(Ray { origin: Point3::origin(), direction })
    };
    let image = render_camera_view(&[ball], &Pose::identity(), [16, 16], || (), look, &|_, _| {});
    let image = image.unwrap();
    // The background is shaded from row to row.
    let is_red = |x: u32, y: u32| image.pixel(x, y) != image.pixel(0, y);
    let red: Vec<u32> = (0..16).filter(|x| is_red(*x, 7)).collect();
    assert_eq!(red, (15 - red[red.len() - 1]..=15 - red[0]).collect::<Vec<_>>());
    for (x, y) in (0..16).flat_map(|y| (0..16).map(move |x| (x, y))) {
        assert_eq!(is_red(x, y), is_red(15 - x, y), "{x} {y}");
        assert_eq!(is_red(x, y), is_red(x, 15 - y), "{x} {y}");
    }
}
