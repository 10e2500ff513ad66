//! Tetrahedral meshes of the soft layers, for external finite-element solvers.
//!
//! The touched surface is divided into triangles whose corners lie on it exactly. Each triangle is extruded inwards
//! along the surface normals, through all layers, as a column of prisms; each prism is divided into three tetrahedra.
//! Interfaces between layers are shared faces whose nodes lie on them exactly. Diagonals start at the corner with the
//! lower number, so that neighbours agree.
//!
//! # Conventions
//!
//! Units are millimetres, in the sensor frame. Layers are counted inwards from the touched one, 0. The corners of a
//! tetrahedron are ordered for a positive volume: seen from the fourth, the first three run counter-clockwise. Same
//! input, same bytes.
//!
//! ```
//! # use fabkit_geometry::{Angle, Assembly, Body, Elasticity, FixtureGrip, MaterialProperties, NominalCamera};
//! # use fabkit_geometry::{Path, Placement, PlaneSurface, Pose, Sensor, Solid};
//! # let camera = NominalCamera {
//! #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
//! #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
//! # };
//! # let outline = Path::circle([0.0, 0.0], 15.0);
//! # let grip = FixtureGrip {
//! #     outline: outline.clone(), top_z_mm: 0.0, bottom_z_mm: -9.0, clear_radius_mm: 8.0,
//! #     key: None, threads: Vec::new(),
//! # };
//! # let touch = PlaneSurface { outline, top_z_mm: 3.0, foot_z_mm: 0.0, max_indentation_mm: 1.0, grip };
//! # let elasticity = Some(Elasticity {
//! #     young_mpa: 0.2, young_range_mpa: [0.1, 0.3], poissons_ratio: 0.49, friction: None, source: String::new(),
//! # });
//! # let mut gel = Body::cast("gel", "", Solid::cylinder(15.0, 3.0));
//! # gel.substance = MaterialProperties { elasticity, ..MaterialProperties::default() };
//! # let plate = Body::bought("plate", "", Solid::cylinder(15.0, 2.0).at_z(-2.0));
//! # let [gel, plate] = [gel, plate].map(|body| body.placed([Placement::in_place(Assembly::sensor())]));
//! # let mut sensor = Sensor::new("pad", "A pad", "", camera, [gel, plate]);
//! # sensor.touch = Some(touch.into());
//! use fabkit_elastic::SoftStack;
//! use fabkit_tetra::Tetrahedra;
//!
//! // A pad of gel, 3 mm thick, on a circle of radius 15 mm, with edges of about 2 mm.
//! let soft = SoftStack::at_tip(&sensor)?;
//! let mesh = Tetrahedra::new(&soft, sensor.touch.as_ref().unwrap(), 2.0)?;
//! assert_eq!((mesh.layers.len(), mesh.layers[0].name.as_str()), (1, "gel"));
//! // Nodes lie between the floor and the touched face; corners on the rim make the volume a little too small.
//! assert!(mesh.points_mm.iter().all(|[.., z_mm]| (-1e-9..=3.0 + 1e-9).contains(z_mm)));
//! let share = mesh.quality().volume_mm3[0] / (std::f64::consts::PI * 15.0 * 15.0 * 3.0);
//! assert!(share > 0.97 && share < 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

mod mesh;
mod outline;
mod prisms;
mod quality;
mod rings;

pub use mesh::{MeshLayer, TetraError, Tetrahedra};
pub use quality::Quality;
