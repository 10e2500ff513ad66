//! Tetrahedral meshes of soft layers.

use fabkit_elastic::{BoundaryCondition, SoftStack};
use fabkit_geometry::{Point3, TouchSurface};
use nalgebra::Vector3;

use crate::prisms::Levels;
use crate::quality::volume_mm3;
use crate::{outline, rings};

/// Corners of a triangle.
pub(crate) type Face = [u32; 3];

/// Maximum number of tetrahedra of a mesh; its files have some hundred megabytes.
pub const MAX_CELLS: usize = 5_000_000;
/// Maximum length of edges relative to the thickness of a layer: flatter prisms give flat tetrahedra. Thinner layers
/// are merged with a neighbour.
const MAX_EDGE_PER_THICKNESS: f64 = 2.5;
/// Approximate height of a prism relative to its edges. It is below 1 because a dome is narrower inside.
const PRISM_HEIGHT_PER_EDGE: f64 = 0.8;
/// Sample points along the meridian for thicknesses and areas.
const MERIDIAN_SAMPLES: usize = 200;

/// Node on the touched surface of a dome.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DomeNode {
    pub s: f64,
    pub azimuth: f64,
}

/// Layer of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshLayer {
    /// Name of the body.
    pub name: String,
    /// Name of the material.
    pub material: String,
    /// Young's modulus, MPa.
    pub young_mpa: f64,
    /// Poisson's ratio.
    pub poissons_ratio: f64,
}

/// Tetrahedral mesh of the soft layers of a sensor, which are bonded to each other.
///
/// ```
/// # use fabkit_geometry::{Angle, Assembly, Body, Elasticity, FixtureGrip, MaterialProperties, NominalCamera};
/// # use fabkit_geometry::{Path, Placement, PlaneSurface, Pose, Sensor, Solid};
/// # let camera = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// # let outline = Path::circle([0.0, 0.0], 15.0);
/// # let grip = FixtureGrip {
/// #     outline: outline.clone(), top_z_mm: 0.0, bottom_z_mm: -9.0, clear_radius_mm: 8.0,
/// #     key: None, threads: Vec::new(),
/// # };
/// # let touch = PlaneSurface { outline, top_z_mm: 3.0, foot_z_mm: 0.0, max_indentation_mm: 1.0, grip };
/// # let elasticity = Some(Elasticity {
/// #     young_mpa: 0.2, young_range_mpa: [0.1, 0.3], poissons_ratio: 0.49, friction: None, source: String::new(),
/// # });
/// # let mut gel = Body::cast("gel", "", Solid::cylinder(15.0, 3.0));
/// # gel.substance = MaterialProperties { elasticity, ..MaterialProperties::default() };
/// # let plate = Body::bought("plate", "", Solid::cylinder(15.0, 2.0).at_z(-2.0));
/// # let [gel, plate] = [gel, plate].map(|body| body.placed([Placement::in_place(Assembly::sensor())]));
/// # let mut sensor = Sensor::new("pad", "A pad", "", camera, [gel, plate]);
/// # sensor.touch = Some(touch.into());
/// use fabkit_elastic::SoftStack;
/// use fabkit_tetra::Tetrahedra;
///
/// // What a solver needs of a pad 3 mm thick: where it is pressed, where it is held, and of which material it is.
/// let soft = SoftStack::at_tip(&sensor)?;
/// let mesh = Tetrahedra::new(&soft, sensor.touch.as_ref().unwrap(), 3.0)?;
/// let heights_mm = |faces: &[[u32; 3]]| -> Vec<f64> {
///     let nodes = Tetrahedra::collect_nodes(faces);
///     nodes.iter().map(|node| mesh.points_mm[*node as usize][2]).collect()
/// };
/// assert!(heights_mm(&mesh.touched_faces).iter().all(|z_mm| (z_mm - 3.0).abs() < 1e-9));
/// assert!(heights_mm(&mesh.bonded_faces).iter().all(|z_mm| z_mm.abs() < 1e-9));
/// assert_eq!((mesh.layers[0].young_mpa, mesh.cell_layers.len()), (0.2, mesh.cells.len()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Tetrahedra {
    /// Nodes, sensor frame, mm.
    pub points_mm: Vec<[f64; 3]>,
    /// Corners of the tetrahedra, as indices of nodes.
    pub cells: Vec<[u32; 4]>,
    /// Index into `layers` for each tetrahedron.
    pub cell_layers: Vec<u32>,
    /// Layers, from the touched one inwards.
    pub layers: Vec<MeshLayer>,
    /// Triangles of the touched surface, counter-clockwise from outside.
    pub touched_faces: Vec<[u32; 3]>,
    /// Triangles bonded to stiff bodies, below the last layer and at its rim, oriented out of the soft body.
    pub bonded_faces: Vec<[u32; 3]>,
    /// Approximate length of edges, mm.
    pub edge_mm: f64,
    /// Simplifications, in words.
    pub simplifications: Vec<String>,
}

/// Reason why there is no mesh.
///
/// ```
/// # use fabkit_geometry::{Angle, Assembly, Body, Elasticity, FixtureGrip, MaterialProperties, NominalCamera};
/// # use fabkit_geometry::{Path, Placement, PlaneSurface, Pose, Sensor, Solid};
/// # let camera = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// # let outline = Path::circle([0.0, 0.0], 15.0);
/// # let grip = FixtureGrip {
/// #     outline: outline.clone(), top_z_mm: 0.0, bottom_z_mm: -9.0, clear_radius_mm: 8.0,
/// #     key: None, threads: Vec::new(),
/// # };
/// # let touch = PlaneSurface { outline, top_z_mm: 3.0, foot_z_mm: 0.0, max_indentation_mm: 1.0, grip };
/// # let elasticity = Some(Elasticity {
/// #     young_mpa: 0.2, young_range_mpa: [0.1, 0.3], poissons_ratio: 0.49, friction: None, source: String::new(),
/// # });
/// # let mut gel = Body::cast("gel", "", Solid::cylinder(15.0, 3.0));
/// # gel.substance = MaterialProperties { elasticity, ..MaterialProperties::default() };
/// # let plate = Body::bought("plate", "", Solid::cylinder(15.0, 2.0).at_z(-2.0));
/// # let [gel, plate] = [gel, plate].map(|body| body.placed([Placement::in_place(Assembly::sensor())]));
/// # let mut sensor = Sensor::new("pad", "A pad", "", camera, [gel, plate]);
/// # sensor.touch = Some(touch.into());
/// use fabkit_elastic::SoftStack;
/// use fabkit_tetra::{TetraError, Tetrahedra};
///
/// // Edges have a length, and those of a hundredth of a millimetre make too many tetrahedra of a pad of 30 mm.
/// let soft = SoftStack::at_tip(&sensor)?;
/// let error = |edge_mm| Tetrahedra::new(&soft, sensor.touch.as_ref().unwrap(), edge_mm).unwrap_err();
/// assert_eq!(error(0.0).to_string(), "an edge of 0 mm; it must be positive and finite");
/// assert!(matches!(error(0.01), TetraError::TooMany { .. }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, thiserror::Error)]
pub enum TetraError {
    /// Invalid edge length.
    #[error("an edge of {edge_mm} mm; it must be positive and finite")]
    Edge {
        /// Requested edge length, mm.
        edge_mm: f64,
    },
    /// Mesh with too many tetrahedra.
    #[error("edges of {edge_mm} mm make {cells} tetrahedra; at most {MAX_CELLS} are made")]
    TooMany {
        /// Edge length after the limit for the thinnest layer, mm.
        edge_mm: f64,
        /// Number of tetrahedra that there would be.
        cells: usize,
    },
    /// Outline that cannot be triangulated.
    #[error("the pad's outline has no triangles: {what}")]
    Outline {
        /// Reason.
        what: String,
    },
    /// Tetrahedron with a volume of nearly zero, or one that is not a number.
    #[error("a tetrahedron of {layer} is inverted at ({x:.2}, {y:.2}, {z:.2}) mm")]
    Degenerate {
        /// Name of the layer.
        layer: String,
        /// Position, sensor frame, mm.
        x: f64,
        /// Position, sensor frame, mm.
        y: f64,
        /// Position, sensor frame, mm.
        z: f64,
    },
}

impl Tetrahedra {
    /// Meshes the layers below a sensor's surface, with edges about `edge_mm` long, shorter if a layer is thin.
    ///
    /// # Errors
    /// [`TetraError`].
    pub fn new(soft: &SoftStack, touch: &TouchSurface, edge_mm: f64) -> Result<Self, TetraError> {
        if !(edge_mm > 0.0 && edge_mm.is_finite()) {
            return Err(TetraError::Edge { edge_mm });
        }
        let kept = MeshPlan::new(soft, touch, edge_mm);
        let edge_mm = kept.edge_mm;
        let parts: Vec<usize> = kept.layers.iter().map(|layer| layer.parts).collect();
        let levels: usize = parts.iter().sum();
        let too_many = |faces: usize| {
            // Three tetrahedra per prism.
            let cells = 3 * faces * levels;
            (cells > MAX_CELLS).then_some(TetraError::TooMany { edge_mm, cells })
        };
        // Estimated from the area before the surface is divided; 0.433 is the area of an equilateral triangle over its
        // squared side.
        let area_mm2 = match touch {
            TouchSurface::Plane(plane) => plane.outline.signed_area_mm2().abs(),
            TouchSurface::Dome(_) => area_mm2(soft),
        };
        if let Some(error) = too_many((area_mm2 / (0.433 * edge_mm * edge_mm)) as usize) {
            return Err(error);
        }
        let surface = match touch {
            TouchSurface::Dome(_) => SurfaceTriangles::dome(soft, edge_mm),
            TouchSurface::Plane(plane) => SurfaceTriangles::pad(&plane.outline, edge_mm)?,
        };
        if let Some(error) = too_many(surface.faces.len()) {
            return Err(error);
        }
        surface.extrude(soft, &kept)
    }

    /// Returns the nodes of a set of triangles, each once, in ascending order.
    ///
    /// ```
    /// use fabkit_tetra::Tetrahedra;
    ///
    /// // Two triangles with a common edge have four corners.
    /// assert_eq!(Tetrahedra::collect_nodes(&[[7, 2, 5], [5, 2, 9]]), [2, 5, 7, 9]);
    /// ```
    pub fn collect_nodes(faces: &[[u32; 3]]) -> Vec<u32> {
        let mut nodes: Vec<u32> = faces.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }
}

/// Layer that is meshed.
struct MeshedLayer {
    /// Index in the stack.
    layer: usize,
    /// Index of the interface below it.
    interface: usize,
    /// Number of prisms through its thickness.
    parts: usize,
}

/// Layers to mesh, and how finely.
struct MeshPlan {
    layers: Vec<MeshedLayer>,
    edge_mm: f64,
    simplifications: Vec<String>,
}

impl MeshPlan {
    /// Decides which layers are meshed, and with which edge length.
    fn new(soft: &SoftStack, touch: &TouchSurface, edge_mm: f64) -> Self {
        // The layers of a pad are equally thick everywhere.
        let places = if matches!(touch, TouchSurface::Plane(_)) { 1 } else { MERIDIAN_SAMPLES };
        let thickness = |upper: usize, lower: usize| {
            let [upper, lower] = [upper, lower].map(|i| &soft.body.interfaces[i]);
            let thickness_mm = |i: usize| {
                let s = i as f64 / MERIDIAN_SAMPLES as f64;
                let (a, b) = (upper.at(s), lower.at(s));
                (a[0] - b[0]).hypot(a[1] - b[1])
            };
            let ends = (f64::INFINITY, 0.0);
            (0..places)
                .map(thickness_mm)
                .fold(ends, |(least, most), mm| (least.min(mm), f64::max(most, mm)))
        };
        let count = soft.body.layers.len();
        let is_thin = |i: usize| MAX_EDGE_PER_THICKNESS * thickness(i, i + 1).0 < edge_mm;
        let mut kept: Vec<usize> = (0..count).filter(|i| !is_thin(*i)).collect();
        if kept.is_empty() {
            // If all layers are thin, the thickest is meshed, more finely.
            kept.extend(
                (0..count).max_by(|a, b| thickness(*a, a + 1).0.total_cmp(&thickness(*b, b + 1).0)),
            );
        }
        let mut simplifications = Vec::new();
        for i in (0..count).filter(|i| !kept.contains(i)) {
            let (name, mm) = (&soft.layers[i].name, thickness(i, i + 1).0);
            let next = kept.iter().find(|kept| **kept > i).or(kept.last()).copied().unwrap_or(0);
            let into = &soft.layers[next].name;
            simplifications.push(format!(
                "that {name}, {mm:.3} mm where it is thinnest, is another material than {into}"
            ));
        }
        // Each meshed layer reaches from the one above down to its own lower interface, and the last one to the bottom.
        // A thin layer thus belongs to the meshed layer below it, or to the last one.
        let last = kept.len().saturating_sub(1);
        let interface = |at: usize| if at == last { count } else { kept[at] + 1 };
        let mut layers = Vec::new();
        let (mut upper, mut edge_mm) = (0, edge_mm);
        for (at, layer) in kept.iter().enumerate() {
            let (least, _) = thickness(upper, interface(at));
            edge_mm = edge_mm.min(MAX_EDGE_PER_THICKNESS * least);
            upper = interface(at);
            layers.push((*layer, upper));
        }
        let mut upper = 0;
        let layers = layers.into_iter().map(|(layer, interface)| {
            let (least, most) = thickness(upper, interface);
            upper = interface;
            // By the geometric mean of the extreme thicknesses.
            let parts = ((least * most).sqrt() / (PRISM_HEIGHT_PER_EDGE * edge_mm)).round().max(1.0)
                as usize;
            MeshedLayer { layer, interface, parts }
        });
        Self { layers: layers.collect(), edge_mm, simplifications }
    }
}

/// Computes the area of the touched surface as a sum of frustums, mm2.
fn area_mm2(soft: &SoftStack) -> f64 {
    let Some(surface) = soft.body.interfaces.first() else { return 0.0 };
    let place = |i: usize| surface.at(i as f64 / MERIDIAN_SAMPLES as f64);
    let frustum = |i: usize| {
        let (a, b) = (place(i), place(i + 1));
        std::f64::consts::PI * (a[0] + b[0]) * (a[0] - b[0]).hypot(a[1] - b[1])
    };
    (0..MERIDIAN_SAMPLES).map(frustum).sum()
}

/// Triangles of the touched surface, and the positions of their nodes on every interface.
struct SurfaceTriangles {
    places: SurfaceNodes,
    faces: Vec<Face>,
    /// Nodes of a dome's rim, in order.
    rim: Vec<u32>,
}

/// Positions of the nodes on the touched surface.
enum SurfaceNodes {
    Dome(Vec<DomeNode>),
    /// x and y, mm.
    Pad(Vec<[f64; 2]>),
}

impl SurfaceTriangles {
    /// Triangulates the touched surface of a dome.
    fn dome(soft: &SoftStack, edge_mm: f64) -> Self {
        let (nodes, faces, rim) = rings::triangulate(&soft.body.interfaces[0], edge_mm);
        Self { places: SurfaceNodes::Dome(nodes), faces, rim }
    }

    /// Triangulates the touched surface of a pad.
    fn pad(outline: &fabkit_geometry::Path, edge_mm: f64) -> Result<Self, TetraError> {
        let (nodes, faces) = outline::triangulate(outline, edge_mm)?;
        Ok(Self { places: SurfaceNodes::Pad(nodes), faces, rim: Vec::new() })
    }

    /// Returns the number of nodes.
    fn count(&self) -> usize {
        match &self.places {
            SurfaceNodes::Dome(nodes) => nodes.len(),
            SurfaceNodes::Pad(nodes) => nodes.len(),
        }
    }

    /// Returns the positions of the nodes on an interface, sensor frame, mm.
    fn node_positions(&self, soft: &SoftStack, interface: usize) -> Vec<Point3<f64>> {
        let curve = &soft.body.interfaces[interface];
        match &self.places {
            SurfaceNodes::Dome(nodes) => {
                let place = |node: &DomeNode| {
                    let [r, z] = curve.at(node.s);
                    let (sin, cos) = node.azimuth.sin_cos();
                    soft.sensor_from_stack.point(Point3::new(r * cos, r * sin, z))
                };
                nodes.iter().map(place).collect()
            }
            SurfaceNodes::Pad(nodes) => {
                let z = soft.sensor_from_stack.point(Point3::new(0.0, 0.0, curve.at(0.0)[1])).z;
                nodes.iter().map(|[x, y]| Point3::new(*x, *y, z)).collect()
            }
        }
    }

    /// Extrudes the surface through all layers.
    fn extrude(&self, soft: &SoftStack, kept: &MeshPlan) -> Result<Tetrahedra, TetraError> {
        let edge_mm = kept.edge_mm;
        let mut points_mm: Vec<[f64; 3]> = Vec::new();
        let mut add = |points: &[Point3<f64>]| {
            points_mm.extend(points.iter().map(|p| <[f64; 3]>::from(p.coords)))
        };
        let mut upper = self.node_positions(soft, 0);
        add(&upper);
        for MeshedLayer { interface, parts, .. } in &kept.layers {
            let lower = self.node_positions(soft, *interface);
            for part in 1..=*parts {
                let share = part as f64 / *parts as f64;
                // The last level lies exactly on the interface, without rounding.
                let level: Vec<Point3<f64>> = if part == *parts {
                    lower.clone()
                } else {
                    upper.iter().zip(&lower).map(|(a, b)| a + share * (b - a)).collect()
                };
                add(&level);
            }
            upper = lower;
        }
        let levels = Levels { per_level: self.count() as u32 };
        let (mut cells, mut layer_of, mut level) = (Vec::new(), Vec::new(), 0);
        for (layer, MeshedLayer { parts, .. }) in kept.layers.iter().enumerate() {
            for _ in 0..*parts {
                for face in &self.faces {
                    cells.extend(levels.prism(*face, level));
                    layer_of.extend([layer as u32; 3]);
                }
                level += 1;
            }
        }
        let corner = |node: u32| Vector3::from(points_mm[node as usize]);
        for (cell, layer) in cells.iter_mut().zip(&layer_of) {
            let volume_mm3 = volume_mm3(&cell.map(corner));
            // The prism's tetrahedra have either orientation, depending on the order of the face's corners.
            if volume_mm3 < 0.0 {
                cell.swap(2, 3);
            }
            // Relative to the edges, so that the tolerance suits sensors of any size.
            if volume_mm3.abs() <= 1e-9 * edge_mm.powi(3) || volume_mm3.is_nan() {
                let [x, y, z] = points_mm[cell[0] as usize];
                let layer = soft.layers[kept.layers[*layer as usize].layer].name.clone();
                return Err(TetraError::Degenerate { layer, x, y, z });
            }
        }
        let bonded = self.find_bonded_faces(soft, &levels, level);
        let layers =
            kept.layers.iter().map(|kept| &soft.layers[kept.layer]).map(|layer| MeshLayer {
                name: layer.name.clone(),
                material: layer.material.clone(),
                young_mpa: layer.elasticity.young_mpa,
                poissons_ratio: layer.elasticity.poissons_ratio,
            });
        Ok(Tetrahedra {
            cells,
            cell_layers: layer_of,
            layers: layers.collect(),
            touched_faces: self.faces.clone(),
            bonded_faces: bonded,
            points_mm,
            edge_mm,
            simplifications: soft
                .simplifications
                .iter()
                .chain(&kept.simplifications)
                .cloned()
                .collect(),
        })
    }

    /// Returns the faces bonded to stiff bodies, below the last level and at the rim.
    fn find_bonded_faces(&self, soft: &SoftStack, levels: &Levels, last: usize) -> Vec<Face> {
        let is_held = |node: u32| match (&soft.body.inner, &self.places) {
            (BoundaryCondition::Free, _) => false,
            (BoundaryCondition::BondedBeyond(from), SurfaceNodes::Dome(nodes)) => {
                // Tolerance for rounding of s.
                nodes[node as usize].s >= from - 1e-12
            }
            _ => true,
        };
        let held = self.faces.iter().filter(|face| face.iter().all(|node| is_held(*node)));
        // Seen from below, the triangles run the other way.
        let mut bonded: Vec<Face> =
            held.map(|[a, b, c]| [*a, *c, *b].map(|node| levels.node(node, last))).collect();
        if soft.body.is_rim_bonded {
            for (i, from) in self.rim.iter().enumerate() {
                let to = self.rim[(i + 1) % self.rim.len()];
                bonded.extend((0..last).flat_map(|level| levels.side(*from, to, level)));
            }
        }
        bonded
    }
}
