//! Command lines for calibrating a sensor, for its guide.

use fabkit_application::guide::CalibrationCommand;
use fabkit_application::source::Target;

/// Lists the command lines for a design's fixtures, in their order. `pins_in` is the fixture whose pins determine the
/// camera pose.
pub(super) fn calibration_commands(
    names: &[&str],
    pins_in: Option<&str>,
    target: Target,
    overrides: &[String],
) -> Vec<CalibrationCommand> {
    let sensor = match target.preset {
        None => target.sensor.to_owned(),
        Some(preset) => format!("{}-{preset}", target.sensor),
    };
    let sensor = quote_word(&sensor);
    let set: String = overrides.iter().map(|set| format!(" --set {}", quote_word(set))).collect();
    let line = |what: &str, line: String| CalibrationCommand { what: what.to_owned(), line };
    let mut lines = Vec::new();
    if names.contains(&"boards") {
        lines.push(line(
            "print the board at 100 % and measure its ruler; take 10 to 20 images of it before the camera goes \
             into the sensor, tilted, out to the image's border",
            format!("fabkit export {sensor}/boards{set} -o boards"),
        ));
        lines.push(line(
            "calibrate the lens",
            format!(
                "fabkit calibrate intrinsics {sensor}{set} --board boards/charuco.board.json images/*.png \
                 -o camera.yaml --report lens.html"
            ),
        ));
    }
    if let Some(fixture) = pins_in {
        lines.push(line(
            "print the pins and the part that guides them, as the guide of that fixture says",
            format!("fabkit export {sensor}/{fixture}{set} -o {fixture}"),
        ));
        lines.push(line(
            "check what the pins will determine, before you print",
            format!("fabkit check {sensor}/{fixture}{set}"),
        ));
        lines.push(line(
            "calibrate the camera's pose, once the images of the sheet below lie in `captures`",
            format!(
                "fabkit calibrate extrinsics {sensor}{set} --camera camera.yaml --captures captures \
                 -o pose.yaml --report pose.html"
            ),
        ));
    }
    for halves in names.iter().filter(|name| matches!(**name, "semi-domes" | "half-plates")) {
        lines.push(line(
            "print halves that press known shapes into the surface, for training",
            format!("fabkit export {sensor}/{halves}{set} -o {halves}"),
        ));
        lines.push(line(
            "compute what the camera must see under each half",
            format!("fabkit dataset {sensor}{set} --camera camera.yaml --pose pose.yaml -o data"),
        ));
    }
    lines
}

/// Quotes a word for a shell, where necessary.
fn quote_word(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:%+@".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}
