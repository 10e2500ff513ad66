//! Parameters of bought things, whose values cannot be changed by writing others.

/// Sections of bought things. All keys of a section belong to the bought thing except the listed ones, which say where
/// it is placed.
const SECTIONS: &[(&str, &[&str])] =
    &[("camera", &["depth", "front_depth", "back_clearance"]), ("seal", &["squeeze"])];

/// Parameters of bought things in sections that also hold others.
const VALUES: &[&str] = &[
    "connector.o_ring_cord",
    "display.camera_spacer",
    "form.tube_rim",
    "housing.led_strip_length",
    "housing.led_strip_thickness",
    "housing.led_strip_width",
    "leds.board_thickness",
    "leds.diameter",
    "leds.forward_volts",
    "leds.height",
    "leds.length",
    "leds.package_height",
    "leds.package_size",
    "leds.rated_ma",
    "leds.strip_thickness",
    "leds.supply_ma",
    "leds.uv_forward_volts",
    "leds.white_forward_volts",
    "leds.width",
    "mold.dowel_diameter",
    "mold.dowel_length",
    "tube.wall",
    "tubes.inner_diameter",
    "tubes.needle_inner_diameter",
    "tubes.needle_length",
    "tubes.needle_outer_diameter",
    "tubes.outer_diameter",
];

/// Returns whether a parameter describes a bought thing.
///
/// ```
/// use fabkit_designs::fixing::is_bought;
/// assert!(is_bought("camera.board_size"));
/// // Where the camera stands is up to the designer.
/// assert!(!is_bought("camera.depth"));
/// ```
pub fn is_bought(path: &str) -> bool {
    let in_section = path.split_once('.').is_some_and(|(section, key)| {
        SECTIONS.iter().any(|(bought, but)| *bought == section && !but.contains(&key))
    });
    in_section || VALUES.contains(&path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::REGISTRY;

    #[test]
    fn bought_parameters_exist_in_some_family() {
        let families = REGISTRY.families().iter();
        let paths: Vec<String> =
            families.flat_map(|family| REGISTRY.parameter_paths(family.name())).collect();
        let is_known = |wanted: &str| paths.iter().any(|path| path == wanted);
        assert!(VALUES.iter().all(|path| is_known(path)), "{VALUES:?}");
        for (section, but) in SECTIONS {
            assert!(but.iter().all(|key| is_known(&format!("{section}.{key}"))), "{section}");
        }
        assert!(is_bought("camera.board_size") && !is_bought("camera.depth"));
    }
}
