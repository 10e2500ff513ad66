//! Rules that a sensor must keep to be built: nothing overlaps, molds are the negatives of what they
//! cast, air leaves them, tools come off, and the chain that says so is complete.
//!
//! # Conventions
//!
//! - Nothing here knows a sensor by name or a triangle: the rules ask the exact geometry along
//!   lines. Where a rule samples, its resolution is in [`RESOLUTION`] and in its own file.
//! - Places are in the frame of the assembly in which something was found, mm.
//! - Same sensor, same findings, in the same order, on any number of threads.
//!
//! ```
//! use fabkit_checks::{Rule, check, example};
//!
//! let mut sensor = example::puck();
//! assert_eq!(check(&sensor)?.errors(), 0);
//!
//! // The same dish 0.1 mm lower is no longer the puck's negative.
//! sensor.bodies[0].placements[0].assembly_from_body =
//!     fabkit_geometry::Pose::translation(0.0, 0.0, -0.1);
//! let report = check(&sensor)?;
//! assert!(report.findings.iter().any(|f| f.rule == Rule::Casting && f.bodies == ["puck", "dish"]));
//! # Ok::<(), fabkit_checks::InvalidBody>(())
//! ```

mod adjusting;
mod air;
mod casting;
mod chain;
mod chemistry;
mod circuit;
mod contacts;
mod demolding;
pub mod example;
mod finding;
mod flow;
mod glare;
mod held;
mod interference;
mod labels;
mod leak;
mod lines;
mod masses;
mod memo;
mod motion;
mod opening;
mod outlet;
mod overhang;
mod parting;
mod printability;
mod scene;
mod seen;
mod sight;
mod slicing;
mod softness;
mod standing;
mod tearing;
mod waiting;

use std::mem;
use std::sync::atomic::{AtomicUsize, Ordering};

use fabkit_geometry::{Loose, Sensor};
use rayon::prelude::*;

pub use chemistry::{Harm, Hazard, hazards};
pub use finding::{Finding, Measured, Rule, Severity};
pub use masses::{Batch, batches};
pub use memo::Memo;
pub use motion::{Came, Stage, Stand, stages};
pub use printability::{
    PrintLimits, machine_limits, part_limits, print_limits, printability, thinnest_wall,
};
pub use scene::InvalidBody;
pub use slicing::{Chosen, PrintSettings, print_settings};

use motion::Ways;
use scene::Assemblies;

/// How finely the rules look, for people.
pub const RESOLUTION: &str = "overlap: 20 000 lines per pair; casting: 3 x 8192 lines per layer, \
                              faces within 1e-6 mm are together; air and tools: 320 columns \
                              across, pockets shallower than a column are not seen; \
                              sight: twice 8192 rays from the pupil, not bent, \
                              and 256 places through the drawn bodies; motions: 160 lines \
                              across, turns by steps of at most 0.25 mm";

/// How much one rule looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Examined {
    /// Which rule.
    pub rule: Rule,
    /// How many.
    pub count: usize,
    /// Of what, in the plural.
    pub what: &'static str,
}

/// Everything that the rules found.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckReport {
    /// In the order of [`Rule::ALL`], then of the sensor's lists and its chain.
    pub findings: Vec<Finding>,
    /// One entry for each of [`Rule::ALL`]; hardware adds its own.
    pub examined: Vec<Examined>,
    /// What to mix.
    pub batches: Vec<Batch>,
}

impl CheckReport {
    /// How many findings keep the sensor from being built.
    pub fn errors(&self) -> usize {
        self.findings.iter().filter(|finding| finding.severity == Severity::Error).count()
    }

    /// The findings of one rule.
    pub fn of(&self, rule: Rule) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(move |finding| finding.rule == rule)
    }
}

/// Applies every rule.
///
/// # Errors
/// [`InvalidBody`] if a solid of the sensor is none.
pub fn check(sensor: &Sensor) -> Result<CheckReport, InvalidBody> {
    check_watched(sensor, &|_, _| {})
}

/// The same; `progress` is told from any thread how much of how much is looked at, in pairs of bodies,
/// pours and pulls.
///
/// # Errors
/// As [`check`].
pub fn check_watched(sensor: &Sensor, progress: Progress) -> Result<CheckReport, InvalidBody> {
    check_all(sensor, &Rule::ALL, &Memo::default(), progress)
}

/// The same as [`check`] by some of [`Rule::ALL`], for those who look at many sensors that have much in common: what
/// `memo` knows to be clean is not looked at again. What is found along the way comes along, though it be of another
/// rule: tools that do not reach their screws are found with [`Rule::Motion`].
///
/// ```
/// use fabkit_checks::{Memo, Rule, check, check_rules, example};
/// let memo = Memo::default();
/// let report = check_rules(&example::puck(), &[Rule::Casting], &memo)?;
/// assert_eq!(report.examined.len(), 1);
/// let all = check_rules(&example::puck(), &Rule::ALL, &memo)?;
/// assert_eq!(all, check(&example::puck())?);
/// # Ok::<(), fabkit_checks::InvalidBody>(())
/// ```
///
/// # Errors
/// As [`check`].
pub fn check_rules(
    sensor: &Sensor,
    rules: &[Rule],
    memo: &Memo,
) -> Result<CheckReport, InvalidBody> {
    check_all(sensor, rules, memo, &|_, _| {})
}

fn check_all(
    sensor: &Sensor,
    rules: &[Rule],
    memo: &Memo,
    progress: Progress,
) -> Result<CheckReport, InvalidBody> {
    let mut report = apply(sensor, rules, memo, progress)?;
    if rules.contains(&Rule::Sight) {
        // One cause, one finding: what straight rays say already is not said again.
        let is_said = report.of(Rule::Sight).any(|finding| finding.severity != Severity::Note);
        let mut seen = seen::examine(sensor)?;
        seen.retain(|finding| finding.severity == Severity::Note || !is_said);
        // Where the rule's other findings are.
        let rank = |rule| Rule::ALL.iter().position(|known| *known == rule);
        let before = |finding: &Finding| rank(finding.rule) <= rank(Rule::Sight);
        let place = report.findings.iter().rposition(before).map_or(0, |last| last + 1);
        report.findings.splice(place..place, seen);
    }
    let printed: [(Rule, Look); 2] =
        [(Rule::Standing, standing::examine), (Rule::Overhang, overhang::examine)];
    for (rule, look) in printed.into_iter().filter(|(rule, _)| rules.contains(rule)) {
        let (found, count) = look(sensor)?;
        report.findings.extend(found);
        report.examined.push(Examined { rule, count, what: "printed parts" });
    }
    Ok(CheckReport { batches: batches(sensor), ..report })
}

/// Is told how much is done, and how much there is to do.
pub type Progress<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// The same for many sensors that have much in common; nothing is weighed, `batches` stays empty, and
/// overhangs, which keep no sensor from being built, are not looked for.
///
/// ```
/// use fabkit_checks::{Memo, check, check_variant, example};
/// let memo = Memo::default();
/// for _ in 0..2 {
///     let report = check_variant(&example::puck(), &memo)?;
///     assert_eq!(report.findings, check(&example::puck())?.findings);
/// }
/// # Ok::<(), fabkit_checks::InvalidBody>(())
/// ```
///
/// # Errors
/// [`InvalidBody`] if a solid of the sensor is none.
pub fn check_variant(sensor: &Sensor, memo: &Memo) -> Result<CheckReport, InvalidBody> {
    apply(sensor, &Rule::ALL, memo, &|_, _| {})
}

fn apply(
    sensor: &Sensor,
    rules: &[Rule],
    memo: &Memo,
    progress: Progress,
) -> Result<CheckReport, InvalidBody> {
    let wants = |rule: Rule| rules.contains(&rule);
    let scene = Assemblies::new(sensor)?;
    let mut findings = Vec::new();
    let pairs =
        if wants(Rule::Interference) { interference::pairs(sensor, &scene) } else { Vec::new() };
    let pours: Vec<_> = chain::pours(sensor).collect();
    // A direction of no length has been reported by the chain's rule.
    let rising: Vec<_> = pours.iter().filter(|(_, pour)| pour.up.norm() > 0.0).collect();
    let removals = chain::removals(sensor, &scene);
    let all = pairs.len() + pours.len() + rising.len() + removals.len();
    let done = AtomicUsize::new(0);
    let tick = || progress(done.fetch_add(1, Ordering::Relaxed) + 1, all);

    let mut examined = Vec::new();
    let mut examine = |rule, what, look: &mut dyn FnMut() -> Looked| {
        if wants(rule) {
            let (found, count) = look()?;
            findings.extend(found);
            examined.push(Examined { rule, count, what });
        }
        Ok::<_, InvalidBody>(())
    };
    examine(Rule::Chain, "steps", &mut || {
        let found = [chain::examine(sensor, &scene), waiting::examine(sensor)];
        Ok((found.concat(), sensor.chain.len()))
    })?;
    examine(Rule::Interference, "pairs of bodies", &mut || {
        Ok((interference::examine(sensor, &pairs, memo, &tick), pairs.len()))
    })?;
    examine(Rule::Casting, "pours", &mut || {
        let found = pours.iter().flat_map(|(place, pour)| {
            let found = casting::examine(place, pour, &scene, memo);
            tick();
            found
        });
        Ok((found.collect(), pours.len()))
    })?;
    examine(Rule::TrappedAir, "pours", &mut || {
        let found = rising.iter().flat_map(|(place, pour)| {
            let mut found = air::examine(place, pour, &scene, memo);
            found.extend(outlet::examine(place, pour, &scene, memo));
            tick();
            found
        });
        Ok((found.collect(), rising.len()))
    })?;
    examine(Rule::Demolding, "pulls", &mut || {
        let pulled = removals.par_iter().map(|removal| {
            let has_direction = removal.pull.direction.norm() > 0.0;
            let found = has_direction.then(|| demolding::examine(removal, memo));
            tick();
            found.unwrap_or_default()
        });
        Ok((pulled.collect::<Vec<_>>().concat(), removals.len()))
    })?;
    examine(Rule::Parting, "steps that shape what is touched", &mut || {
        Ok(parting::examine(sensor, &scene))
    })?;
    examine(Rule::Flow, "pours", &mut || {
        let flows = pours.par_iter();
        let flows = flows.filter_map(|(at, pour)| flow::examine(sensor, at, pour, &scene));
        Ok((flows.collect(), pours.len()))
    })?;
    examine(Rule::Sight, "bodies that are to be seen", &mut || {
        let (mut unseen, to_be_seen) = sight::examine(sensor, &scene);
        unseen.extend(softness::contrasts(sensor));
        Ok((unseen, to_be_seen))
    })?;
    examine(Rule::Leak, "lines to where daylight might be", &mut || {
        Ok(leak::examine(sensor, &scene))
    })?;
    examine(Rule::Glare, "lamps", &mut || glare::examine(sensor, &scene))?;
    // Tools are looked at with the ways of what they fix.
    let moves = wants(Rule::Motion) || wants(Rule::Access);
    let mut ways = if moves { motion::examine(sensor, &scene, memo) } else { Ways::default() };
    examine(Rule::Motion, "bodies that get to a place", &mut || {
        Ok((mem::take(&mut ways.findings), ways.bodies))
    })?;
    examine(Rule::Access, "places for hands and tools", &mut || {
        Ok(([mem::take(&mut ways.findings), adjusting::examine(sensor)].concat(), ways.tools))
    })?;
    examine(Rule::Bonding, "layers", &mut || {
        let loose = sensor.loose.iter().map(|loose| unbonded(sensor, loose));
        let loose = loose.chain(tearing::examine(sensor)).collect();
        Ok((loose, sensor.layers().count()))
    })?;
    examine(Rule::Chemistry, "faces of liquids", &mut || Ok(chemistry::examine(sensor)))?;
    examine(Rule::Softness, "bodies of known hardness", &mut || {
        Ok(softness::examine(sensor, &scene))
    })?;
    examine(Rule::Held, "pairs of bodies that meet", &mut || Ok(held::examine(sensor, &scene)))?;
    examine(Rule::Circuit, "circuits", &mut || circuit::examine(sensor))?;
    examine(Rule::Labels, "printed parts", &mut || Ok(labels::examine(sensor, &scene)))?;
    examine(Rule::Printability, "parts on own machines", &mut || {
        printability::on_machines(sensor)
    })?;
    Ok(CheckReport { findings, examined, batches: Vec::new() })
}

/// A rule that asks about a kit of parts alone.
type Look = fn(&Sensor) -> Looked;

/// What a rule found, and how much it looked at.
type Looked = Result<(Vec<Finding>, usize), InvalidBody>;

/// What the camera sees alone, without the rest of [`check`].
///
/// # Errors
/// [`InvalidBody`] if a solid of the sensor is none.
pub fn sight(sensor: &Sensor) -> Result<Vec<Finding>, InvalidBody> {
    Ok(sight::examine(sensor, &Assemblies::new(sensor)?).0)
}

/// How much the camera sees through the drawn bodies of what is sold as seen, without the rest of [`check`].
///
/// # Errors
/// [`InvalidBody`] if a solid of the sensor is none.
pub fn seen(sensor: &Sensor) -> Result<Vec<Finding>, InvalidBody> {
    seen::examine(sensor)
}

/// What the chain says of lenses that are focused and of steps that overlap in time, without the rest of
/// [`check`].
pub fn handwork(sensor: &Sensor) -> Vec<Finding> {
    [adjusting::examine(sensor), waiting::examine(sensor)].concat()
}

/// Whether everything gets to its place, and its tools with it, without the rest of [`check`].
///
/// # Errors
/// [`InvalidBody`] if a solid of the sensor is none.
pub fn motions(sensor: &Sensor) -> Result<Vec<Finding>, InvalidBody> {
    Ok(check_rules(sensor, &[Rule::Motion], &Memo::default())?.findings)
}

/// A layer that is cast onto something that it does not stick to: its shape may hold it all the same.
fn unbonded(sensor: &Sensor, loose: &Loose) -> Finding {
    let from = |name: &str| {
        let body = sensor.body(name);
        let from =
            body.map(|body| if body.material.is_empty() { &body.summary } else { &body.material });
        from.map_or("", String::as_str)
    };
    let (layer, on) = (from(&loose.layer), from(&loose.on));
    let message = format!(
        "{} of {layer} is cast onto {} of {on}, to which it does not stick",
        loose.layer, loose.on
    );
    let fix = format!(
        "hold it by its shape or by a glue, take another material, or name a primer in `bonds` of {layer}"
    );
    Finding::error(Rule::Bonding, message, fix)
        .with_severity(Severity::Warning)
        .in_step(&loose.step)
        .of([loose.layer.as_str(), loose.on.as_str()])
}

/// The overlaps of those pairs of bodies, by name, that are asked for; fits that none of them has are no finding.
///
/// # Errors
/// [`InvalidBody`] if a solid of the sensor is none.
pub fn interference_of(
    sensor: &Sensor,
    is_asked: &dyn Fn(&str, &str) -> bool,
) -> Result<Vec<Finding>, InvalidBody> {
    let scene = Assemblies::new(sensor)?;
    let mut pairs = interference::pairs(sensor, &scene);
    pairs.retain(|pair| is_asked(pair.a.name, pair.b.name));
    let loose = Sensor { press_fits: Vec::new(), ..sensor.clone() };
    pairs.iter_mut().for_each(|pair| pair.fit = None);
    Ok(interference::examine(&loose, &pairs, &Memo::default(), &|| {}))
}
