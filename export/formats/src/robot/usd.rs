//! USD files as text, with the schemas of UsdGeom, UsdShade and UsdPhysics.

use std::fmt::Write as _;

use fabkit_geometry::{Matrix3, Pose, Vector3};

use super::numbers::{MM_PER_M, number};
use super::rotation::{opengl_rotation, quaternion};
use super::{Inertia, Robot, RobotCamera, RobotLink, RobotMesh, RobotShape, RobotTetrahedra};

/// Focal length; only its ratio to the apertures matters.
const FOCAL: f64 = 24.0;

/// Writes a `.usda` file: metres, kilograms, z up. Each link is a rigid body with its mass and principal inertia,
/// welded to the base by a fixed joint. There is no articulation root, so that the sensor can be attached to a robot's
/// own. Collision shapes are not drawn (purpose `guide`), each its own convex hull.
///
/// The sensing link's mesh carries its tetrahedra in the attributes that TacEx reads (`tet_points`, `tet_indices`,
/// `tet_surf_points`, `tet_surf_indices`).
///
/// OpenUSD, "UsdPhysics: rigid body physics proposal" and "UsdGeomCamera".
pub fn usd(robot: &Robot) -> String {
    let name = identifier(&robot.name);
    let mut text = format!(
        "#usda 1.0\n(\n    defaultPrim = \"{name}\"\n    doc = \"{}\"\n    kilogramsPerUnit = 1\n    metersPerUnit = 1\n    \
         upAxis = \"Z\"\n)\n\ndef Xform \"{name}\" (\n    kind = \"component\"\n)\n{{\n",
        quoted(&robot.comment)
    );
    for link in robot.links.iter().filter(|link| link.friction.is_some()) {
        text += &write_friction_material(link);
    }
    for (i, link) in robot.links.iter().enumerate() {
        text += &write_link(robot, link, i == 0);
    }
    let base = robot.links.first().map_or("base", |link| &link.name);
    // Writing to a string cannot fail.
    for link in robot.links.iter().skip(1) {
        let _ = write!(
            text,
            "    def PhysicsFixedJoint \"{0}_weld\"\n    {{\n        rel physics:body0 = </{name}/{1}>\n        \
             rel physics:body1 = </{name}/{0}>\n        point3f physics:localPos0 = (0, 0, 0)\n        \
             point3f physics:localPos1 = (0, 0, 0)\n        quatf physics:localRot0 = (1, 0, 0, 0)\n        \
             quatf physics:localRot1 = (1, 0, 0, 0)\n    }}\n\n",
            identifier(&link.name),
            identifier(base),
        );
    }
    text + "}\n"
}

/// Converts a name to a USD identifier: letters, digits and underscores, not beginning with a digit.
///
/// `9dtact` becomes `_9dtact`, `black-coat` becomes `black_coat`.
pub(super) fn identifier(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let text: String = name.chars().map(plain).collect();
    if text.starts_with(|c: char| c.is_ascii_digit()) { format!("_{text}") } else { text }
}

fn quoted(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', " ")
}

fn tuple(values: impl IntoIterator<Item = f64>) -> String {
    format!("({})", values.into_iter().map(number).collect::<Vec<_>>().join(", "))
}

fn material_name(link: &RobotLink) -> String {
    format!("{}_surface", identifier(&link.name))
}

/// Writes the physics material with a link's friction.
fn write_friction_material(link: &RobotLink) -> String {
    let mu = number(link.friction.unwrap_or_default());
    format!(
        "    def Material \"{}\" (\n        prepend apiSchemas = [\"PhysicsMaterialAPI\"]\n    )\n    {{\n        \
         float physics:dynamicFriction = {mu}\n        float physics:restitution = 0\n        \
         float physics:staticFriction = {mu}\n    }}\n\n",
        material_name(link)
    )
}

fn write_link(robot: &Robot, link: &RobotLink, is_base: bool) -> String {
    let (moments, axes) = principal(&link.inertia);
    let mut text = format!(
        "    def Xform \"{}\" (\n        prepend apiSchemas = [\"PhysicsRigidBodyAPI\", \"PhysicsMassAPI\"]\n    )\n    {{\n        \
         point3f physics:centerOfMass = {}\n        float3 physics:diagonalInertia = {}\n        \
         float physics:mass = {}\n        quatf physics:principalAxes = {}\n\n",
        identifier(&link.name),
        tuple(link.inertia.centre_m.iter().copied()),
        tuple(moments),
        number(link.inertia.mass_kg),
        tuple(quaternion(&axes)),
    );
    for shape in &link.visuals {
        let [r, g, b, opacity] = shape.rgba;
        let color = format!(
            "            color3f[] primvars:displayColor = [{}]\n            float[] primvars:displayOpacity = [{}]\n",
            tuple([r, g, b]),
            number(opacity)
        );
        text += &write_mesh(&format!("seen_{}", shape.name), shape, "", &color);
    }
    let touch = robot.touch.as_ref().filter(|touch| touch.link == link.name);
    for shape in &link.collisions {
        let mut schemas = "\"PhysicsCollisionAPI\", \"PhysicsMeshCollisionAPI\"".to_owned();
        let mut more =
            "            uniform token physics:approximation = \"convexHull\"\n            \
                        uniform token purpose = \"guide\"\n"
                .to_owned();
        if link.friction.is_some() {
            schemas += ", \"MaterialBindingAPI\"";
            // Writing to a string cannot fail.
            let _ = writeln!(
                more,
                "            rel material:binding:physics = </{}/{}>",
                identifier(&robot.name),
                material_name(link)
            );
        }
        let touched = touch.filter(|touch| touch.mesh.file == shape.mesh.file);
        if let Some(touch) = touched {
            more += &tetrahedra(&touch.tetrahedra);
        }
        text += &write_mesh(&shape.name, shape, &schemas, &more);
    }
    if is_base {
        for frame in &robot.frames {
            let _ = write!(
                text,
                "        def Xform \"{}\"\n        {{\n{}        }}\n\n",
                identifier(&frame.name),
                write_transform(&frame.sensor_from_frame, frame.sensor_from_frame.rotation())
            );
        }
        text += &write_camera(&robot.camera);
    }
    text + "    }\n\n"
}

/// Writes the camera, which looks along -z with y up. Apertures and focal length are in tenths of a metre; only their
/// ratio matters.
fn write_camera(camera: &RobotCamera) -> String {
    let [across, down] = camera.size_px.map(|px| number(FOCAL * f64::from(px) / camera.focal_px));
    format!(
        "        def Camera \"camera\"\n        {{\n            float2 clippingRange = {}\n            float focalLength = {}\n            \
         float horizontalAperture = {across}\n            float verticalAperture = {down}\n            \
         token projection = \"perspective\"\n{}        }}\n",
        tuple([camera.near_mm / MM_PER_M, 1.0]),
        number(FOCAL),
        write_transform(&camera.sensor_from_camera, &opengl_rotation(camera)),
    )
}

fn write_transform(pose: &Pose, rotation: &Matrix3<f64>) -> String {
    format!(
        "            quatd xformOp:orient = {}\n            double3 xformOp:translate = {}\n            \
         uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"]\n",
        tuple(quaternion(rotation)),
        tuple(pose.translation_mm().iter().map(|mm| mm / MM_PER_M)),
    )
}

fn write_mesh(name: &str, shape: &RobotShape, schemas: &str, more: &str) -> String {
    let RobotMesh { vertices_mm, triangles, .. } = &*shape.mesh;
    let schemas = match schemas {
        "" => String::new(),
        all => format!(" (\n            prepend apiSchemas = [{all}]\n        )"),
    };
    let [least, most] = shape.mesh.bounds_mm().map(|end| tuple(end.map(|mm| mm / MM_PER_M)));
    format!(
        "        def Mesh \"{}\"{schemas}\n        {{\n            float3[] extent = [{}, {}]\n            \
         int[] faceVertexCounts = [{}]\n            int[] faceVertexIndices = [{}]\n            \
         point3f[] points = [{}]\n{more}            uniform token subdivisionScheme = \"none\"\n        }}\n\n",
        identifier(name),
        least,
        most,
        vec!["3"; triangles.len()].join(", "),
        indices(triangles.iter().flatten()),
        points(vertices_mm),
    )
}

fn indices<'a>(all: impl Iterator<Item = &'a u32>) -> String {
    all.map(u32::to_string).collect::<Vec<_>>().join(", ")
}

fn points(all_mm: &[[f64; 3]]) -> String {
    let point = |place: &[f64; 3]| tuple(place.map(|mm| mm / MM_PER_M));
    all_mm.iter().map(point).collect::<Vec<_>>().join(", ")
}

/// Writes the attributes with the tetrahedra.
fn tetrahedra(mesh: &RobotTetrahedra) -> String {
    // The surface attributes need nodes numbered by themselves.
    let mut known = vec![None; mesh.points_mm.len()];
    let mut surface = Vec::new();
    let mut corners = Vec::new();
    for node in mesh.surface.iter().flatten() {
        let at = *known[*node as usize].get_or_insert_with(|| {
            surface.push(mesh.points_mm[*node as usize]);
            surface.len() as u32 - 1
        });
        corners.push(at);
    }
    format!(
        "            custom int[] tet_indices = [{}]\n            custom vector3f[] tet_points = [{}]\n            \
         custom int[] tet_surf_indices = [{}]\n            custom vector3f[] tet_surf_points = [{}]\n",
        indices(mesh.cells.iter().flatten()),
        points(&mesh.points_mm),
        indices(corners.iter()),
        points(&surface),
    )
}

/// Returns the principal moments, and the principal axes as the columns of a rotation.
fn principal(inertia: &Inertia) -> ([f64; 3], Matrix3<f64>) {
    let eigen = inertia.about_centre.symmetric_eigen();
    let [a, b]: [Vector3<f64>; 2] = [0, 1].map(|k| eigen.eigenvectors.column(k).into_owned());
    // An eigenvector may point either way; the cross product makes the axes right-handed.
    (eigen.eigenvalues.into(), Matrix3::from_columns(&[a, b, a.cross(&b)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_axes_make_the_inertia_again() {
        let inertia = Inertia {
            mass_kg: 1.0,
            centre_m: Vector3::zeros(),
            about_centre: Matrix3::new(3.0, 0.2, -0.1, 0.2, 2.0, 0.4, -0.1, 0.4, 4.0),
        };
        let (moments, axes) = principal(&inertia);
        let again = axes * Matrix3::from_diagonal(&Vector3::from(moments)) * axes.transpose();
        assert!((again - inertia.about_centre).norm() < 1e-12);
        assert!((axes.determinant() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn names_are_identifiers() {
        assert_eq!(identifier("9dtact"), "_9dtact");
        assert_eq!(identifier("screw-m1-6x5"), "screw_m1_6x5");
        assert_eq!(quoted("a \"b\"\\"), "a \\\"b\\\"\\\\");
    }
}
