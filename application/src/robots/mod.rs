//! A sensor for robots' descriptions and simulators: what is stiff as one body, each soft layer as one of its own, with exact
//! masses, what is touched and where it feels, and the camera.
//!
//! ```text
//! bodies of the sensor -> moments of the exact solids x densities -> links
//!                      -> meshes: what is seen; slabs of the case, convex each: what is bumped into
//! touched surface      -> points of equal area -> one convex mesh, whose vertices feel
//! camera               -> frame, pinhole as far as one goes, and every pixel's true ray
//! ```

mod masses;
mod pieces;
mod taxels;

use std::sync::Arc;

use fabkit_designs::Design;
use fabkit_export::{
    Array, Inertia, Robot, RobotCamera, RobotFrame, RobotLink, RobotShape, Values, mjcf, npz, obj,
    sdf, urdf,
};
use fabkit_geometry::{Assembly, Body, Kind, Point3, Pose, SurfacePoints, Vector3};
use fabkit_optics::Sights;
use rayon::prelude::*;
use serde_json::{Value, json};

use self::masses::{Mass, mass};
use self::taxels::TouchMesh;
use crate::Error;
use crate::exporting::{ExportFailure, ForeignFile};
use crate::ground_truth::{Viewpoint, pixels_of};
use crate::identity::design_hash;
use crate::scene::SceneError;
use crate::staging::OutputFile;

/// Meshes that are seen are nowhere farther from the exact surface, mm: simulators draw nothing smaller.
const SEEN_MM: f64 = 0.05;
/// A pinhole shows no wider view than this, whole angle, deg.
const WIDEST_DEG: f64 = 140.0;
const MM_PER_M: f64 = 1000.0;

/// What a file is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RobotFormat {
    /// ROS, PyBullet, TACTO, Drake, SAPIEN.
    Urdf,
    /// MuJoCo.
    Mjcf,
    /// Gazebo, Drake.
    Sdf,
}

impl RobotFormat {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Urdf, Self::Mjcf, Self::Sdf];

    /// As it is asked for.
    pub fn word(self) -> &'static str {
        match self {
            Self::Urdf => "urdf",
            Self::Mjcf => "mjcf",
            Self::Sdf => "sdf",
        }
    }

    fn file(self, name: &str) -> String {
        match self {
            Self::Urdf => format!("{name}.urdf"),
            Self::Mjcf => format!("{name}.mjcf.xml"),
            Self::Sdf => format!("{name}.sdf"),
        }
    }

    fn text(self, robot: &Robot) -> String {
        match self {
            Self::Urdf => urdf(robot),
            Self::Mjcf => mjcf(robot),
            Self::Sdf => sdf(robot),
        }
    }
}

/// A body of the sensor in its place.
struct Standing<'a> {
    body: &'a Body,
    sensor_from_body: Pose,
    mass: Mass,
    is_soft: bool,
    /// In the sensor frame, mm.
    vertices_mm: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// The files of some formats, and what all of them need: meshes, `robot.json`, `robot-taxels.npz`, `robot-rays.npz`.
///
/// # Errors
/// Bodies that no mesh can be made of; a camera that cannot be.
pub fn robot_files(design: &Design, formats: &[RobotFormat]) -> Result<Vec<ForeignFile>, Error> {
    let sensor = &design.sensor;
    let hash = design_hash(design);
    let standing = standing(design)?;
    let touch = sensor.touch.as_ref().map(SurfacePoints::new).transpose().map_err(Error::bug)?;
    let touch = touch
        .map(|points| TouchMesh::of(&points, sensor.touch.as_ref().map_or(0.0, |t| t.soft_mm())))
        .transpose()?;
    let viewpoint = Viewpoint::new(&sensor.camera, None, None)
        .map_err(|error| SceneError::viewpoint(None, error))?;
    let comment = format!(
        "{}: {}; fabkit {}, design {hash}; metres, kilograms, sensor frame",
        sensor.name,
        sensor.title,
        fabkit_export::VERSION
    );
    let mut files = Files { made: Vec::new() };
    let touched = touch.as_ref().map(|_| "robot-touch.obj".to_owned());
    if let (Some(mesh), Some(name)) = (&touch, &touched) {
        files.add(name, "obj", obj(&comment, &mesh.vertices_mm, &mesh.triangles));
    }
    // Case and layers, each with what is seen of it.
    let soft: Vec<&Standing> = standing.iter().filter(|one| one.is_soft).collect();
    let stiff: Vec<&Standing> = standing.iter().filter(|one| !one.is_soft).collect();
    let mut links = vec![link("base", &stiff)];
    let mut seen: Vec<&str> = Vec::new();
    for one in &standing {
        // A body that stands several times has one file, in which all of them are.
        if seen.contains(&one.body.name.as_str()) {
            continue;
        }
        seen.push(&one.body.name);
        let all: Vec<&Standing> =
            standing.iter().filter(|other| other.body.name == one.body.name).collect();
        let (vertices, triangles) = together(&all);
        files.add(&seen_file(one.body), "obj", obj(&comment, &vertices, &triangles));
    }
    // Wires and rubber rings bend aside when something meets them.
    let bumped: Vec<&Standing> =
        stiff.iter().copied().filter(|one| one.body.gives_mm == 0.0).collect();
    let case = pieces::pieces(&bumped)?;
    for (i, piece) in case.iter().enumerate() {
        let name = format!("robot-base-{:02}.obj", i + 1);
        files.add(&name, "obj", obj(&comment, &piece.vertices, &piece.triangles));
        let shape = RobotShape {
            name: format!("base-{:02}", i + 1),
            file: name,
            rgba: [0.5, 0.5, 0.5, 0.3],
        };
        links[0].collisions.push(shape);
    }
    for one in &soft {
        if links.iter().all(|known| known.name != one.body.name) {
            let own: Vec<&Standing> =
                soft.iter().copied().filter(|other| other.body.name == one.body.name).collect();
            links.push(link(&one.body.name, &own));
        }
    }
    // What is touched belongs to the outermost layer, or to the base of a sensor without any.
    let outermost = soft.last().map(|one| one.body.name.as_str());
    if let Some(file) = &touched {
        let wanted = outermost.unwrap_or("base");
        if let Some(link) = links.iter_mut().find(|link| link.name == wanted) {
            let shape =
                RobotShape { name: "touch".into(), file: file.clone(), rgba: [0.1, 0.1, 0.1, 0.3] };
            link.collisions.push(shape);
        }
    }
    let frames = frames(&viewpoint, touch.as_ref());
    let camera = camera(&viewpoint);
    let robot = Robot {
        name: sensor.name.clone(),
        comment,
        links,
        frames,
        camera: Some(camera),
        touch: touched,
    };
    for format in formats {
        let text = format.text(&robot);
        files.add(&format.file(&sensor.name), format.word(), text.into_bytes());
    }
    let stack = viewpoint.stack(sensor).map_err(SceneError::Light)?;
    let sights = Arc::new(Sights::new(stack));
    files.add("robot-rays.npz", "npz", rays(&viewpoint, &sights)?);
    if let Some(mesh) = &touch {
        let places: Vec<Option<Point3<f64>>> =
            mesh.vertices_mm.iter().map(|place| Some(Point3::from(*place))).collect();
        let pixels = pixels_of(&viewpoint, &sights, &places);
        files.add("robot-taxels.npz", "npz", npz(&mesh.arrays(&pixels)).map_err(Error::bug)?);
    }
    let document = document(&robot, &standing, &case, touch.as_ref(), &hash);
    let text = serde_json::to_string_pretty(&document).map_err(Error::bug)? + "\n";
    files.add("robot.json", "json", text.into_bytes());
    Ok(files.made)
}

struct Files {
    made: Vec<ForeignFile>,
}

impl Files {
    fn add(&mut self, name: &str, format: &'static str, bytes: Vec<u8>) {
        let file = OutputFile { name: name.to_owned(), bytes };
        self.made.push(ForeignFile { file, format, parts: Vec::new() });
    }
}

/// All bodies in the sensor, with their masses and meshes.
fn standing<'a>(design: &'a Design) -> Result<Vec<Standing<'a>>, Error> {
    let densities = crate::exporting::densities(design);
    let one = |(body, pose): (&'a Body, Pose)| -> Result<Standing<'a>, Error> {
        let failed = |source| ExportFailure::Mesh { part: body.name.clone(), source };
        let placed = body.solid.clone().placed(pose);
        let mesh = fabkit_mesh::mesh(&placed, SEEN_MM).map_err(failed)?;
        let moments = fabkit_export::moments(&placed).map_err(failed)?;
        Ok(Standing {
            body,
            sensor_from_body: pose,
            mass: mass(body, densities.get(body.name.as_str()).copied(), moments),
            is_soft: body.substance.elasticity.is_some()
                && (body.kind == Kind::Cast || body.gives_way),
            vertices_mm: mesh.vertices,
            triangles: mesh.triangles,
        })
    };
    let places = design.sensor.bodies.iter().flat_map(|body| {
        let in_sensor = body.placements.iter().filter(|place| place.assembly == Assembly::sensor());
        in_sensor.map(move |place| (body, place.assembly_from_body))
    });
    let places: Vec<(&Body, Pose)> = places.collect();
    let standing: Vec<Result<Standing<'a>, Error>> = places.into_par_iter().map(one).collect();
    // One after the other, so that the first error is the same on any number of threads.
    standing.into_iter().collect()
}

fn together(all: &[&Standing<'_>]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for one in all {
        let first = vertices.len() as u32;
        vertices.extend_from_slice(&one.vertices_mm);
        triangles.extend(one.triangles.iter().map(|corners| corners.map(|i| i + first)));
    }
    (vertices, triangles)
}

fn seen_file(body: &Body) -> String {
    format!("robot-{}.obj", body.name)
}

fn link(name: &str, own: &[&Standing<'_>]) -> RobotLink {
    let inertia = own.iter().fold(Inertia::NOTHING, |sum, one| sum.and(&one.mass.inertia));
    let mut visuals: Vec<RobotShape> = Vec::new();
    for one in own {
        let shape_name = format!("{name}-{}", one.body.name);
        if visuals.iter().any(|shape| shape.name == shape_name) {
            continue;
        }
        let [r, g, b] = one.body.color.map(|part| f64::from(part) / 255.0);
        visuals.push(RobotShape {
            name: shape_name,
            file: seen_file(one.body),
            rgba: [r, g, b, one.body.opacity],
        });
    }
    let friction = own.iter().find_map(|one| one.body.substance.elasticity.as_ref()?.friction);
    RobotLink { name: name.to_owned(), inertia, visuals, collisions: Vec::new(), friction }
}

/// The camera's optical frame, and the middle of what is touched, z outwards.
fn frames(viewpoint: &Viewpoint, touch: Option<&TouchMesh>) -> Vec<RobotFrame> {
    let camera = RobotFrame {
        name: "camera_optical".into(),
        sensor_from_frame: viewpoint.sensor_from_camera,
    };
    let touch = touch.map(|mesh| RobotFrame {
        name: "touch_frame".into(),
        sensor_from_frame: Pose::z_to(mesh.middle.1, mesh.middle.0),
    });
    [camera].into_iter().chain(touch).collect()
}

fn camera(viewpoint: &Viewpoint) -> RobotCamera {
    let camera = viewpoint.camera();
    let size_px = [camera.width_px(), camera.height_px()];
    let half = WIDEST_DEG.to_radians() / 2.0;
    // Between the middles of opposite sides, through whatever the lens is.
    let angle = |pixel: [f64; 2]| {
        let ray = camera.unproject(&fabkit_camera::Point2::from(pixel)).ok();
        ray.map_or(half, |ray| ray.direction.angle(&Vector3::z())).min(half)
    };
    let [width, height] = size_px.map(f64::from);
    let middle = [(width - 1.0) / 2.0, (height - 1.0) / 2.0];
    RobotCamera {
        frame: "camera_optical".into(),
        sensor_from_camera: viewpoint.sensor_from_camera,
        size_px,
        view_rad: [
            angle([-0.5, middle[1]]) + angle([width - 0.5, middle[1]]),
            angle([middle[0], -0.5]) + angle([middle[0], height - 0.5]),
        ],
        near_mm: 1.0,
    }
}

/// Where each pixel's ray leaves what it is bent by last, mm, and its direction, sensor frame: rows x columns x 3.
fn rays(viewpoint: &Viewpoint, sights: &Arc<Sights>) -> Result<Vec<u8>, Error> {
    let rays = viewpoint.rays(1).through(sights);
    let each = (0..rays.len()).map(|i| rays.ray(i));
    let unknown = [f64::NAN; 3];
    let origins = each.clone().flat_map(|ray| ray.map_or(unknown, |ray| ray.origin.coords.into()));
    let ways = each.flat_map(|ray| ray.map_or(unknown, |ray| <[f64; 3]>::from(ray.direction)));
    let shape = vec![rays.height_px() as usize, rays.width_px() as usize, 3];
    let array = |name: &str, values: Vec<f64>| Array {
        name: name.to_owned(),
        shape: shape.clone(),
        values: Values::F64(values),
    };
    let arrays = [
        array("origin_in_sensor_mm", origins.collect()),
        array("direction_in_sensor", ways.collect()),
    ];
    npz(&arrays).map_err(Error::bug)
}

fn document(
    robot: &Robot,
    standing: &[Standing<'_>],
    case: &[fabkit_mesh::Hull],
    touch: Option<&TouchMesh>,
    hash: &str,
) -> Value {
    let bodies = standing.iter().map(|one| {
        let elasticity = one.body.substance.elasticity.as_ref();
        json!({
            "name": one.body.name,
            "link": if one.is_soft { one.body.name.as_str() } else { "base" },
            "place_mm": <[f64; 3]>::from(*one.sensor_from_body.translation_mm()),
            "volume_mm3": one.mass.volume_mm3,
            "density_g_per_cm3": one.mass.density_g_per_cm3,
            "density_source": one.mass.source,
            "bends_aside": one.body.gives_mm > 0.0,
            "mass_g": one.mass.inertia.mass_kg * MM_PER_M,
            "young_mpa": elasticity.map(|known| known.young_mpa),
            "poissons_ratio": elasticity.map(|known| known.poissons_ratio),
            "friction": elasticity.and_then(|known| known.friction),
        })
    });
    let links = robot.links.iter().map(|link| {
        json!({
            "name": link.name,
            "mass_kg": link.inertia.mass_kg,
            "centre_m": <[f64; 3]>::from(link.inertia.centre_m),
            "inertia_kg_m2": <[[f64; 3]; 3]>::from(link.inertia.about_centre),
        })
    });
    let total_kg: f64 = robot.links.iter().map(|link| link.inertia.mass_kg).sum();
    json!({
        "format": "fabkit-robot",
        "version": 1,
        "sensor": robot.name,
        "design_hash": hash,
        "mass_kg": total_kg,
        "links": links.collect::<Vec<_>>(),
        "bodies": bodies.collect::<Vec<_>>(),
        "collision": {
            "pieces": case.len(),
            "encloses_mm3": case.iter().map(fabkit_mesh::Hull::volume_mm3).sum::<f64>(),
            "covers_within_mm": SEEN_MM,
            "touch": robot.touch,
        },
        "taxels": touch.map(|mesh| json!({
            "file": "robot-taxels.npz",
            "count": mesh.count(),
            "area_mm2": mesh.area_mm2,
        })),
        "camera": robot.camera.as_ref().map(|camera| json!({
            "frame": camera.frame,
            "rays": "robot-rays.npz",
            "pinhole_view_deg": camera.view_rad.map(f64::to_degrees),
        })),
        "left_out": [
            "cables, wires and rubber rings are weighed, and not bumped into",
            "pieces of the case are hulls of slabs across z: what is hollow seen along z is filled",
            "printed parts weigh as if they were solid; a slicer's infill makes them lighter",
            "soft layers are rigid links; their tetrahedra are in the formats msh and vtk",
            "cameras of these formats are pinholes: no fisheye, no refraction; robot-rays.npz has the true rays",
        ],
    })
}
