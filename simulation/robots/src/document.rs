//! The file `robot.json`, with everything that robot formats cannot hold.

use fabkit_capture::unknown_document;
use fabkit_checks::UnknownProperty;
use fabkit_export::Robot;
use fabkit_files::Error;
use fabkit_mesh::Hull;
use serde_json::json;

use super::bodies::{PlacedBody, VISUAL_TOLERANCE_MM};
use super::soft::SoftBody;
use super::taxels::TouchMesh;

const MM_PER_M: f64 = 1000.0;

/// Inputs of the file.
pub(super) struct RobotDocument<'a> {
    pub robot: &'a Robot,
    pub standing: &'a [PlacedBody<'a>],
    pub case: &'a [Hull],
    pub taxels: Option<&'a TouchMesh>,
    pub soft: Option<&'a SoftBody>,
    /// Fraction of the camera's image that the pinhole shows.
    pub shown_fraction: f64,
    pub hash: &'a str,
    /// Densities for which chosen ones stand.
    pub unknown: &'a [UnknownProperty],
}

impl RobotDocument<'_> {
    /// Writes the file.
    pub fn text(&self) -> Result<String, Error> {
        let camera = &self.robot.camera;
        let bodies = self.standing.iter().map(|one| {
            let elasticity = one.body.substance.elasticity.as_ref();
            json!({
                "name": one.body.name,
                "link": if one.is_soft { one.body.name.as_str() } else { "base" },
                "place_mm": <[f64; 3]>::from(*one.sensor_from_body.translation_mm()),
                "volume_mm3": one.mass.volume_mm3,
                "density_g_per_cm3": one.mass.density_g_per_cm3,
                "density_source": one.mass.source,
                "bends_aside": one.body.assembly_compliance_mm > 0.0,
                "mass_g": one.mass.inertia.mass_kg * MM_PER_M,
                "young_mpa": elasticity.map(|known| known.young_mpa),
                "poissons_ratio": elasticity.map(|known| known.poissons_ratio),
                "friction": elasticity.and_then(|known| known.friction),
            })
        });
        let links = self.robot.links.iter().map(|link| {
            json!({
                "name": link.name,
                "mass_kg": link.inertia.mass_kg,
                "centre_m": <[f64; 3]>::from(link.inertia.centre_m),
                "inertia_kg_m2": <[[f64; 3]; 3]>::from(link.inertia.about_centre),
            })
        });
        let total_kg: f64 = self.robot.links.iter().map(|link| link.inertia.mass_kg).sum();
        let mut document = json!({
            "format": "fabkit-robot",
            "version": 1,
            "sensor": self.robot.name,
            "design_hash": self.hash,
            "mass_kg": total_kg,
            "links": links.collect::<Vec<_>>(),
            "bodies": bodies.collect::<Vec<_>>(),
            "collision": {
                "pieces": self.case.len(),
                "encloses_mm3": self.case.iter().map(Hull::volume_mm3).sum::<f64>(),
                "covers_within_mm": VISUAL_TOLERANCE_MM,
                "touch": self.robot.touch.as_ref().map(|touch| touch.mesh.file.as_str()),
            },
            "taxels": self.taxels.map(|mesh| json!({
                "file": "robot-taxels.npz",
                "count": mesh.taxel_count(),
                "area_mm2": mesh.area_mm2,
            })),
            "soft": self.soft.map(|soft| json!({
                "files": soft.files.iter().map(|(name, ..)| *name).collect::<Vec<_>>(),
                "unit": "m",
                "edge_mm": soft.edge_mm,
                "nodes": soft.touch.tetrahedra.points_mm.len(),
                "tetrahedra": soft.touch.tetrahedra.cells.len(),
                "in_series_mpa": soft.touch.young_mpa,
                "thickness_mm": soft.touch.thickness_mm,
            "soft_mm": soft.touch.max_indentation_mm,
                "left_out": soft.left_out,
            })),
            "frames": self.robot.frames.iter().map(|frame| {
                let at = frame.sensor_from_frame;
                json!({
                    "name": frame.name,
                    "place_m": at.translation_mm().iter().map(|mm| mm / MM_PER_M).collect::<Vec<_>>(),
                    "rotation": <[[f64; 3]; 3]>::from(at.rotation().transpose()),
                })
            }).collect::<Vec<_>>(),
            "camera": {
                "frame": camera.frame,
                "rays": "robot-rays.npz",
            "file": "robot-camera.yaml",
                "pinhole": {
                    "width_px": camera.size_px[0],
                    "height_px": camera.size_px[1],
                    "focal_px": camera.focal_px,
                    "middle_px": camera.middle_px(),
                    "view_deg": camera.view_rad().map(f64::to_degrees),
                    "near_m": camera.near_mm / MM_PER_M,
                },
                "shown": self.shown_fraction,
            },
            "lamps": self.robot.light_sources.iter().map(|lamp| json!({
                "place_m": lamp.place_mm.map(|mm| mm / MM_PER_M),
                "rgb": lamp.rgb,
                "share": lamp.share,
            })).collect::<Vec<_>>(),
            "left_out": [
                "cables, wires and rubber rings are weighed, and not bumped into",
                "pieces of the case are hulls of slabs across z: what is hollow seen along z is filled",
                "printed parts weigh as if they were solid; a slicer's infill makes them lighter",
                "soft layers are rigid links; what gives way are the tetrahedra beside",
                "cameras of these formats are pinholes: no fisheye, no refraction; robot-rays.npz has the true rays, and where the pinhole sees what each pixel sees at rest",
            ],
        });
        if !self.unknown.is_empty() {
            document["not_known"] = unknown_document(self.unknown);
        }
        serde_json::to_string_pretty(&document).map(|text| text + "\n").map_err(Error::bug)
    }
}
