//! Triangles of all parts.

use fabkit_geometry::Sensor;
use fabkit_mesh::mesh;

use super::Computed;

/// Largest distance between triangles and surface, mm: coarser than `export`, to be fast.
const TOLERANCE_MM: f64 = 0.05;

pub(super) fn compute(sensor: &Sensor, computed: &mut Computed) {
    let (mut triangles, mut volume_mm3, mut area_mm2) = (0, 0.0, 0.0);
    for part in &sensor.parts {
        match mesh(&part.solid, TOLERANCE_MM).and_then(|mesh| mesh.to_print()) {
            Ok(mesh) => {
                triangles += mesh.triangles().len();
                volume_mm3 += f64::from(part.quantity) * mesh.volume_mm3();
                area_mm2 += f64::from(part.quantity) * mesh.area_mm2();
            }
            Err(error) => return computed.notes.push(format!("mesh of {}: {error}", part.name)),
        }
    }
    computed.put("mesh_triangles", triangles as f64);
    computed.put("mesh_volume_mm3", volume_mm3);
    computed.put("mesh_area_mm2", area_mm2);
}
