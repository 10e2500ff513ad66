//! Robot descriptions of a sensor for simulators: stiff parts as one link, each soft layer as a link of its own, with
//! exact masses, collision shapes, touch points, deformable layers, and the camera.
//!
//! ```text
//! bodies of the sensor -> moments of the exact solids x densities -> links
//!                      -> meshes: visuals; convex pieces of the case: collisions
//! touched surface      -> points of equal area -> one convex mesh, whose vertices are taxels
//! layers below it      -> tetrahedra, and one equivalent modulus
//! camera               -> frame, a pinhole, every pixel's true ray, and the pinhole's pixel of the same point
//! ```
//!
//! ```
//! use fabkit_robots::{RobotFormat, robot_files};
//!
//! let yaml = fabkit_designs::builtin_yaml("9dtact").ok_or("no such sensor")?;
//! let design = fabkit_fixtures::load("9dtact.yaml", yaml, &[])?.design;
//! let files = robot_files(&design, &[RobotFormat::Urdf])?;
//! let text = |name: &str| {
//!     let found = files.iter().find(|one| one.file.name == name);
//!     found.map(|one| String::from_utf8_lossy(&one.file.bytes).into_owned())
//! };
//! // Stiff bodies are one link, the soft layers others; lengths are metres.
//! let urdf = text("9dtact.urdf").ok_or("no URDF")?;
//! assert!(urdf.contains("<link name=\"base\">"));
//! assert!(text("robot.json").is_some());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bodies;
mod camera;
mod convex_pieces;
mod document;
mod error;
mod masses;
mod soft;
mod taxels;

use std::sync::Arc;

use fabkit_capture::surface_middle;
use fabkit_designs::{Design, design_hash};
use fabkit_export::{
    Robot, RobotFrame, RobotMesh, RobotShape, drake, mjcf, npz, obj, sdf, tacex, tacsl, tacto,
    urdf, usd,
};
use fabkit_files::Error;
use fabkit_files::staging::{ForeignFile, OutputFile};
use fabkit_geometry::{Point3, Pose, Sensor, SurfacePoints};
use fabkit_optics::ViewStacks;
use fabkit_scene::SceneError;
use fabkit_scene::ground_truth::{Viewpoint, are_visible, project_points};

pub use self::error::RobotError;
pub use self::masses::unknown_densities;

use self::bodies::{PlacedBody, link, place_bodies, visual_mesh};
use self::camera::PixelPoints;
use self::document::RobotDocument;
use self::soft::{build_soft_body, light_sources};
use self::taxels::TouchMesh;

/// Name of the camera's frame.
const OPTICAL: &str = "camera_optical";

/// Format of robot descriptions, by simulator.
///
/// ```
/// use fabkit_robots::RobotFormat;
/// let words: Vec<&str> = RobotFormat::ALL.iter().map(|format| format.word()).collect();
/// assert_eq!(words, ["urdf", "mjcf", "sdf", "usd", "drake", "tacto"]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RobotFormat {
    /// URDF: ROS, PyBullet, TACTO, SAPIEN.
    Urdf,
    /// MJCF: MuJoCo.
    Mjcf,
    /// SDF: Gazebo.
    Sdf,
    /// USD: Isaac Sim and Isaac Lab, with configurations for TacSL and TacEx.
    Usd,
    /// SDF for Drake, with the soft layers as tetrahedra.
    Drake,
    /// Configuration of TACTO's renderer.
    Tacto,
}

impl RobotFormat {
    /// All formats.
    pub const ALL: [Self; 6] =
        [Self::Urdf, Self::Mjcf, Self::Sdf, Self::Usd, Self::Drake, Self::Tacto];

    /// Name on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Urdf => "urdf",
            Self::Mjcf => "mjcf",
            Self::Sdf => "sdf",
            Self::Usd => "usd",
            Self::Drake => "drake",
            Self::Tacto => "tacto",
        }
    }

    /// Writes the files of the format: names and texts. Those for a surface to touch are absent if there is none.
    fn files(self, robot: &Robot) -> Vec<(String, String)> {
        let name = &robot.name;
        let touched =
            |end: &str, text: Option<String>| text.map(|text| (format!("{name}{end}"), text));
        match self {
            Self::Urdf => vec![(format!("{name}.urdf"), urdf(robot))],
            Self::Mjcf => vec![(format!("{name}.mjcf.xml"), mjcf(robot))],
            Self::Sdf => vec![(format!("{name}.sdf"), sdf(robot))],
            Self::Usd => [
                Some((format!("{name}.usda"), usd(robot))),
                touched(".tacsl.yaml", tacsl(robot)),
                touched(".tacex.yaml", tacex(robot)),
            ]
            .into_iter()
            .flatten()
            .collect(),
            Self::Drake => vec![(format!("{name}.drake.sdf"), drake(robot))],
            Self::Tacto => touched(".tacto.yaml", tacto(robot)).into_iter().collect(),
        }
    }

    /// Returns whether simulators of this format compute the deformation of layers.
    fn simulates_deformation(self) -> bool {
        matches!(self, Self::Usd | Self::Drake)
    }
}

/// Writes the files of some formats, and those that all of them need: meshes, `robot.json`, `robot-taxels.npz`,
/// `robot-rays.npz`, and tetrahedra for formats that deform.
///
/// # Errors
/// Fails for bodies that cannot be meshed, layers without tetrahedra, or an impossible camera.
pub fn robot_files(design: &Design, formats: &[RobotFormat]) -> Result<Vec<ForeignFile>, Error> {
    let sensor = &design.sensor;
    let hash = design_hash(design);
    let standing = place_bodies(design)?;
    let viewpoint = Viewpoint::new(&sensor.camera, None, None)
        .map_err(|error| SceneError::viewpoint(None, error))?;
    let comment = format!(
        "{}: {}; fabkit {}, design {hash}; metres, kilograms, sensor frame",
        sensor.name,
        sensor.title,
        fabkit_export::VERSION
    );
    let mut files = Files { made: Vec::new() };
    // Visual meshes of case and layers. A body with several placements becomes one mesh.
    let mut meshes: Vec<Arc<RobotMesh>> = Vec::new();
    for one in &standing {
        let mesh = visual_mesh(one.body, &standing);
        if meshes.iter().all(|known| known.file != mesh.file) {
            meshes.push(Arc::new(mesh));
        }
    }
    let (soft_bodies, stiff): (Vec<&PlacedBody>, Vec<&PlacedBody>) =
        standing.iter().partition(|one| one.is_soft);
    // All stiff bodies are one link, the base; each soft layer is a link of its own.
    let mut links = vec![link("base", &stiff, &meshes)];
    for one in &soft_bodies {
        if links.iter().all(|known| known.name != one.body.name) {
            let own = soft_bodies.iter().copied().filter(|other| other.body.name == one.body.name);
            links.push(link(&one.body.name, &own.collect::<Vec<_>>(), &meshes));
        }
    }
    // Wires and rubber rings are flexible and give way on contact.
    let bumped: Vec<&PlacedBody> =
        stiff.iter().copied().filter(|one| one.body.assembly_compliance_mm == 0.0).collect();
    let case = convex_pieces::compute_convex_pieces(&bumped)?;
    for (i, piece) in case.iter().enumerate() {
        let name = format!("base-{:02}", i + 1);
        let mesh = Arc::new(RobotMesh {
            file: format!("robot-{name}.obj"),
            vertices_mm: piece.vertices.clone(),
            triangles: piece.triangles.clone(),
        });
        meshes.push(Arc::clone(&mesh));
        links[0].collisions.push(RobotShape { name, mesh, rgba: [0.5, 0.5, 0.5, 0.3] });
    }
    // The touched surface belongs to the outermost layer, or to the base of a sensor without layers.
    let mut felt = None;
    let mut touch = None;
    if let Some(surface) = &sensor.touch {
        let points = SurfacePoints::new(surface).map_err(Error::bug)?;
        let taxels = TouchMesh::new(&points, surface.max_indentation_mm())?;
        let mesh = Arc::new(RobotMesh {
            file: "robot-touch.obj".to_owned(),
            vertices_mm: taxels.vertices_mm.clone(),
            triangles: taxels.triangles.clone(),
        });
        meshes.push(Arc::clone(&mesh));
        let outermost = soft_bodies.last().map_or("base", |one| one.body.name.as_str());
        let shape = RobotShape {
            name: "touch".into(),
            mesh: Arc::clone(&mesh),
            rgba: [0.1, 0.1, 0.1, 0.3],
        };
        if let Some(link) = links.iter_mut().find(|link| link.name == outermost) {
            link.collisions.push(shape);
        }
        touch = Some(build_soft_body(design, surface, &mesh, outermost)?);
        felt = Some(taxels);
    }
    for mesh in &meshes {
        files.add(&mesh.file, "obj", obj(&comment, mesh));
    }
    let stack = viewpoint.stack(sensor).map_err(SceneError::Light)?;
    let sights = Arc::new(ViewStacks::new(stack));
    let pixels = PixelPoints::trace(sensor, &viewpoint, &sights)?;
    let robot = Robot {
        name: sensor.name.clone(),
        comment,
        links,
        frames: frames(&viewpoint, sensor),
        camera: pixels.pinhole(&viewpoint, OPTICAL),
        touch: touch.as_ref().map(|soft| soft.touch.clone()),
        light_sources: light_sources(sensor),
    };
    for format in formats {
        for (name, text) in format.files(&robot) {
            files.add(&name, format.word(), text.into_bytes());
        }
    }
    // Tetrahedra are large: they are written only for formats that use them.
    if let Some(soft) =
        touch.as_mut().filter(|_| formats.iter().any(|format| format.simulates_deformation()))
    {
        for (name, format, bytes) in &mut soft.files {
            files.add(name, format, std::mem::take(bytes));
        }
    }
    files.add("robot-camera.yaml", "ros", PixelPoints::yaml(&robot.camera)?.into_bytes());
    files.add("robot-rays.npz", "npz", pixels.npz(&robot.camera)?);
    if let Some(mesh) = &felt {
        let places: Vec<Option<Point3<f64>>> =
            mesh.vertices_mm.iter().map(|place| Some(Point3::from(*place))).collect();
        let pixels = project_points(&viewpoint, &sights, &places);
        let are_seen = are_visible(&viewpoint, &sights, &places);
        let arrays = mesh.arrays(&pixels, &are_seen);
        files.add("robot-taxels.npz", "npz", npz(&arrays).map_err(Error::bug)?);
    }
    let told = RobotDocument {
        robot: &robot,
        standing: &standing,
        case: &case,
        taxels: felt.as_ref(),
        soft: touch.as_ref(),
        shown_fraction: pixels.shown_fraction(&robot.camera),
        hash: &hash,
        unknown: &unknown_densities(sensor),
    };
    files.add("robot.json", "json", told.text()?.into_bytes());
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

/// Lists the frames: the camera's optical frame; the mount, whose z points towards the sensor; and the middle of the
/// touched surface, with z outwards.
fn frames(viewpoint: &Viewpoint, sensor: &Sensor) -> Vec<RobotFrame> {
    let frame =
        |name: &str, sensor_from_frame: Pose| RobotFrame { name: name.into(), sensor_from_frame };
    let middle = sensor.touch.as_ref().and_then(surface_middle);
    let touch = middle.map(|(at, outward)| frame("touch_frame", Pose::z_to(outward, at)));
    let mount = sensor.mount.map(|pose| frame("mount", pose));
    [Some(frame(OPTICAL, viewpoint.sensor_from_camera)), mount, touch]
        .into_iter()
        .flatten()
        .collect()
}
