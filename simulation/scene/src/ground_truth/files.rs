//! Conversion of depth maps to arrays, images and point clouds.

use fabkit_depth::RenderedImage;
use fabkit_depth::ground_truth::{DepthMap, SURFACE_LABEL, StandardDeviations, false_color};
use fabkit_export::{
    CloudPoint, ExportError, NpyArray, NpyValues, PointCloud, float_tiff, grey16_png,
};

/// Range per intensity step of 16-bit images, mm: 1 um, so that they reach to 65 mm.
pub const GREY_STEP_MM: f64 = 0.001;

/// Quantity that an image or a TIFF shows, mm.
///
/// ```
/// use fabkit_scene::Cast;
/// use fabkit_scene::ground_truth::MapQuantity;
/// use fabkit_scene::press_simulation::ContactModel;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let viewpoint = viewpoint.resized([40, 30])?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// scene.cast(&Cast::at_rest(ContactModel::Rigid), 0, |seen| {
///     // Without contact, the indentation is 0 where the surface is seen, and NaN elsewhere.
///     let indentation_mm = MapQuantity::Indentation.values_mm(seen.map, seen.sigmas);
///     assert_eq!(indentation_mm.len(), 40 * 30);
///     assert_eq!(indentation_mm.iter().filter(|mm| **mm == 0.0).count(), seen.surface_px);
///     Ok::<_, fabkit_files::Error>(())
/// })?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapQuantity {
    /// Distance along the ray.
    Range,
    /// Third coordinate in the camera frame.
    Z,
    /// Range without contact minus range with contact.
    Indentation,
    /// Standard deviation of the range.
    Sigma,
}

impl MapQuantity {
    /// Returns the quantity pixel by pixel, mm.
    pub fn values_mm(self, map: &DepthMap, sigmas: &StandardDeviations) -> Vec<f64> {
        match self {
            Self::Range => map.range_mm().to_vec(),
            Self::Z => map.z_mm().collect(),
            Self::Indentation => map.indentation_mm().collect(),
            Self::Sigma => sigmas.range_mm().collect(),
        }
    }
}

/// Returns all maps of a press as arrays for `numpy.load`. They have rows x columns, vectors a third axis of 3.
///
/// ```
/// use fabkit_scene::Cast;
/// use fabkit_scene::ground_truth::arrays;
/// use fabkit_scene::press_simulation::ContactModel;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let viewpoint = viewpoint.resized([40, 30])?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// let arrays = scene.cast(&Cast::at_rest(ContactModel::Rigid), 0, |seen| {
///     Ok::<_, fabkit_files::Error>(arrays(seen.map, seen.sigmas))
/// })?;
/// let shape = |name| arrays.iter().find(|array| array.name == name).map(|array| array.shape.clone());
/// assert_eq!(shape("range_mm"), Some(vec![30, 40]));
/// assert_eq!(shape("point_in_sensor"), Some(vec![30, 40, 3]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn arrays(map: &DepthMap, sigmas: &StandardDeviations) -> Vec<NpyArray> {
    let shape = vec![map.height_px() as usize, map.width_px() as usize];
    let array = |name: &str, values| NpyArray { name: name.into(), shape: shape.clone(), values };
    let vectors = |name: &str, values: Vec<f64>| NpyArray {
        name: name.into(),
        shape: vec![shape[0], shape[1], 3],
        values: NpyValues::F64(values),
    };
    let points = map.point_in_sensor().flat_map(|p| [p.x, p.y, p.z]).collect();
    let normals = map.normal_in_sensor().iter().flat_map(|n| [n.x, n.y, n.z]).collect();
    let names = |name: &str, names: Vec<String>| NpyArray {
        name: name.into(),
        shape: vec![names.len()],
        values: NpyValues::Text(names),
    };
    let (seen_by, seen_by_names) = map.seen_by();
    vec![
        array("range_mm", NpyValues::F64(map.range_mm().to_vec())),
        array("z_mm", NpyValues::F64(map.z_mm().collect())),
        vectors("point_in_sensor", points),
        vectors("normal_in_sensor", normals),
        array("label", NpyValues::U16(map.label().to_vec())),
        array("indentation_mm", NpyValues::F64(map.indentation_mm().collect())),
        array("contact", NpyValues::Bool(map.contact().collect())),
        array("incidence_rad", NpyValues::F64(map.incidence_rad().collect())),
        array("sigma_mm", NpyValues::F64(sigmas.range_mm().collect())),
        array("point_sigma_mm", NpyValues::F64(sigmas.point_mm().collect())),
        array("indentation_sigma_mm", NpyValues::F64(sigmas.indentation_mm().collect())),
        array("normal_sigma_rad", NpyValues::F64(sigmas.normal_rad().collect())),
        names("label_names", map.names().to_vec()),
        array("seen_by", NpyValues::U8(seen_by)),
        names("seen_by_names", seen_by_names),
    ]
}

/// Draws values in false colours with a scale beside them. The scale spans the values.
pub fn false_color_image(width_px: u32, values_mm: &[f64]) -> RenderedImage {
    false_color(width_px, values_mm, None)
}

/// Encodes values as 16-bit greyscale PNG with [`GREY_STEP_MM`] per step, rounded. Intensity 0 means no value.
///
/// # Errors
/// [`ExportError`].
pub fn grey(width_px: u32, height_px: u32, values_mm: &[f64]) -> Result<Vec<u8>, ExportError> {
    // The cast to `u16` saturates and turns NaN into 0.
    let step = |mm: &f64| (mm / GREY_STEP_MM).round() as u16;
    grey16_png(width_px, height_px, &values_mm.iter().map(step).collect::<Vec<u16>>())
}

/// Encodes values as 32-bit floating-point TIFF. NaN means no value.
///
/// # Errors
/// [`ExportError`].
pub fn encode_tiff(
    width_px: u32,
    height_px: u32,
    values_mm: &[f64],
) -> Result<Vec<u8>, ExportError> {
    float_tiff(width_px, height_px, &values_mm.iter().map(|mm| *mm as f32).collect::<Vec<f32>>())
}

/// Creates an empty point cloud in the sensor frame.
pub fn empty_cloud() -> PointCloud {
    PointCloud::new("sensor frame, mm; label 1 is the surface, from 2 on what presses")
}

/// Adds one point for each pixel that sees the surface, coloured by its label.
pub fn add_points(map: &DepthMap, cloud: &mut PointCloud) {
    let pixels = map.point_in_sensor().zip(map.normal_in_sensor()).zip(map.label());
    for ((point, normal), &label) in pixels.filter(|((point, _), _)| point.x.is_finite()) {
        cloud.push(&CloudPoint {
            position_mm: point.into(),
            normal: normal.into(),
            color: color(label),
            label,
        });
    }
}

/// Returns grey for the surface, and for each indenter a hue one golden section from the last one: such hues stay
/// distinct for any number of labels.
fn color(label: u16) -> [u8; 3] {
    if label <= SURFACE_LABEL {
        return [170, 172, 178];
    }
    let hue = 6.0 * (f64::from(label) * 0.618_033_988_749_895).fract();
    // Trapezoidal response of one channel over the hue circle, which has length 6.
    let part = |from: f64| ((hue - from).rem_euclid(6.0) - 3.0).abs() - 1.0;
    [0.0, 2.0, 4.0].map(|from| (60.0 + 180.0 * part(from).clamp(0.0, 1.0)) as u8)
}
