//! fabkit's own camera format, which is lossless.

use std::fmt::Write;

use fabkit_text::{YamlNode, suggestion, to_printable};
use nalgebra::{DMatrix, Point3};

use super::fields::FieldReader;
use super::{CameraFile, InvalidCameraFile, YamlFault, list, number};
use crate::error::InvalidCamera;
use crate::estimate::CameraEstimate;
use crate::interface::{FlatInterface, Interface, SphericalInterface};
use crate::lens::{INTRINSICS, Intrinsics, Lens, LensModel};
use crate::plausibility::{CameraFinding, plausibility};

/// Key that identifies this format; its value is the version.
pub(super) const VERSION_KEY: &str = "fabkit_camera";
const VERSION: &str = "1";

/// Key that turns refusals of impossible cameras into warnings, with its only value. It is written for such cameras.
pub(super) const UNUSUAL: &str = "unusual";
const ACCEPTED: &str = "accepted";

/// Keys of a flat interface, calibrated or not.
const FLAT: [&str; 7] = [
    "interface_distance_mm",
    "interface_tilt_x_rad",
    "interface_tilt_y_rad",
    "interface_index_inside",
    "interface_index_outside",
    "interface_glass_thickness_mm",
    "interface_index_glass",
];

/// Keys of a spherical interface.
const SPHERE: [&str; 6] = [
    "interface_centre_x_mm",
    "interface_centre_y_mm",
    "interface_centre_z_mm",
    "interface_radius_mm",
    "interface_index_inside",
    "interface_index_outside",
];

/// Key for drawn bodies behind an interface; absent if there are none.
const BEHIND: &str = "behind";

/// Writes a camera in fabkit's own format.
pub(super) fn write(estimate: &CameraEstimate) -> String {
    let camera = estimate.camera();
    let mut text = format!(
        "# Camera frame: +z forward, +x right, +y down, mm. The first pixel's centre is (0, 0).\n\
         {VERSION_KEY}: {VERSION}\nwidth_px: {}\nheight_px: {}\nlens:\n  model: {}\n",
        camera.width_px(),
        camera.height_px(),
        camera.lens().model_name(),
    );
    write_pairs(&mut text, camera.lens().parameters());
    if plausibility(camera).iter().any(CameraFinding::is_impossible) {
        // Writing to a string cannot fail, here and below.
        let _ = writeln!(text, "{UNUSUAL}: {ACCEPTED}");
    }
    let (names, values) = interface_values(camera.interface());
    if *camera.interface() != Interface::None {
        let _ = writeln!(text, "interface:\n  kind: {}", camera.interface().kind_name());
        write_pairs(&mut text, names.iter().copied().zip(values));
        if camera.interface().has_drawn_bodies_behind() {
            let _ = writeln!(text, "  {BEHIND}: drawn");
        }
    }
    if let Some(covariance) = estimate.covariance() {
        let names = estimate.names().join(", ");
        let _ = writeln!(text, "covariance:\n  names: [{names}]\n  matrix:");
        for row in covariance.row_iter() {
            let _ = writeln!(text, "    - {}", list(row.iter().copied()));
        }
    }
    text
}

fn write_pairs(text: &mut String, pairs: impl Iterator<Item = (&'static str, f64)>) {
    for (name, value) in pairs {
        let _ = writeln!(text, "  {name}: {}", number(value));
    }
}

/// Returns keys and values of an interface, calibrated or not.
fn interface_values(interface: &Interface) -> (&'static [&'static str], Vec<f64>) {
    match interface {
        Interface::None | Interface::FromDrawing => (&[], Vec::new()),
        Interface::Flat(flat) => (
            &FLAT,
            vec![
                flat.distance_mm,
                flat.tilt_x_rad,
                flat.tilt_y_rad,
                flat.index_inside,
                flat.index_outside,
                flat.glass_thickness_mm,
                flat.index_glass,
            ],
        ),
        Interface::Sphere(sphere) => (
            &SPHERE,
            vec![
                sphere.centre_in_camera.x,
                sphere.centre_in_camera.y,
                sphere.centre_in_camera.z,
                sphere.radius_mm,
                sphere.index_inside,
                sphere.index_outside,
            ],
        ),
    }
}

/// Reads a camera in fabkit's own format.
pub(super) fn read(root: &YamlNode) -> Result<CameraFile, InvalidCameraFile> {
    let mut fields = FieldReader::default();
    if let Some((version, line)) = fields.text(root, VERSION_KEY)
        && version != VERSION
    {
        let message = format!("version `{}` is not known", to_printable(version));
        let hint = format!("this fabkit reads version {VERSION}");
        return Err(YamlFault::new(line, VERSION_KEY, message).hint(hint).into());
    }
    let known = [VERSION_KEY, "width_px", "height_px", "lens", UNUSUAL, "interface", "covariance"];
    fields.require_known_keys(root, &known);
    if let Some((word, line)) = root.get(UNUSUAL).and_then(|_| fields.text(root, UNUSUAL)) {
        fields.accepts_unusual = word == ACCEPTED;
        if word != ACCEPTED {
            let message = format!("is `{}`, but must be `{ACCEPTED}`", to_printable(word));
            fields.fault(YamlFault::new(line, UNUSUAL, message).hint("or leave the line out"));
        }
    }
    let size = ["width_px", "height_px"]
        .map(|key| fields.child(root, key).map_or(0, |node| fields.pixels(node, key)));
    let lens = fields.child(root, "lens").and_then(|node| read_lens(&mut fields, node));
    let interface = root.get("interface").map(|node| read_interface(&mut fields, node));
    let interface = interface.unwrap_or(Interface::None);
    let names: Vec<&str> = match &lens {
        Some(Ok(lens)) => {
            let of_lens = lens.parameters().map(|(name, _)| name);
            let (of_interface, count) = interface.parameters();
            of_lens.chain(of_interface.into_iter().take(count).map(|(name, _)| name)).collect()
        }
        // Without a lens the parameters' names are unknown, and the lens itself is reported.
        _ => return Err(fields.into_faults(size.into(), lens, interface)),
    };
    let covariance = root.get("covariance");
    let covariance = covariance.and_then(|node| read_covariance(&mut fields, node, &names));
    fields.into_camera(size.into(), lens, interface, covariance)
}

/// Reads the lens; `None` if its model is missing or unknown.
fn read_lens(fields: &mut FieldReader, map: &YamlNode) -> Option<Result<Lens, InvalidCamera>> {
    let (model, line) = fields.text(map, "model")?;
    let is_given = |name: &str| map.get(name).is_some();
    let Some(coefficients) = LensModel::coefficients_in_file(model, is_given) else {
        let message = format!("`{}` is not a lens model", to_printable(model));
        let hint = suggestion(model, LensModel::file_names(), "known");
        fields.fault(YamlFault::new(line, "model", message).hint(hint));
        return None;
    };
    fields.require_known_keys(map, &[&["model"], &INTRINSICS[..], coefficients].concat());
    let [fx_px, fy_px, cx_px, cy_px] = INTRINSICS.map(|name| fields.number(map, name));
    let intrinsics = Intrinsics { fx_px, fy_px, cx_px, cy_px };
    let k: Vec<f64> = coefficients.iter().map(|name| fields.number(map, name)).collect();
    Lens::from_model_name(model, intrinsics, &k)
}

/// Reads the interface; [`Interface::None`] if its kind is missing or unknown.
fn read_interface(fields: &mut FieldReader, map: &YamlNode) -> Interface {
    let Some((kind, line)) = fields.text(map, "kind") else { return Interface::None };
    match kind {
        "none" | "drawn" => {
            fields.require_known_keys(map, &["kind"]);
            if kind == "drawn" { Interface::FromDrawing } else { Interface::None }
        }
        "flat" => {
            fields.require_known_keys(map, &[&["kind", BEHIND], &FLAT[..]].concat());
            let [
                distance_mm,
                tilt_x_rad,
                tilt_y_rad,
                index_inside,
                index_outside,
                glass_thickness_mm,
                index_glass,
            ] = FLAT.map(|name| fields.number(map, name));
            Interface::Flat(FlatInterface {
                distance_mm,
                tilt_x_rad,
                tilt_y_rad,
                index_inside,
                index_outside,
                glass_thickness_mm,
                index_glass,
                has_drawn_bodies_behind: read_behind(fields, map),
            })
        }
        "sphere" => {
            fields.require_known_keys(map, &[&["kind", BEHIND], &SPHERE[..]].concat());
            let [x_mm, y_mm, z_mm, radius_mm, index_inside, index_outside] =
                SPHERE.map(|name| fields.number(map, name));
            let centre_in_camera = Point3::new(x_mm, y_mm, z_mm);
            Interface::Sphere(SphericalInterface {
                centre_in_camera,
                radius_mm,
                index_inside,
                index_outside,
                has_drawn_bodies_behind: read_behind(fields, map),
            })
        }
        other => {
            let message = format!("`{}` is not a kind of interface", to_printable(other));
            fields.fault(YamlFault::new(line, "kind", message).hint(suggestion(
                other,
                ["none", "drawn", "flat", "sphere"],
                "known",
            )));
            Interface::None
        }
    }
}

/// Reads whether drawn bodies refract rays behind an interface.
fn read_behind(fields: &mut FieldReader, map: &YamlNode) -> bool {
    let Some((behind, line)) = map.get(BEHIND).and_then(|_| fields.text(map, BEHIND)) else {
        return false;
    };
    if behind != "drawn" {
        let message =
            format!("`{}` is nothing that stands behind an interface", to_printable(behind));
        let hint = "`drawn`, or nothing where no rays are bent again";
        fields.fault(YamlFault::new(line, BEHIND, message).hint(hint));
    }
    behind == "drawn"
}

/// Reads an N x N covariance, if its names and size fit the camera's `names`.
fn read_covariance(
    fields: &mut FieldReader,
    map: &YamlNode,
    names: &[&str],
) -> Option<DMatrix<f64>> {
    fields.require_known_keys(map, &["names", "matrix"]);
    let n = names.len();
    let written = fields.child(map, "names")?;
    let words = written.items().iter().map(|item| item.text().unwrap_or_default());
    if !words.eq(names.iter().copied()) {
        let hint = format!("this camera has {}", names.join(", "));
        let fault =
            YamlFault::new(written.position, "names", "are not the parameters of this camera");
        fields.fault(fault.hint(hint));
        return None;
    }
    let matrix = fields.child(map, "matrix")?;
    let rows = matrix.items();
    if rows.len() != n {
        fields.fault(YamlFault::new(matrix.position, "matrix", format!("must have {n} rows")));
        return None;
    }
    let mut values = Vec::with_capacity(n * n);
    for row in rows {
        let numbers = fields.numbers(row, "matrix");
        if numbers.len() != n {
            let message = format!("a row has {} numbers; {n} are needed", numbers.len());
            fields.fault(YamlFault::new(row.position, "matrix", message));
            return None;
        }
        values.extend(numbers);
    }
    Some(DMatrix::from_row_slice(n, n, &values))
}
