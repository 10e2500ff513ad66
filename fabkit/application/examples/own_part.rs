//! Builds a part from its exact solid and writes files for a printer:
//! `cargo run --release -p fabkit-application --example own_part -- FOLDER` writes `foot.stl` and `foot.3mf`.

use std::error::Error;
use std::f64::consts::TAU;
use std::path::Path;

use fabkit_application::designs::blocks::hanging;
use fabkit_application::designs::blocks::label::{Label, LabelError};
use fabkit_application::geometry::{
    Body, CUT_OVERLAP_MM, CutFeature, Landmark, Pose, Process, Solid,
};
use fabkit_application::mesh::{DEFAULT_TOLERANCE_MM, mesh};
use fabkit_application::{export, staging};

const HEIGHT_MM: f64 = 8.0;

/// Makes a foot for a fingertip of 30 mm: a disc with a seat, screwed to the bench at three places.
fn foot() -> Result<Body, LabelError> {
    // The seat has 0.2 mm of play. Cuts begin slightly outside the face from which they start.
    let seat = Solid::cylinder(15.2, 5.0 + CUT_OVERLAP_MM).at(0.0, 0.0, HEIGHT_MM - 5.0);
    // The label is read from below: the z axis of a face points out of it.
    let label = Label::new("foot-30", 5.0, hanging([0.0; 2], 0.0))?;
    let foot = Body::made(
        "foot",
        "holds a fingertip upright",
        Process::Fdm,
        Solid::cylinder(25.0, HEIGHT_MM),
    )
    .with_material("PLA")
    .cut(CutFeature { tools: vec![seat.named("seat")], ..CutFeature::default() })
    .cut(screw_holes(3))
    .cut(label.sunken());
    Ok(foot)
}

/// Makes screw holes with their landmarks and the number of handles that they add, all in one place.
fn screw_holes(count: u32) -> CutFeature {
    let hole = Solid::cylinder(1.7, HEIGHT_MM + 2.0 * CUT_OVERLAP_MM).at(0.0, 0.0, -CUT_OVERLAP_MM);
    let holes = (1..=count).map(|i| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(count)).sin_cos();
        let (name, place) =
            (format!("screw hole {i}"), Pose::translation(20.0 * cos, 20.0 * sin, 0.0));
        (hole.clone().placed(place).named(&name), Landmark::at(name, &place))
    });
    let (tools, landmarks) = holes.unzip();
    CutFeature { tools, landmarks, handles: count as i32 }
}

/// Makes and writes the files, all or none.
pub fn run(folder: &Path) -> Result<(), Box<dyn Error>> {
    let foot = foot()?;
    let triangles = mesh(&foot.solid, DEFAULT_TOLERANCE_MM)?;
    // The genus counted by the author must be the mesh's: a hole that closed would be noticed here.
    assert_eq!(Some(triangles.genus()), foot.genus);
    // Moved into the positive octant, because 3MF has no negative coordinates.
    let print = triangles.placed(&Pose::translation(30.0, 30.0, 0.0)).to_print()?;
    println!("{}: {:.2} cm3", foot.summary, print.volume_mm3() / 1e3);
    let document = export::DocumentInfo { title: "Bench: foot", design_hash: "" };
    let (name, material, color) = (&foot.name, &foot.material, foot.color);
    let object = export::PrintObject {
        name,
        material,
        color,
        mesh: &print,
        settings: None,
        settings_note: "",
    };
    let file = |name: &str, bytes| staging::OutputFile { name: name.into(), bytes };
    let files = [
        file("foot.stl", export::stl(name, &print)?),
        file("foot.3mf", export::three_mf(document, &[object])?),
    ];
    Ok(staging::write_all(folder, &files, &|| false)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    run(Path::new(&std::env::args().nth(1).unwrap_or(".".into())))
}
