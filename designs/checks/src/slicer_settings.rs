//! Print settings of filament parts, each with its reason: from notes, printers and the rules.

use fabkit_geometry::{Action, Assembly, Body, Process, Sensor};

use crate::scene::InvalidBody;
use crate::{material_questions, overhang, print_stability};

/// Usual layer height, mm: half the width of the usual nozzle of 0.4 mm, as in most printers' own profiles.
const LAYER_MM: f64 = 0.2;

/// Layer height of molds, mm, since a cast shows the layers of its mold. Chosen: the finest that usual printers make
/// without taking twice as long; the dome's molds note it.
const MOLD_LAYER_MM: f64 = 0.12;

/// Line width of a 0.4 mm nozzle in PrusaSlicer and OrcaSlicer, mm.
const LINE_MM: f64 = 0.45;

/// Thickness of solid layers below and above, mm; PrusaSlicer's own profiles ask for at least 0.7.
const SKIN_MM: f64 = 0.8;

/// Width of the brim of parts that may topple or warp, mm. Chosen: the value of PrusaSlicer's own profiles with a brim.
const BRIM_MM: f64 = 5.0;

/// A setting and the reason for it.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenSetting<T> {
    /// Value for the slicer.
    pub value: T,
    /// Reason, as text.
    pub reason: String,
}

/// Slicer settings of a filament part.
#[derive(Clone, Debug, PartialEq)]
pub struct PrintSettings {
    /// Height of a layer, mm.
    pub layer_mm: ChosenSetting<f64>,
    /// Line width for estimates of mass and time, mm; the slicer uses the printer's own.
    pub line_mm: f64,
    /// Number of lines along each outline.
    pub perimeters: ChosenSetting<u32>,
    /// Number of solid layers below, and the same number above.
    pub solid_layers: ChosenSetting<u32>,
    /// Fraction of the inside that is filled, %.
    pub infill_percent: ChosenSetting<f64>,
    /// Whether supports are printed.
    pub supports: ChosenSetting<bool>,
    /// Width of the brim, mm; 0 for none.
    pub brim_mm: ChosenSetting<f64>,
}

/// Purpose of a part, which determines usual print settings.
#[derive(Clone, Copy, PartialEq)]
enum Role {
    /// Wall of a mold, which comes off the cast layer.
    Mold,
    /// Part that stays in the sensor.
    Sensor,
    /// Any other part.
    Tool,
}

impl Role {
    /// Returns the purpose of a part: in the sensor, a wall of a pour, or any other.
    fn for_part(sensor: &Sensor, part: &Body) -> Self {
        let place = Assembly::sensor();
        if part.placements.iter().any(|placed| placed.assembly == place) {
            return Self::Sensor;
        }
        let is_wall = sensor.chain.iter().any(|step| match &step.action {
            Action::Pour(pour) => pour.walls.contains(&part.name),
            _ => false,
        });
        if is_wall { Self::Mold } else { Self::Tool }
    }
}

/// Chooses the slicer settings of a part; `None` if it is not made of filament. Resin printers take layers and exposure
/// from the resin's profile, and their supports are placed by hand.
///
/// Settings stated for the machine come first, then those of the part's own notes, then the findings of the rules, then
/// usual values for parts of its kind.
///
/// # Errors
/// [`InvalidBody`] if the solid of the part is not valid.
///
/// ```
/// use fabkit_checks::{example, print_settings};
/// use fabkit_geometry::{BodyKind, Process};
/// let mut sensor = example::puck();
/// // The dish is a wall of the pour: a mold gets fine layers.
/// sensor.bodies[0].kind = BodyKind::Made(Process::Fdm);
/// let settings = print_settings(&sensor, &sensor.bodies[0])?.ok_or("not of filament")?;
/// assert_eq!(settings.layer_mm.value, 0.12);
/// // 0.8 mm are closed below and above.
/// assert_eq!(settings.solid_layers.value, 7);
/// // The lid is printed from resin.
/// assert_eq!(print_settings(&sensor, &sensor.bodies[1])?, None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn print_settings(sensor: &Sensor, part: &Body) -> Result<Option<PrintSettings>, InvalidBody> {
    if part.process() != Some(Process::Fdm) {
        return Ok(None);
    }
    let role = Role::for_part(sensor, part);
    let (own, note) = (part.machine.as_ref().map(|machine| &machine.slicing), &part.slicing);
    let by = part.machine.as_ref().map_or("", |machine| &machine.name);
    let layer_mm = stated_setting(own.and_then(|own| own.layer_mm), note.layer_mm, by)
        .unwrap_or_else(|| usual_layer(role));
    // The small margin keeps a whole quotient from being rounded up.
    let layers = (SKIN_MM / layer_mm.value - 1e-9).ceil().max(1.0) as u32;
    Ok(Some(PrintSettings {
        line_mm: own.and_then(|own| own.line_mm).or(note.line_mm).unwrap_or(LINE_MM),
        perimeters: stated_setting(own.and_then(|own| own.perimeters), note.perimeters, by)
            .unwrap_or_else(|| usual_perimeters(role)),
        solid_layers: chosen(layers, format!("{SKIN_MM} mm closed below and above")),
        infill_percent: stated_setting(
            own.and_then(|own| own.infill_percent),
            note.infill_percent,
            by,
        )
        .unwrap_or_else(|| usual_infill(role)),
        supports: match stated_setting(own.and_then(|own| own.supports), note.supports, by) {
            Some(said) => said,
            None => found_supports(part)?,
        },
        brim_mm: match stated_setting(own.and_then(|own| own.brim_mm), note.brim_mm, by) {
            Some(said) => said,
            None => found_brim(part)?,
        },
        layer_mm,
    }))
}

/// Creates a setting with its reason.
fn chosen<T>(value: T, why: impl Into<String>) -> ChosenSetting<T> {
    ChosenSetting { value, reason: why.into() }
}

/// Returns the setting of the machine, or else that of the part's notes.
fn stated_setting<T>(own: Option<T>, note: Option<T>, by: &str) -> Option<ChosenSetting<T>> {
    let own = own.map(|value| chosen(value, format!("as the process {by} says")));
    own.or_else(|| note.map(|value| chosen(value, "as the part's notes say")))
}

/// Returns the usual layer height for a purpose.
fn usual_layer(role: Role) -> ChosenSetting<f64> {
    match role {
        Role::Mold => chosen(MOLD_LAYER_MM, "what is cast in it shows its layers"),
        Role::Sensor | Role::Tool => chosen(LAYER_MM, "usual for a nozzle of 0.4 mm"),
    }
}

/// Returns the usual number of perimeters for a purpose.
fn usual_perimeters(role: Role) -> ChosenSetting<u32> {
    match role {
        Role::Mold => chosen(4, "four lines keep what is cast out of the infill"),
        Role::Sensor => chosen(3, "screws bite into three lines, and no light comes through"),
        Role::Tool => chosen(3, "usual for what is handled"),
    }
}

/// Returns the usual infill for a purpose.
fn usual_infill(role: Role) -> ChosenSetting<f64> {
    match role {
        Role::Mold => chosen(20.0, "a mold is pressed together, and must stay flat"),
        Role::Sensor => chosen(20.0, "usual; walls bear what the sensor bears"),
        Role::Tool => chosen(15.0, "it bears nothing"),
    }
}

/// Chooses supports by the rule of overhangs.
fn found_supports(part: &Body) -> Result<ChosenSetting<bool>, InvalidBody> {
    Ok(match overhang::find_overhang(part)? {
        Some(finding) => chosen(true, finding.message),
        None => chosen(false, "nothing hangs over that does not print by itself"),
    })
}

/// Chooses a brim by the rule of standing, or for filaments that warp.
fn found_brim(part: &Body) -> Result<ChosenSetting<f64>, InvalidBody> {
    if let Some(finding) = print_stability::find_instability(part)? {
        return Ok(chosen(BRIM_MM, finding.message));
    }
    Ok(if material_questions::warps(part) {
        chosen(BRIM_MM, format!("{} lifts its corners while it cools", part.material))
    } else {
        chosen(0.0, "it stands by itself")
    })
}

#[cfg(test)]
mod tests {
    use fabkit_geometry::{Machine, SliceAdvice, Solid};

    use super::*;
    use crate::example;

    fn settings(part: &Body) -> PrintSettings {
        print_settings(&example::puck(), part).unwrap().unwrap()
    }

    fn hat() -> Body {
        let brim = Solid::cylinder(15.0, 3.0).at(0.0, 0.0, 11.0);
        let solid = Solid::union([Solid::cylinder(4.0, 12.0), brim]);
        Body::made("hat", "a hat", Process::Fdm, solid).with_material("PLA")
    }

    #[test]
    fn machine_settings_override_notes_and_notes_override_rules() {
        let found = settings(&hat());
        assert!(found.supports.value && found.supports.reason.contains("hang over"), "{found:?}");
        let noted = settings(&hat().with_supports(false).in_layers(0.1).on_brim(3.0));
        assert!(!noted.supports.value);
        assert_eq!((noted.layer_mm.value, noted.solid_layers.value), (0.1, 8));
        assert_eq!(noted.brim_mm.value, 3.0);
        let slicing = SliceAdvice { layer_mm: Some(0.3), ..SliceAdvice::default() };
        let machine = Some(Machine { name: "coarse".into(), slicing, ..Machine::default() });
        let owned = settings(&Body { machine, ..hat().in_layers(0.1) });
        assert_eq!((owned.layer_mm.value, owned.solid_layers.value), (0.3, 3));
        assert_eq!(owned.layer_mm.reason, "as the process coarse says");
        let resin = print_settings(&example::puck(), &hat().made_by(Process::Sla));
        assert_eq!(resin.unwrap(), None);
    }

    #[test]
    fn tall_parts_and_filaments_that_warp_get_a_brim() {
        let post =
            Body::made("post", "", Process::Fdm, Solid::cylinder(2.0, 60.0)).with_material("PLA");
        assert_eq!(settings(&post).brim_mm.value, BRIM_MM);
        let slab = |warps| {
            let mut slab = Body::made("slab", "", Process::Fdm, Solid::cuboid(40.0, 40.0, 4.0));
            slab.substance.warps = warps;
            settings(&slab.with_material("black ABS")).brim_mm.value
        };
        assert_eq!([Some(false), Some(true), None].map(slab), [0.0, BRIM_MM, 0.0]);
    }

    #[test]
    fn molds_are_finer_than_what_holds_them() {
        let puck = example::puck();
        let mut dish = puck.body("dish").unwrap().clone();
        dish.kind = fabkit_geometry::BodyKind::Made(Process::Fdm);
        let mold = print_settings(&puck, &dish).unwrap().unwrap();
        assert_eq!((mold.layer_mm.value, mold.perimeters.value), (MOLD_LAYER_MM, 4));
        assert_eq!(settings(&hat()).layer_mm.value, LAYER_MM);
    }
}
