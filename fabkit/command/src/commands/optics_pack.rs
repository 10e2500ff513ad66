//! `fabkit optics-pack SENSOR -o DIR`

use fabkit_application::capturing::optics_pack;
use fabkit_application::staging::write_all;
use serde_json::{Value, json};

use super::{Outcome, view};
use crate::cli::OpticsPack;
use crate::failure::Failure;
use crate::interrupt;
use crate::table::format_size;

pub(super) fn run(args: &OpticsPack) -> Result<Outcome, Failure> {
    let output = Some(args.output.join("optics.json"));
    view::roles(&args.design, &args.camera)
        .reads("--constants", &args.light.constants)
        .writes("-o", &output)
        .check()?;
    let scene = view::build_scene(&args.design, &args.camera)?;
    let (lighting, constants) = view::find_lighting(&scene.project, &args.light)?;
    let pack = optics_pack(&scene, lighting, &constants)?;
    interrupt::begin_writing()?;
    write_all(&args.output, &pack.files, &interrupt::is_requested)?;
    let mut json = pack.document;
    let folder = args.output.display();
    json["folder"] = json!(folder.to_string());
    let listed = pack.files.iter();
    json["files"] =
        listed.map(|file| json!({ "file": file.name, "bytes": file.bytes.len() })).collect();
    let mut text = String::new();
    for file in &pack.files {
        text += &format!("{folder}/{}: {}\n", file.name, format_size(file.bytes.len() as u64));
    }
    text += &words(&json);
    Ok(Outcome { text, json, failed: false })
}

fn words(json: &Value) -> String {
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let of = |name: &str| number(&json[name]);
    let size = format!("simulated; {} x {} px", json["width_px"], json["height_px"]);
    if json["shows"] == "slopes" {
        let [least, most] = [0, 1].map(|k| number(&json["mm_per_pixel_range"][k]));
        return format!(
            "{size} of {:.4} mm ({least:.4} to {most:.4}, taken as one); polynomials over the whole image miss {:.0} % of the change by gentle slopes\n",
            of("mm_per_pixel"),
            100.0 * of("polynomials_miss"),
        );
    }
    let darkest = json["darkest_grey"].as_array().map(Vec::as_slice).unwrap_or_default();
    let ends = darkest.iter().map(|grey| grey.to_string()).collect::<Vec<_>>().join(", ");
    format!("{size}; the layers end at intensities {ends} below those at rest\n")
}
