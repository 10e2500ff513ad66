//! Metrics of the parts' meshes.

use std::collections::BTreeMap;
use std::sync::Mutex;

use fabkit_geometry::{Sensor, Solid};
use fabkit_mesh::{MeshError, mesh};

use super::ComputedMetrics;

/// Largest distance between triangles and surface, mm: coarser than for `export`, to be fast.
const TOLERANCE_MM: f64 = 0.05;

/// Largest total size of all cached keys, numbers: 32 MB.
const MAX_KEY_NUMBERS: usize = 4_000_000;

/// Measurements of a mesh.
#[derive(Clone, Copy, Debug)]
struct MeshMeasures {
    triangles: usize,
    volume_mm3: f64,
    area_mm2: f64,
}

/// Cache of measurements of parts that variants share, by their shapes.
#[derive(Debug, Default)]
pub(super) struct MeshCache(Mutex<CachedMeshes>);

#[derive(Debug, Default)]
struct CachedMeshes {
    by_shape: BTreeMap<Vec<u64>, MeshMeasures>,
    numbers: usize,
}

impl MeshCache {
    /// Returns the measurements of a solid's mesh, from the cache if possible.
    fn measured(&self, solid: &Solid) -> Result<MeshMeasures, MeshError> {
        let key = solid.shape_key();
        let known = self.0.lock().ok().and_then(|known| known.by_shape.get(&key).copied());
        if let Some(known) = known {
            return Ok(known);
        }
        let mesh = mesh(solid, TOLERANCE_MM)?.to_print()?;
        let measured = MeshMeasures {
            triangles: mesh.triangles().len(),
            volume_mm3: mesh.volume_mm3(),
            area_mm2: mesh.area_mm2(),
        };
        if let Ok(mut known) = self.0.lock()
            // A full cache only makes later variants slower.
            && known.numbers + key.len() <= MAX_KEY_NUMBERS
        {
            known.numbers += key.len();
            known.by_shape.insert(key, measured);
        }
        Ok(measured)
    }
}

/// Computes the group's metrics; a part that cannot be meshed leaves a note.
pub(super) fn compute(sensor: &Sensor, memo: &MeshCache, computed: &mut ComputedMetrics) {
    let (mut triangles, mut volume_mm3, mut area_mm2) = (0, 0.0, 0.0);
    for part in sensor.parts() {
        match memo.measured(&part.solid) {
            Ok(mesh) => {
                triangles += mesh.triangles;
                volume_mm3 += f64::from(part.quantity) * mesh.volume_mm3;
                area_mm2 += f64::from(part.quantity) * mesh.area_mm2;
            }
            Err(error) => return computed.notes.push(format!("mesh of {}: {error}", part.name)),
        }
    }
    computed.put("mesh_triangles", triangles as f64);
    computed.put("mesh_volume_mm3", volume_mm3);
    computed.put("mesh_area_mm2", area_mm2);
}
