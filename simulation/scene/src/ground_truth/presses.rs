//! Conversion of presses to ray-traced bodies, and the deepest visible contact.

use fabkit_depth::ground_truth::{DepthMap, PlacedIndenter};
use fabkit_fixtures::Press;
use fabkit_geometry::{InvalidSolid, Point3, TouchSurface};

/// Deepest point of contact that the camera sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeepestContact {
    /// Depth below the undeformed surface along its normal, mm.
    pub depth_mm: f64,
    /// The point, sensor frame, mm.
    pub point_in_sensor: Point3<f64>,
    /// Label of the body in the depth map.
    pub label: u16,
}

/// Compiles the bodies of presses for ray tracing. With several presses, body names are prefixed with the press's
/// identifier.
///
/// # Errors
/// Returns an error if a solid is not valid.
///
/// ```
/// use fabkit_geometry::Point3;
/// use fabkit_scene::ground_truth::compile_indenters;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// let presses = [project.press("hemisphere@0deg,0deg,1mm")?, project.press("hemisphere@90deg,0deg,1mm")?];
/// let indenters = compile_indenters(&presses)?;
/// // The dome's apex is at z = 21 mm; the first hemisphere reaches down to 20 mm.
/// assert!(indenters[0].contains(&Point3::new(0.0, 0.0, 20.5)));
/// assert!(!indenters[1].contains(&Point3::new(0.0, 0.0, 20.5)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn compile_indenters(presses: &[Press]) -> Result<Vec<PlacedIndenter>, InvalidSolid> {
    let mut indenters = Vec::new();
    for press in presses {
        for body in &press.bodies {
            let name = match presses {
                [_] => body.name.clone(),
                _ => format!("{} {}", press.id, body.name),
            };
            indenters.push(PlacedIndenter::new(name, &body.solid, body.sensor_from_body)?);
        }
    }
    Ok(indenters)
}

/// Finds the deepest contact in a depth map; `None` without contact.
pub fn find_deepest_contact(map: &DepthMap, touch: &TouchSurface) -> Option<DeepestContact> {
    let in_contact = map.contact().zip(map.point_in_sensor()).zip(map.label());
    let depths = in_contact.filter(|((contact, _), _)| *contact).map(|((_, point), label)| {
        let (depth_mm, _) = touch.depth_mm(&point);
        DeepestContact { depth_mm, point_in_sensor: point, label: *label }
    });
    depths.max_by(|a, b| a.depth_mm.total_cmp(&b.depth_mm))
}
