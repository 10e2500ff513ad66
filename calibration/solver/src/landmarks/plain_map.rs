//! Plain maps `{"1": [0, 0, 20.5], ...}` from hole number to contact, as labs write them by hand.

use std::collections::BTreeSet;

use fabkit_geometry::{Point3, Vector3};
use fabkit_text::InvalidDocument;
use nalgebra::{DMatrix, DVector};
use serde_json::{Map, Value};

use super::{DOCUMENT, PinLandmark, PinLandmarks, UNNAMED_KIND};

/// Tolerance for points to lie on a sphere, mm: maps are rounded to 0.01 mm.
const SPHERE_TOLERANCE_MM: f64 = 0.05;

/// Largest map, bytes. It is small because each key is searched for in the whole text.
const MAX_BYTES: usize = 1 << 20;

/// Reads the map. `text` is searched for duplicate keys, which the JSON parser merges silently.
pub(super) fn read(
    text: &str,
    object: &Map<String, Value>,
) -> Result<PinLandmarks, InvalidDocument> {
    if text.len() > MAX_BYTES {
        let what =
            format!("{} bytes of a map without `format`; the limit is {MAX_BYTES}", text.len());
        return Err(DOCUMENT.refuse(&what));
    }
    let mut problems = Vec::new();
    let mut points: Vec<(u32, Point3<f64>)> = Vec::new();
    for (key, value) in object {
        let hole = key.parse::<u32>().ok().filter(|hole| *hole > 0);
        let point = serde_json::from_value::<[f64; 3]>(value.clone());
        match (hole, point) {
            (Some(hole), Ok(point)) => points.push((hole, point.into())),
            (None, _) => problems.push(format!(
                "\"{key}\" is not the number of a hole, and no `format` says what else this is"
            )),
            (_, Err(_)) => {
                // The value is shown, because it is often a nested or shorter list.
                problems.push(format!("hole {key}: expected [x, y, z] in mm, found {value}"));
            }
        }
        if text.matches(&format!("\"{key}\"")).count() > 1 {
            problems.push(format!("hole {key} stands there twice"));
        }
    }
    // The keys "1" and "01" differ as text, but name the same hole.
    let distinct: BTreeSet<u32> = points.iter().map(|(hole, _)| *hole).collect();
    if distinct.len() < points.len() {
        problems.push("a hole stands there twice, written differently".into());
    }
    DOCUMENT.accept(problems)?;
    let centre = common_centre(&points);
    let pins = points
        .into_iter()
        .map(|(hole, contact)| PinLandmark {
            hole,
            kind: UNNAMED_KIND.into(),
            tip_centre_in_sensor_mm: contact,
            contact_in_sensor_mm: contact,
            axis_in_sensor: centre.map(|centre| (centre - contact).normalize()),
        })
        .collect();
    PinLandmarks::new("", "", 0.0, pins)
}

/// Finds the centre of the sphere on which all points lie, if they do and it is unique.
fn common_centre(points: &[(u32, Point3<f64>)]) -> Option<Point3<f64>> {
    // Four points always lie on a sphere.
    if points.len() < 5 {
        return None;
    }
    // |p|^2 = 2 c.p + (r^2 - |c|^2) is linear in c and the last term.
    let rows = DMatrix::from_fn(points.len(), 4, |i, j| match j {
        3 => 1.0,
        _ => 2.0 * points[i].1[j],
    });
    let squares = DVector::from_iterator(
        points.len(),
        points.iter().map(|(_, point)| point.coords.norm_squared()),
    );
    let svd = rows.svd(true, true);
    let largest = svd.singular_values.max();
    // Points in a plane lie on many spheres.
    let unique = svd.singular_values.min() > 1e-6 * largest;
    let solution = svd.solve(&squares, 0.0).ok().filter(|_| unique)?;
    let centre = Point3::from(Vector3::new(solution[0], solution[1], solution[2]));
    let radius_mm = (solution[3] + centre.coords.norm_squared()).sqrt();
    let on_sphere = |(_, point): &(u32, Point3<f64>)| {
        ((point - centre).norm() - radius_mm).abs() < SPHERE_TOLERANCE_MM
    };
    points.iter().all(on_sphere).then_some(centre)
}
