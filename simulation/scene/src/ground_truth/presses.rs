//! From presses to what rays meet, and how deep they go.

use fabkit_depth::truth::{DepthMap, Presser};
use fabkit_fixtures::Press;
use fabkit_geometry::{InvalidSolid, Point3, TouchSurface};

/// The deepest place of a press that the camera sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deepest {
    /// Below the untouched surface, along its normal, mm.
    pub depth_mm: f64,
    /// Where, sensor frame, mm.
    pub point_in_sensor: Point3<f64>,
    /// Which body: a label of the map.
    pub label: u16,
}

/// The bodies of a press, prepared. Bodies of several presses at once get their IDs in front of
/// their names.
///
/// # Errors
/// A solid that is none.
pub fn pressers(presses: &[Press]) -> Result<Vec<Presser>, InvalidSolid> {
    let mut pressers = Vec::new();
    for press in presses {
        for body in &press.bodies {
            let name = match presses {
                [_] => body.name.clone(),
                _ => format!("{} {}", press.id, body.name),
            };
            pressers.push(Presser::new(name, &body.solid, body.sensor_from_body)?);
        }
    }
    Ok(pressers)
}

/// The deepest contact of a map; `None` without contact.
pub fn deepest(map: &DepthMap, touch: &TouchSurface) -> Option<Deepest> {
    let in_contact = map.contact().zip(map.point_in_sensor()).zip(map.label());
    let depths = in_contact.filter(|((contact, _), _)| *contact).map(|((_, point), label)| {
        let (depth_mm, _) = touch.depth_mm(&point);
        Deepest { depth_mm, point_in_sensor: point, label: *label }
    });
    depths.max_by(|a, b| a.depth_mm.total_cmp(&b.depth_mm))
}
