//! Options and results of casts.

use fabkit_depth::ground_truth::{DepthMap, StandardDeviations};
use fabkit_fixtures::Press;

use crate::SceneError;
use crate::ground_truth::DeepestContact;
use crate::press_simulation::{ContactGap, ContactModel, ContactSolution};

/// Options of one cast.
///
/// ```
/// use fabkit_scene::Cast;
/// use fabkit_scene::press_simulation::ContactModel;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let viewpoint = viewpoint.resized([40, 30])?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// // Four rays per pixel; a sigma of the print gives every ray a standard deviation.
/// let rest = Cast::at_rest(ContactModel::Rigid);
/// let cast = Cast { samples: 2, print_sigma_mm: 0.05, ..rest };
/// scene.cast(&cast, 0, |seen| {
///     assert_eq!([seen.map.width_px(), seen.map.height_px()], [80, 60]);
///     assert!(seen.deepest.is_none() && seen.answer.is_none());
///     Ok::<_, fabkit_files::Error>(())
/// })?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Cast<'a> {
    /// Presses in contact at the same time; empty for the reference without contact.
    pub presses: &'a [Press],
    /// Number of rays along each side of a pixel.
    pub samples: u32,
    /// Contact model of the surface.
    pub contact: ContactModel,
    /// Displacement of all indenters along the surface after indentation, mm, as for
    /// [`solve_contact`](crate::press_simulation::ElasticSolver::solve_contact). Only elastic
    /// contact supports it.
    pub shear_mm: [f64; 2],
    /// Standard deviation of printed and cast surfaces along their normals, mm.
    pub print_sigma_mm: f64,
    /// Accepts presses that miss the surface, or touch it only where the camera sees nothing of it.
    pub allow_no_contact: bool,
}

impl Cast<'_> {
    /// Returns a cast without presses: one ray per pixel and no uncertainty of shape.
    pub fn at_rest(contact: ContactModel) -> Self {
        Self {
            presses: &[],
            samples: 1,
            contact,
            shear_mm: [0.0; 2],
            print_sigma_mm: 0.0,
            allow_no_contact: true,
        }
    }
}

/// Result of a cast, or of one band of rows of it.
#[derive(Clone, Copy, Debug)]
pub struct CastResult<'a> {
    /// Depth map with labels, points and normals.
    pub map: &'a DepthMap<'a>,
    /// Standard deviations of the map's values.
    pub sigmas: &'a StandardDeviations,
    /// Deepest contact that the camera sees; `None` without contact.
    pub deepest: Option<DeepestContact>,
    /// Number of pixels that see the surface.
    pub surface_px: usize,
    /// Solution of the elastic layers; `None` for other contact models and without contact.
    pub answer: Option<&'a ContactSolution<'a>>,
    /// Difference between elastic and rigid contact; present if `answer` is.
    pub gap: Option<ContactGap>,
}

/// Checks that a length lies within its limits.
///
/// # Errors
/// Returns an error for a value outside its limits, and for NaN.
///
/// ```
/// use fabkit_scene::{MEMBRANE_LIMITS_MM, check_length};
/// assert!(check_length("membrane", 10.0, MEMBRANE_LIMITS_MM).is_ok());
/// assert!(check_length("membrane", -0.1, MEMBRANE_LIMITS_MM).is_err());
/// assert!(check_length("membrane", f64::NAN, MEMBRANE_LIMITS_MM).is_err());
/// ```
pub fn check_length(
    name: &'static str,
    value_mm: f64,
    limits_mm: [f64; 2],
) -> Result<(), SceneError> {
    let [least, most] = limits_mm;
    // NaN is in no range and is refused as well.
    if (least..=most).contains(&value_mm) {
        return Ok(());
    }
    Err(SceneError::Length { name, value_mm, limits_mm })
}
