//! Rules applied to a sensor.

use std::cell::RefCell;
use std::sync::atomic::{AtomicUsize, Ordering};

use fabkit_geometry::Sensor;

use crate::case::Case;
use crate::declaration::Declaration;
use crate::finding::{Finding, Severity};
use crate::masses::{Batch, batches};
use crate::memo::Memo;
use crate::rule::Rule;
use crate::scene::{Assemblies, InvalidBody};
use crate::{RULES, adjusting, chain, interference, waiting};

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
    let mut report = apply(sensor, &|declared| rules.contains(&declared.rule), memo, progress)?;
    if rules.contains(&Rule::Sight) {
        // One cause, one finding: what straight rays say already is not said again.
        let is_said = report.of(Rule::Sight).any(|finding| finding.severity != Severity::Note);
        let mut seen = crate::seen::examine(sensor)?;
        seen.retain(|finding| finding.severity == Severity::Note || !is_said);
        // Where the rule's other findings are.
        let rank = |rule| Rule::ALL.iter().position(|known| *known == rule);
        let before = |finding: &Finding| rank(finding.rule) <= rank(Rule::Sight);
        let place = report.findings.iter().rposition(before).map_or(0, |last| last + 1);
        report.findings.splice(place..place, seen);
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
    apply(sensor, &|declared| declared.for_variants, memo, &|_, _| {})
}

fn apply(
    sensor: &Sensor,
    wants: &dyn Fn(&Declaration) -> bool,
    memo: &Memo,
    progress: Progress,
) -> Result<CheckReport, InvalidBody> {
    let scene = &Assemblies::new(sensor)?;
    let asked: Vec<_> = RULES.iter().filter(|declared| wants(declared)).collect();
    let overlaps = asked.iter().any(|declared| declared.rule == Rule::Interference);
    let pairs = if overlaps { interference::pairs(sensor, scene) } else { Vec::new() };
    let pours: Vec<_> = chain::pours(sensor).collect();
    let removals = chain::removals(sensor, scene);
    let rising = pours.iter().filter(|(_, pour)| pour.up.norm() > 0.0).count();
    let all = pairs.len() + pours.len() + rising + removals.len();
    let done = AtomicUsize::new(0);
    let tick = &|| progress(done.fetch_add(1, Ordering::Relaxed) + 1, all);
    let case = Case { sensor, scene, memo, pairs, pours, removals, tick, ways: RefCell::default() };
    let (mut findings, mut examined) = (Vec::new(), Vec::new());
    for Declaration { rule, examines, look, .. } in asked {
        let (found, count) = look(&case)?;
        findings.extend(found);
        examined.push(Examined { rule: *rule, count, what: examines });
    }
    Ok(CheckReport { findings, examined, batches: Vec::new() })
}

/// What the camera sees alone, without the rest of [`check`].
///
/// # Errors
/// [`InvalidBody`] if a solid of the sensor is none.
pub fn sight(sensor: &Sensor) -> Result<Vec<Finding>, InvalidBody> {
    Ok(crate::sight::examine(sensor, &Assemblies::new(sensor)?).0)
}

/// How much the camera sees through the drawn bodies of what is sold as seen, without the rest of [`check`].
///
/// # Errors
/// [`InvalidBody`] if a solid of the sensor is none.
pub fn seen(sensor: &Sensor) -> Result<Vec<Finding>, InvalidBody> {
    crate::seen::examine(sensor)
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
