//! Camera of a robot description: a pinhole that replaces the real one, and the map between their images.

use std::sync::Arc;

use fabkit_camera::files::{self, CameraFormat};
use fabkit_camera::{Camera, Interface, Intrinsics, Lens, OpenCv, Point2};
use fabkit_export::{NpyArray, NpyValues, RobotCamera, npz};
use fabkit_files::Error;
use fabkit_geometry::{Point3, Ray, Scratch, Sensor, Vector3};
use fabkit_optics::{RayEnd, SensingSurface, Tracer, ViewStacks};
use fabkit_scene::ground_truth::Viewpoint;

/// Largest half angle of the pinhole, degrees: beyond it an image consists mostly of its stretched edge.
const MAX_HALF_VIEW_DEG: f64 = 70.0;
/// Largest side of the pinhole's image, px.
const MAX_SIDE_PX: f64 = 4096.0;
/// Distance of the pinhole's near plane, mm.
const NEAR_MM: f64 = 1.0;
/// Distance assigned to rays that meet nothing, mm.
const FAR_MM: f64 = 1e3;

/// Points that the pixels show at rest.
pub(super) struct PixelPoints {
    /// Numbers of columns and rows.
    size_px: [u32; 2],
    /// Rays behind all refracting bodies; `None` outside the lens's image.
    rays: Vec<Option<Ray>>,
    /// Points where rays meet the touched surface, or else where they end, camera frame, mm.
    points_in_camera: Vec<Option<Point3<f64>>>,
}

impl PixelPoints {
    /// Traces the pixels of a designed camera.
    pub fn trace(
        sensor: &Sensor,
        viewpoint: &Viewpoint,
        sights: &Arc<ViewStacks>,
    ) -> Result<Self, Error> {
        let touch =
            sensor.touch.as_ref().map(SensingSurface::new).transpose().map_err(Error::bug)?;
        let rays = viewpoint.rays(1).traced_through(sights);
        let rays: Vec<Option<Ray>> = (0..rays.len()).map(|i| rays.ray(i)).collect();
        let camera_from_sensor = viewpoint.sensor_from_camera.inverse();
        let mut scratch = Scratch::default();
        let mut tracer = Tracer::new(sights.stack());
        let mut met = |ray: &Ray| {
            let path = tracer.follow(ray);
            let leaves = touch.as_ref().filter(|_| path.end == RayEnd::Surface);
            let leaves = leaves.and_then(|touch| touch.exit(ray, &mut scratch));
            let range_mm = leaves.map_or(path.end_mm.min(FAR_MM), |(mm, _)| mm);
            camera_from_sensor.point(ray.origin + range_mm * ray.direction)
        };
        let places_in_camera = rays.iter().map(|ray| ray.as_ref().map(&mut met)).collect();
        let camera = viewpoint.camera();
        Ok(Self {
            size_px: [camera.width_px(), camera.height_px()],
            rays,
            points_in_camera: places_in_camera,
        })
    }

    /// Computes the pinhole at the same position that is as sharp in the middle of the image, and as wide as necessary.
    pub fn pinhole(&self, viewpoint: &Viewpoint, frame: &str) -> RobotCamera {
        let camera = viewpoint.camera();
        let width = f64::from(self.size_px[0]);
        let middle = camera.image_centre_px();
        let way =
            |x: f64| camera.unproject(&Point2::new(x, middle[1])).ok().map(|ray| ray.direction);
        let apart = way(middle[0] - 0.5).zip(way(middle[0] + 0.5)).map(|(a, b)| a.angle(&b));
        // A lens that does not reach the middle of its image is no real one; any value will do.
        let sharp_px = apart.filter(|rad| *rad > 0.0).map_or(width, |rad| 0.5 / (rad / 2.0).tan());
        let most = MAX_HALF_VIEW_DEG.to_radians().tan();
        let reach = |of: fn(&Point3<f64>) -> f64| {
            let each = self.points_in_camera.iter().flatten();
            let slope =
                // Points beside or behind the camera have no slope: the widest view is taken.
                each.map(|place| if place.z > 0.0 { (of(place) / place.z).abs() } else { most });
            slope.fold(0.0, f64::max).min(most)
        };
        let reaches = [reach(|place| place.x), reach(|place| place.y)];
        // If the image would be too large, the focal length is reduced instead of the view.
        let half_px = reaches[0].max(reaches[1]) * sharp_px;
        let focal_px = sharp_px * (MAX_SIDE_PX / 2.0 / half_px).min(1.0);
        // Half a pixel more on each side, and the same number on the left and on the right.
        let size = |reach: f64| 2 * ((reach * focal_px - 1e-6).ceil().max(1.0) as u32);
        RobotCamera {
            frame: frame.to_owned(),
            sensor_from_camera: viewpoint.sensor_from_camera,
            size_px: reaches.map(size),
            focal_px,
            near_mm: NEAR_MM,
        }
    }

    /// Writes `robot-camera.yaml`: the pinhole in the format of ROS's `camera_info`, which `fabkit --camera` reads too.
    pub fn yaml(pinhole: &RobotCamera) -> Result<String, Error> {
        let [cx_px, cy_px] = pinhole.middle_px();
        let intrinsics =
            Intrinsics { fx_px: pinhole.focal_px, fy_px: pinhole.focal_px, cx_px, cy_px };
        let lens = Lens::OpenCv(OpenCv::new(intrinsics, &[]).map_err(Error::bug)?);
        let [width, height] = pinhole.size_px;
        let camera = Camera::new(width, height, lens, Interface::None).map_err(Error::bug)?;
        files::write(&camera.into(), CameraFormat::Ros).map_err(Error::bug)
    }

    /// Writes `robot-rays.npz`: the point where each pixel's ray leaves the last refracting body, mm, and its
    /// direction, sensor frame, rows x columns x 3; and the pinhole's pixel of the point that the pixel shows at rest,
    /// rows x columns x 2, column and row; NaN outside the pinhole's image.
    pub fn npz(&self, pinhole: &RobotCamera) -> Result<Vec<u8>, Error> {
        let [width, height] = self.size_px.map(|px| px as usize);
        let unknown = [f64::NAN; 3];
        let origins =
            self.rays.iter().map(|ray| ray.map_or(unknown, |ray| ray.origin.coords.into()));
        let ways = self
            .rays
            .iter()
            .map(|ray| ray.map_or(unknown, |ray| <Vector3<f64>>::into(ray.direction)));
        let seen =
            |place: &Option<Point3<f64>>| pinhole.project_into_image(place.as_ref()?.coords.into());
        let pixels = self.points_in_camera.iter().map(|place| seen(place).unwrap_or([f64::NAN; 2]));
        let array = |name: &str, of_each: usize, values: NpyValues| NpyArray {
            name: name.to_owned(),
            shape: vec![height, width, of_each],
            values,
        };
        let arrays = [
            array(
                "origin_in_sensor_mm",
                3,
                NpyValues::F32(origins.flatten().map(|mm| mm as f32).collect()),
            ),
            array(
                "direction_in_sensor",
                3,
                NpyValues::F32(ways.flatten().map(|part| part as f32).collect()),
            ),
            // In the form that `cv2.remap` needs.
            array("pinhole_px", 2, NpyValues::F32(pixels.flatten().map(|px| px as f32).collect())),
        ];
        npz(&arrays).map_err(Error::bug)
    }

    /// Computes the fraction of the image that the pinhole shows: 1 is everything that the lens reaches.
    pub fn shown_fraction(&self, pinhole: &RobotCamera) -> f64 {
        let reached = self.points_in_camera.iter().flatten();
        let is_seen =
            |place: &&Point3<f64>| pinhole.project_into_image(place.coords.into()).is_some();
        let (seen, all) = (reached.clone().filter(is_seen).count(), reached.count());
        if all == 0 { 0.0 } else { seen as f64 / all as f64 }
    }
}
