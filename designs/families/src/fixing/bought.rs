//! What is bought is as it is: no other value of it can be had by writing one.

/// Parameters of bought things, by section: every key of a section, but for what says where the thing
/// stands.
const SECTIONS: &[(&str, &[&str])] =
    &[("camera", &["depth", "front_depth", "back_clearance"]), ("seal", &["squeeze"])];

/// Parameters of bought things in sections that hold others too.
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

/// Whether a parameter is one of something that is bought.
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
    fn whatever_is_called_bought_is_a_parameter_of_some_family() {
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
