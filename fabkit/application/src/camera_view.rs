//! Images of a camera's view: its rays in a section of the sensor, and its own image.

use fabkit_camera::Point2;
use fabkit_depth::{
    Framing, PixelContent, RenderedImage, View, render_camera_view, render_with_framing,
};
use fabkit_files::progress::{ProgressCallback, report_counts};
use fabkit_geometry::{Assembly, OpticalClarity, Point3, Ray, Sensor, Vector3};
use fabkit_optics::{OpticalStack, RayEnd, Tracer};
use fabkit_scene::SceneError;
use fabkit_scene::ground_truth::Viewpoint;
use fabkit_scene::legend::{self, LegendEntry};

use crate::images::{
    self, DrawingError, ImageView, ViewDirection, assembly_actors, section_normal,
};

/// Number of rays in a section, evenly spread over the image.
pub const RAY_COUNT: usize = 41;

/// Length to which escaping rays are drawn, mm.
pub(crate) const MAX_RAY_MM: f64 = 1e3;

/// Colour of rays that reach the body or surface to be seen.
const TARGET_COLOR: [u8; 3] = [18, 140, 70];
/// Colour of total reflection. A mirror image is no ground truth.
const REFLECTION_COLOR: [u8; 3] = [176, 40, 168];
/// Colour of rays that leave the sensor.
const ESCAPED_COLOR: [u8; 3] = [112, 116, 126];
/// Colours of obstructing bodies, in the order in which they are first hit.
const OBSTACLE_COLORS: [[u8; 3]; 6] =
    [[228, 108, 10], [204, 32, 44], [36, 98, 204], [134, 84, 40], [0, 146, 164], [150, 140, 0]];

/// Ray of a camera, from the pupil to its end.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnRay {
    /// Column and row, px.
    pub pixel: [f64; 2],
    /// Body at its end, named as in `seen_by` of ground truth.
    pub seen_by: String,
    /// Start, refractions and end in the sensor frame, mm. A ray without an end is followed for a metre.
    pub path_mm: Vec<[f64; 3]>,
}

/// Builds the stack of the sensor's bodies for tracing the camera's rays.
///
/// # Errors
/// Bodies through which no light can be traced.
pub fn build_stack(sensor: &Sensor, viewpoint: &Viewpoint) -> Result<OpticalStack, SceneError> {
    viewpoint.stack(sensor).map_err(SceneError::Light)
}

/// Draws the sensor cut through the camera's pupil, with its rays in that plane, as PNG.
///
/// # Errors
/// [`DrawingError`]; also if the view is along the camera's axis.
///
/// ```
/// use fabkit_application::camera_view::{RAY_COUNT, build_stack, draw_rays};
/// use fabkit_application::{ground_truth::Viewpoint, images::ImageView, progress::ignore_progress, source::Target};
///
/// let sensor = Target::new("9dtact").design(&[])?.sensor;
/// let viewpoint = Viewpoint::new(&sensor.camera, None, None)?;
/// let stack = build_stack(&sensor, &viewpoint)?;
/// let shot = ImageView { size_px: [160, 120], is_section: true, from: None };
/// let (png, rays) = draw_rays(&sensor, &viewpoint, &stack, shot, &ignore_progress)?;
/// assert_eq!(png[1..4], *b"PNG");
/// assert_eq!(rays.len(), RAY_COUNT);
/// // The ray in the middle goes from the pupil, which is on the sensor's axis, up to the surface.
/// let middle = &rays[RAY_COUNT / 2];
/// assert_eq!((middle.path_mm[0][..2].to_vec(), &*middle.seen_by), (vec![0.0; 2], "surface"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn draw_rays(
    sensor: &Sensor,
    viewpoint: &Viewpoint,
    stack: &OpticalStack,
    shot: ImageView,
    progress: ProgressCallback,
) -> Result<(Vec<u8>, Vec<DrawnRay>), DrawingError> {
    let [width_px, height_px] = shot.size_px;
    let ViewDirection { azimuth_deg, elevation_deg } =
        shot.from.unwrap_or(ViewDirection { azimuth_deg: -90.0, elevation_deg: 0.0 });
    let view = View::from_side(azimuth_deg, elevation_deg, width_px, height_px);
    let outward = section_normal(&view);
    let rays = trace_plane_rays(viewpoint, stack, &outward)?;
    let pupil = viewpoint.sensor_from_camera.point(Point3::origin());
    let actors = assembly_actors(sensor, &Assembly::sensor().0, false)?;
    let view = view.cut(pupil, outward);
    let (mut image, framing) = render_with_framing(&actors, &view, &report_counts(progress))?;
    draw(&mut image, &framing, &rays, sensor);
    Ok((images::encode_png(&image)?, rays))
}

/// Traces the camera's rays in the plane through its axis with the given normal.
///
/// # Errors
/// A normal along the camera's axis.
pub(crate) fn trace_plane_rays(
    viewpoint: &Viewpoint,
    stack: &OpticalStack,
    normal: &Vector3<f64>,
) -> Result<Vec<DrawnRay>, DrawingError> {
    let (camera, pose) = (viewpoint.camera(), &viewpoint.sensor_from_camera);
    // The plane contains the camera's axis and this direction, whose projection is the line of sampled pixels.
    let across = normal.cross(&pose.vector(Vector3::z()));
    let in_image = pose.inverse().vector(across).xy();
    let Some(along) = in_image.try_normalize(1e-6) else {
        let message = "the section lies across the camera's axis, so its plane contains no rays";
        return Err(DrawingError::Viewer(message.into()));
    };
    let centre = camera.image_centre_px();
    // Distance from the image's centre, along the plane, to the centres of its outermost pixels.
    let to_edge = |axis: usize| centre[axis] / along[axis].abs();
    let most_px = to_edge(0).min(to_edge(1));
    let mut tracer = Tracer::new(stack);
    let rays = (0..RAY_COUNT).filter_map(|number| {
        let at_px = most_px * (2.0 * number as f64 / (RAY_COUNT - 1) as f64 - 1.0);
        let pixel = centre + at_px * along;
        let ray = stack.enter(&pixel_ray(viewpoint, &pixel)?);
        let path = tracer.follow(&ray);
        let pupil = pose.point(Point3::origin());
        // A camera with its own refracting interface starts rays there; the pupil is then prepended to the path.
        let start = Some(pupil).filter(|pupil| (pupil - ray.origin).norm() > 0.0);
        let end = path.last.at(path.end_mm.min(MAX_RAY_MM));
        let corners = tracer.corners().iter().copied();
        let points = start.into_iter().chain(corners).chain([end]);
        Some(DrawnRay {
            pixel: pixel.into(),
            seen_by: stack.name_of(path.end).to_owned(),
            path_mm: points.map(<[f64; 3]>::from).collect(),
        })
    });
    Ok(rays.collect())
}

/// Computes the ray of a pixel as it leaves the camera, in the sensor frame; `None` outside the lens's range.
fn pixel_ray(viewpoint: &Viewpoint, pixel: &Point2<f64>) -> Option<Ray> {
    let ray = viewpoint.camera().unproject(pixel).ok()?;
    let pose = &viewpoint.sensor_from_camera;
    Some(Ray { origin: pose.point(ray.origin_in_camera), direction: pose.vector(ray.direction) })
}

/// Makes the legend: the ends of the rays in the order in which they first occur, each with a colour and a count.
fn legend_entries(rays: &[DrawnRay], sensor: &Sensor) -> Vec<LegendEntry> {
    let mut entries: Vec<LegendEntry> = Vec::new();
    for name in rays.iter().map(|ray| &ray.seen_by) {
        match entries.iter_mut().find(|entry| entry.name == *name) {
            Some(entry) => entry.count += 1,
            None => {
                let before = entries.iter().filter(|e| OBSTACLE_COLORS.contains(&e.color)).count();
                let color = end_color(name, sensor, before);
                entries.push(LegendEntry { name: name.clone(), color, count: 1 });
            }
        }
    }
    entries
}

/// Returns a colour for each ray, by its end.
pub(crate) fn ray_colors(rays: &[DrawnRay], sensor: &Sensor) -> Vec<[u8; 3]> {
    let entries = legend_entries(rays, sensor);
    let of = |ray: &DrawnRay| {
        entries
            .iter()
            .find(|entry| entry.name == ray.seen_by)
            .map_or(ESCAPED_COLOR, |entry| entry.color)
    };
    rays.iter().map(of).collect()
}

fn draw(image: &mut RenderedImage, framing: &Framing, rays: &[DrawnRay], sensor: &Sensor) {
    let entries = legend_entries(rays, sensor);
    // Lines are one pixel wide up to a height of 700 px, and grow with larger images.
    let width_px = (f64::from(image.height_px) / 700.0).max(1.0);
    let lines = rays.iter().zip(ray_colors(rays, sensor)).map(|(ray, color)| {
        let places = ray.path_mm.iter().map(|point| framing.project(&Point3::from(*point)));
        (places.collect::<Vec<_>>(), color)
    });
    let lines: Vec<(Vec<[f64; 2]>, [u8; 3])> = lines.collect();
    // White lines below all rays keep them visible on dark bodies.
    for (places, _) in &lines {
        image.draw_line(places, 2.2 * width_px, [255; 3]);
    }
    for (places, color) in &lines {
        image.draw_line(places, width_px, *color);
    }
    let texts = entries.iter().map(|entry| {
        let plural = if entry.count == 1 { "ray" } else { "rays" };
        (entry.color, format!("{}  {} {plural}", entry.name, entry.count))
    });
    legend::draw(image, &texts.collect::<Vec<_>>());
}

fn end_color(name: &str, sensor: &Sensor, bodies_before: usize) -> [u8; 3] {
    match name {
        "surface" => TARGET_COLOR,
        "total reflection" => REFLECTION_COLOR,
        "nothing" => ESCAPED_COLOR,
        body if sensor.visible_bodies.iter().any(|seen| seen == body) => TARGET_COLOR,
        _ => OBSTACLE_COLORS[bodies_before % OBSTACLE_COLORS.len()],
    }
}

/// Renders the camera's own image as PNG: each pixel shows the first opaque body or surface along its refracted ray,
/// shaded as in other images; violet where light is totally reflected.
///
/// # Errors
/// [`DrawingError`].
pub fn draw_camera_view(
    sensor: &Sensor,
    viewpoint: &Viewpoint,
    stack: &OpticalStack,
    progress: ProgressCallback,
) -> Result<Vec<u8>, DrawingError> {
    let pupil = viewpoint.sensor_from_camera.point(Point3::origin());
    let nominal = sensor.camera.sensor_from_camera.point(Point3::origin());
    let mut shown = sensor.clone();
    shown.bodies.retain(|body| body.clarity() != OpticalClarity::Clear);
    let mut actors = assembly_actors(&shown, &Assembly::sensor().0, false)?;
    // Bodies around the pupil are the camera's own and would hide everything else. The nominal pupil is tested as well,
    // because a calibrated one may lie elsewhere.
    actors.retain(|actor| {
        let own = |point: &Point3<f64>| {
            actor.body.contains(&actor.scene_from_body.inverse().point(*point))
        };
        !own(&pupil) && !own(&nominal)
    });
    let camera = viewpoint.camera();
    let look = |tracer: &mut Tracer, [x_px, y_px]: [f64; 2]| {
        let Some(ray) = pixel_ray(viewpoint, &Point2::new(x_px, y_px)) else {
            return PixelContent::Plain([0; 3]);
        };
        let path = tracer.follow(&stack.enter(&ray));
        match path.end {
            RayEnd::Surface | RayEnd::Body(_) => PixelContent::Along(path.last),
            RayEnd::TotalReflection(_) => PixelContent::Plain(REFLECTION_COLOR),
            RayEnd::Nothing => PixelContent::Plain(ESCAPED_COLOR),
        }
    };
    let image = render_camera_view(
        &actors,
        &viewpoint.sensor_from_camera,
        [camera.width_px(), camera.height_px()],
        || Tracer::new(stack),
        look,
        &report_counts(progress),
    )?;
    images::encode_png(&image)
}

#[cfg(test)]
mod tests {
    use fabkit_designs::{builtin_yaml, load};

    use super::*;

    /// The ray in the middle of a section is that of the image's centre, and runs along the axis of a camera that looks
    /// along the sensor's; the outermost ones belong to the centres of the outermost pixels.
    #[test]
    fn the_middle_of_the_rays_is_the_axis() {
        let design = load("9dtact", builtin_yaml("9dtact").unwrap(), &[], &[]).unwrap();
        let sensor = &design.sensor;
        let viewpoint = Viewpoint::new(&sensor.camera, None, None).unwrap();
        let stack = build_stack(sensor, &viewpoint).unwrap();
        let [width, height] = [viewpoint.camera().width_px(), viewpoint.camera().height_px()];
        for (normal, axis) in [(Vector3::y(), 0), (Vector3::x(), 1)] {
            let rays = trace_plane_rays(&viewpoint, &stack, &normal).unwrap();
            let middle = &rays[RAY_COUNT / 2];
            // Columns from 0 to width - 1: half-way is (width - 1) / 2.
            let last = [width, height].map(|px| f64::from(px) - 1.0);
            assert!((0..2).all(|k| (middle.pixel[k] - last[k] / 2.0).abs() < 1e-9), "{middle:?}");
            let off = |point: &[f64; 3]| point[0].hypot(point[1]);
            // Rounding of a pixel, 1e-13 of its size, over some tens of millimetres.
            assert!(middle.path_mm.iter().all(|point| off(point) < 1e-9), "{middle:?}");
            let ends = [rays[0].pixel[axis], rays[RAY_COUNT - 1].pixel[axis]];
            let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            assert!(low.abs() < 1e-9 && (high - last[axis]).abs() < 1e-9, "{low} {high} {last:?}");
        }
    }
}
