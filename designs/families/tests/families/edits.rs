//! How far the built-in sensors follow their users: one parameter of each changed alone.
//!
//! `cargo xtask edits` prints what is refused, and why.

use std::{env, fs};

use fabkit_designs::fixing::fix;
use fabkit_designs::parameters::{Problem, Setting, ValueKind};
use fabkit_designs::{SensorText, load};

/// Shares by which parameters are changed.
const SHARES: [f64; 2] = [0.1, 0.25];

/// Set to 1, both shares are tried, and every edit that is refused is fixed, which takes minutes;
/// else the larger share alone, and a sample of what it refuses.
const FULL: &str = "FABKIT_FULL";

struct Edit {
    path: String,
    value: String,
    /// Why it is refused; empty where it is not.
    problems: Vec<Problem>,
    /// What else has to change so that it is not, or why that cannot be.
    fixed: Result<Vec<String>, String>,
}

/// Of the edits that are refused, how many are fixed, unless all are: one in so many.
const FIXED_STEP: usize = 24;

/// What becomes of a sensor with each of its numeric parameters changed alone, down and up by a share,
/// counts to the nearest whole number.
fn edits(sensor: &str, yaml: &str, share: f64) -> Vec<Edit> {
    let load = |overrides: &[String]| load(sensor, yaml, overrides, &["fixtures"]);
    let design = load(&[]).unwrap_or_else(|e| panic!("{sensor}: {:#?}", e.problems));
    let (mut edits, mut refused) = (Vec::new(), 0);
    for setting in &design.parameters {
        for value in [-share, share].into_iter().filter_map(|by| changed(setting, by)) {
            let path = setting.path.clone();
            let overrides = [format!("{path}={value}")];
            let problems = load(&overrides).err().map(|e| e.problems).unwrap_or_default();
            let is_asked = !problems.is_empty() && (is_full() || refused % FIXED_STEP == 0);
            refused += usize::from(!problems.is_empty());
            let fixed = if is_asked { fixed(sensor, yaml, &overrides) } else { Ok(Vec::new()) };
            edits.push(Edit { path, value, problems, fixed });
        }
    }
    edits
}

fn is_full() -> bool {
    env::var_os(FULL).is_some_and(|value| value == "1")
}

/// The changes that a fix makes, which must work; or what contradicts each other.
fn fixed(sensor: &str, yaml: &str, overrides: &[String]) -> Result<Vec<String>, String> {
    match fix(SensorText::without_bases(sensor, yaml), overrides, &["fixtures"]) {
        Ok(changes) => {
            let set = changes.iter().map(|change| change.as_override());
            let all: Vec<String> = overrides.iter().cloned().chain(set).collect();
            let loaded = load(sensor, yaml, &all, &["fixtures"]);
            if let Err(refused) = loaded {
                return Err(format!("not fixed by {all:?}: {:?}", refused.problems[0].message));
            }
            assert_eq!(
                fix(SensorText::without_bases(sensor, yaml), &all, &["fixtures"]).unwrap(),
                [],
                "{all:?}"
            );
            Ok(changes.iter().map(ToString::to_string).collect())
        }
        Err(refused) => Err(refused.problems[0].message.clone()),
    }
}

/// The value more by a share, as it would be written; nothing for texts and lists, or if it is 0.
fn changed(setting: &Setting, by: f64) -> Option<String> {
    let (number, unit) = match setting.value.split_once(' ') {
        Some((number, unit)) => (number, format!(" {unit}")),
        None => (setting.value.as_str(), String::new()),
    };
    let number: f64 = match setting.kind {
        ValueKind::Length | ValueKind::Angle | ValueKind::Count | ValueKind::Number => {
            number.parse().ok()?
        }
        ValueKind::Switch | ValueKind::Text | ValueKind::List => return None,
    };
    let other = match setting.kind {
        _ if number == 0.0 => return None,
        ValueKind::Count => (number * (1.0 + by)).round(),
        // To a nanometre: nobody writes more.
        _ => (number * (1.0 + by) * 1e6).round() / 1e6,
    };
    (other != number).then(|| format!("{other}{unit}"))
}

/// At most these shares of the edits by 10 % and by 25 % are refused, percent, as they are and where chosen
/// values may follow: what is measured, so that less freedom shows.
fn few_are_refused(sensor: &str, most_percent: [f64; 2], most_fixed_percent: [f64; 2]) {
    // Read, not built in: so that whoever edits a sensor need not build anything.
    let file = format!("{}/sensors/{sensor}.yaml", env!("CARGO_MANIFEST_DIR"));
    let yaml = fs::read_to_string(&file).unwrap();
    let mut too_many = Vec::new();
    let tried = SHARES.into_iter().zip(most_percent).zip(most_fixed_percent);
    for ((share, most), most_fixed) in tried.skip(usize::from(!is_full())) {
        let edits = edits(sensor, &yaml, share);
        let refused: Vec<&Edit> = edits.iter().filter(|e| !e.problems.is_empty()).collect();
        let percent = 100.0 * refused.len() as f64 / edits.len() as f64;
        let (of, by) = (edits.len(), 100.0 * share);
        let summary =
            format!("{sensor} by {by} %: {} of {of} refused, {percent:.1} %", refused.len());
        println!("{summary}");
        for edit in refused {
            println!("  {} = {}", edit.path, edit.value);
            edit.problems.iter().for_each(|problem| println!("      {}", problem.message));
            match &edit.fixed {
                Ok(changes) => changes.iter().for_each(|change| println!("    fixed: {change}")),
                Err(why) => println!("    not fixed: {why}"),
            }
        }
        let left: Vec<&Edit> = edits.iter().filter(|edit| edit.fixed.is_err()).collect();
        let left_percent = 100.0 * left.len() as f64 / edits.len() as f64;
        println!("{sensor} by {by} %, fixed: {} of {of} refused, {left_percent:.1} %", left.len());
        for edit in &left {
            let why = edit.fixed.as_ref().unwrap_err();
            if !why.starts_with("a contradiction: ") && !why.contains("; it must be between ") {
                too_many.push(format!("{} = {}: {why}", edit.path, edit.value));
            }
        }
        if is_full() && left_percent > most_fixed {
            too_many.push(format!("{sensor} by {by} %: {left_percent:.1} % even if fixed"));
        }
        if percent > most {
            too_many.push(format!("{summary}; at most {most} % were"));
        }
    }
    assert!(too_many.is_empty(), "{too_many:#?}");
}

#[test]
fn dome() {
    few_are_refused("rtac0", [6.5, 12.3], [5.8, 10.3]);
}

#[test]
fn dome_cap() {
    few_are_refused("shadowtac", [5.5, 11.7], [5.5, 10.9]);
}

#[test]
fn pin_tip() {
    few_are_refused("tactip", [5.0, 14.3], [2.6, 9.1]);
}

#[test]
fn half_ellipsoid() {
    // At 2.25 V its white lamps take more than their common resistor bears; 6.25 V is no supply that it knows.
    few_are_refused("uvdtact", [3.9, 8.5], [3.9, 5.7]);
}

#[test]
fn sheet_mold() {
    few_are_refused("fluidic", [2.9, 14.1], [1.6, 4.0]);
}

#[test]
fn flat_gel() {
    few_are_refused("9dtact", [1.0, 7.7], [0.0, 4.9]);
    few_are_refused("digit-like", [7.0, 11.8], [1.0, 3.0]);
    few_are_refused("gelsight-like", [1.0, 4.8], [1.0, 3.8]);
}

/// A sweep over camera and gel is not lost to lengths that belong together.
#[test]
fn most_random_variants_of_a_dome_can_be_built() {
    const VARIANTS: u32 = 100;
    let yaml = fabkit_designs::builtin_yaml("rtac0").unwrap();
    let mut state = 1u64;
    // Knuth's constants; the upper bits are random enough.
    let mut between = |low: f64, high: f64| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((state >> 11) as f64 / (1u64 << 53) as f64)
    };
    let valid = (0..VARIANTS)
        .filter(|_| {
            let overrides = [
                format!("camera.depth={:.3} mm", between(4.0, 10.0)),
                format!("camera.field_of_view={:.1} deg", between(100.0, 200.0)),
                format!("translucent_gel.thickness={:.3} mm", between(0.8, 3.0)),
            ];
            load("rtac0", yaml, &overrides, &["fixtures"]).is_ok()
        })
        .count();
    println!("{valid} of {VARIANTS} variants of rtac0 can be built");
    assert!(valid >= 72, "{valid} of {VARIANTS}");
}
