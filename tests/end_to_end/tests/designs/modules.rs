//! Camera modules that can be bought: each goes into the sensors of its kind, or says what would have to
//! give, and what a user writes beside its name stays.

use fabkit_designs::parameters::InvalidDesign;
use fabkit_designs::{builtin_yaml, camera_modules, load};

fn with(sensor: &str, settings: &[&str]) -> Result<Vec<(String, String)>, InvalidDesign> {
    let settings: Vec<String> = settings.iter().map(|set| (*set).to_owned()).collect();
    let design = load(sensor, builtin_yaml(sensor).unwrap(), &settings, &["fixtures"])?;
    Ok(design.parameters.into_iter().map(|setting| (setting.path, setting.value)).collect())
}

fn value<'a>(settings: &'a [(String, String)], path: &str) -> &'a str {
    let found = settings.iter().find(|(known, _)| known == path);
    found.map(|(_, value)| value.as_str()).unwrap_or_default()
}

#[test]
fn a_module_brings_its_sizes_under_the_names_of_the_family() {
    let settings = with("fluidic", &["camera.module=ov9281-uvc-32"]).unwrap();
    assert_eq!(value(&settings, "camera.board_size"), "32 mm");
    assert_eq!(value(&settings, "camera.hole_spacing"), "28 mm");
    assert!(value(&settings, "camera.model").contains("OV9281"));
}

#[test]
fn what_is_written_beside_a_module_stays() {
    let settings =
        with("fluidic", &["camera.module=ov9281-uvc-32", "camera.hole_spacing=27mm"]).unwrap();
    assert_eq!(value(&settings, "camera.hole_spacing"), "27 mm");
}

#[test]
fn a_module_in_a_file_yields_to_the_command_line() {
    let yaml = "format: 1\nextends: fluidic\ncamera: {module: ov9281-uvc-32}\n";
    let design = load("own.yaml", yaml, &["camera.module=none".into()], &["fixtures"]).unwrap();
    let board = design.parameters.iter().find(|s| s.path == "camera.board_size").unwrap();
    assert_eq!(board.value, "38 mm");
    let design = load("own.yaml", yaml, &[], &["fixtures"]).unwrap();
    let board = design.parameters.iter().find(|s| s.path == "camera.board_size").unwrap();
    assert_eq!(board.value, "32 mm");
}

#[test]
fn every_module_fits_or_says_what_is_in_its_way() {
    let mut taken = 0;
    for sensor in ["rtac0", "shadowtac", "tactip", "uvdtact", "fluidic", "9dtact"] {
        for module in camera_modules() {
            match with(sensor, &[&format!("camera.module={module}")]) {
                Ok(settings) => {
                    taken += 1;
                    assert_eq!(value(&settings, "camera.module"), module);
                }
                Err(error) => {
                    for problem in &error.problems {
                        assert!(problem.hint.is_some(), "{sensor} {module}: {problem:?}");
                    }
                }
            }
        }
    }
    assert!(taken >= 6, "{taken} modules fit");
}

#[test]
fn a_slip_and_another_kind_of_camera_are_told_apart() {
    let code = |sensor: &str, module: &str| {
        let error = with(sensor, &[&format!("camera.module={module}")]).unwrap_err();
        error.problems[0].facts.code
    };
    assert_eq!(code("tactip", "adns"), "unknown_module");
    assert_eq!(code("uvdtact", "ov9281-uvc-38"), "wrong_module");
}
