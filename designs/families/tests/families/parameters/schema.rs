//! The JSON Schema says what the reader checks.

use super::bulb::REGISTRY;
use fabkit_designs::parameters::Scalar;
use fabkit_geometry::{Angle, Length};
use proptest::prelude::*;
use proptest::string::string_regex;
use serde_json::{Value, json};

/// The schema of a dotted path within a definition.
fn at<'a>(schema: &'a Value, definition: &str, path: &str) -> &'a Value {
    path.split('.').fold(&schema["definitions"][definition], |s, key| &s["properties"][key])
}

#[test]
fn every_parameter_is_in_the_schema_with_text_and_limits() {
    let schema = REGISTRY.json_schema(&[]);
    assert_eq!(schema["$schema"], "http://json-schema.org/draft-07/schema#");
    let paths = REGISTRY.parameter_paths("bulb");
    // Ten of its own, and what every family has: five of labels, ten of adapters, one of loads.
    assert_eq!(paths.len(), 26);
    for definition in ["bulb", "bulb-variant"] {
        for path in paths.iter().map(String::as_str).chain(["name", "title", "reference"]) {
            let value = at(&schema, definition, path);
            let text = value["description"].as_str().unwrap();
            assert!(text.contains(" Allowed: "), "{path}: {text}");
            // Alone, or in a map with its source.
            let with_source = &value["anyOf"][1]["properties"]["value"];
            match value["anyOf"].get(2) {
                // A number may be an expression, in both forms.
                Some(expression) => {
                    assert_eq!(expression["pattern"], "^ *=", "{path}");
                    assert_eq!(with_source["anyOf"], json!([value["anyOf"][0], expression]));
                }
                None => assert_eq!(&value["anyOf"][0], with_source, "{path}"),
            }
            assert_eq!(value["anyOf"][1]["additionalProperties"], false);
        }
    }
    let radius = at(&schema, "bulb", "surface.radius");
    assert_eq!(radius["description"], "Radius of hemisphere and wall. Allowed: 4 mm to 60 mm.");
    assert!(radius["anyOf"][0]["pattern"].as_str().unwrap().contains("mm|cm"));
    assert_eq!(at(&schema, "bulb", "optics.leds")["anyOf"][0]["maximum"], 64);
    assert_eq!(at(&schema, "bulb", "optics.outline")["anyOf"][0]["enum"][1], "square");
    assert_eq!(at(&schema, "bulb", "optics.rings")["anyOf"][0]["maxItems"], 3);
}

#[test]
fn only_a_file_of_its_own_must_be_complete() {
    let schema = REGISTRY.json_schema(&[]);
    let surface = at(&schema, "bulb", "surface");
    assert_eq!(surface["required"], json!(["radius", "wall_height"]));
    assert_eq!(surface["additionalProperties"], false);
    assert!(at(&schema, "bulb-variant", "surface").get("required").is_none());
    assert_eq!(schema["properties"]["extends"]["anyOf"][0]["enum"], json!(["glow", "glow-wide"]));
    // Every definition that a case points at is there.
    for case in schema["allOf"].as_array().unwrap() {
        let name = case["then"]["$ref"].as_str().unwrap().trim_start_matches("#/definitions/");
        assert!(schema["definitions"][name].is_object(), "{name}");
    }
}

/// The built-in sensors of fabkit itself: each loads, and each value says where it comes from.
#[test]
fn built_in_sensors_load_and_state_their_sources() {
    use fabkit_designs::parameters::SourceKind;
    for name in fabkit_designs::builtin_names() {
        let yaml = fabkit_designs::builtin_yaml(name).unwrap();
        let design = fabkit_designs::load(name, yaml, &[], &["fixtures"])
            .unwrap_or_else(|e| panic!("{e:#?}"));
        assert_eq!(design.sensor.name, name);
        for setting in &design.parameters {
            assert!(setting.source.kind != SourceKind::User, "{name}: {}", setting.path);
            assert!(!setting.source.note.is_empty(), "{name}: {}", setting.path);
        }
    }
}

/// Text that the schema's pattern for a type allows.
fn allowed_text<T: Scalar>(limits: &T::Limits) -> impl Strategy<Value = String> + use<T> {
    let schema = T::schema(limits);
    let pattern = schema["pattern"].as_str().unwrap();
    string_regex(pattern.trim_start_matches('^').trim_end_matches('$')).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 256,
        rng_seed: proptest::test_runner::RngSeed::Fixed(2),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// What an editor accepts because of the schema, the reader can read, unless it overflows.
    #[test]
    fn patterns_allow_only_what_is_read(
        length in allowed_text::<Length>(&(0.0..=1.0)),
        angle in allowed_text::<Angle>(&(0.0..=1.0)),
    ) {
        let says = [
            <Length as Scalar>::parse(&length).err().map(|e| e.says),
            <Angle as Scalar>::parse(&angle).err().map(|e| e.says),
        ];
        for says in says.into_iter().flatten() {
            prop_assert_eq!(says, "is not finite", "{} {}", length, angle);
        }
    }

    /// And what fabkit itself writes, the schema allows and the reader reads back.
    #[test]
    fn what_is_shown_reads_back(mm in -1e6..1e6_f64, deg in -360.0..360.0_f64) {
        let length = Length::from_mm(mm).unwrap();
        prop_assert_eq!(<Length as Scalar>::parse(&length.show()), Ok(length));
        let angle = Angle::from_deg(deg).unwrap();
        let read = <Angle as Scalar>::parse(&angle.show()).unwrap();
        // Degrees are shown to 12 decimals; half of the last, and rounding at 360.
        prop_assert!((read.deg() - deg).abs() < 1e-12, "{} {}", read.deg(), deg);
    }
}
