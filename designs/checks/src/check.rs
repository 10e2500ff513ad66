//! Entry points that apply rules to a sensor.

use std::cell::RefCell;
use std::sync::atomic::{AtomicUsize, Ordering};

use fabkit_geometry::Sensor;

use crate::declaration::Declaration;
use crate::finding::{Finding, Severity};
use crate::masses::{Batch, batches};
use crate::material_questions::{MaterialQuestions, UnknownProperty};
use crate::memo::Memo;
use crate::rule::Rule;
use crate::rule_input::RuleInput;
use crate::scene::{Assemblies, InvalidBody};
use crate::{RULES, chain, interference, lens_adjustment, overlapping_steps};

/// Number of items that one rule examined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExaminedCount {
    /// The rule.
    pub rule: Rule,
    /// Number of items.
    pub count: usize,
    /// Kind of items, a noun in the plural.
    pub what: &'static str,
}

/// Findings of all rules, with what was examined.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckReport {
    /// Findings in the order of [`Rule::ALL`]; within a rule, in the order of the sensor's lists and its chain.
    pub findings: Vec<Finding>,
    /// One entry for each rule that was applied, in the order of [`Rule::ALL`]; calibration hardware adds its own.
    pub examined: Vec<ExaminedCount>,
    /// Amounts to mix for each pour and spray.
    pub batches: Vec<Batch>,
    /// Properties that a rule needed and no source states: what the rule says of these bodies, it says without them.
    pub not_known: Vec<UnknownProperty>,
}

impl CheckReport {
    /// Returns the number of errors, which are the findings that keep the sensor from being built.
    pub fn errors(&self) -> usize {
        self.findings.iter().filter(|finding| finding.severity == Severity::Error).count()
    }

    /// Iterates over the findings of one rule.
    pub fn for_rule(&self, rule: Rule) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(move |finding| finding.rule == rule)
    }
}

/// Applies every rule to a sensor.
///
/// # Errors
/// [`InvalidBody`] if the solid of a body is not valid.
///
/// ```
/// use fabkit_checks::{Rule, check, example};
/// use fabkit_geometry::Pose;
/// // The lid 0.5 mm too low cuts into the puck.
/// let mut sensor = example::puck();
/// sensor.bodies[1].placements[0].assembly_from_body = Pose::translation(0.0, 0.0, -0.5);
/// let report = check(&sensor)?;
/// let overlap = report.for_rule(Rule::Interference).next().ok_or("no overlap")?;
/// assert_eq!(overlap.assembly.as_deref(), Some(example::MOLD));
/// assert!(overlap.measured.is_some_and(|volume| volume.value > volume.limit));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn check(sensor: &Sensor) -> Result<CheckReport, InvalidBody> {
    check_with_progress(sensor, &|_, _| {})
}

/// Applies every rule and reports progress: `progress` is called from any thread, with the number of finished pairs of
/// bodies, pours and pulls, and their total number.
///
/// # Errors
/// Same as [`check`].
///
/// ```
/// use fabkit_checks::{check_with_progress, example};
/// use std::sync::atomic::{AtomicUsize, Ordering};
/// let calls = AtomicUsize::new(0);
/// let expected = AtomicUsize::new(0);
/// check_with_progress(&example::puck(), &|_, all| {
///     calls.fetch_add(1, Ordering::Relaxed);
///     expected.store(all, Ordering::Relaxed);
/// })?;
/// assert_eq!(calls.into_inner(), expected.into_inner());
/// # Ok::<(), fabkit_checks::InvalidBody>(())
/// ```
pub fn check_with_progress(
    sensor: &Sensor,
    progress: Progress,
) -> Result<CheckReport, InvalidBody> {
    check_all(sensor, &Rule::ALL, &Memo::default(), progress)
}

/// Applies some of [`Rule::ALL`], for callers that check many sensors that have much in common: what `memo` knows to be
/// clean is not examined again.
///
/// Rules that share their work report together. For example, [`Rule::Motion`] also returns findings about tools that do
/// not reach their screws.
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
/// Same as [`check`].
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
        // Refracted rays report the same cause as straight rays: their errors and warnings are dropped if straight rays
        // found any.
        let is_said =
            report.for_rule(Rule::Sight).any(|finding| finding.severity != Severity::Note);
        let mut seen = crate::visibility::examine(sensor)?;
        seen.retain(|finding| finding.severity == Severity::Note || !is_said);
        // Inserts them behind the last finding of this rule or an earlier one, which keeps the order of reports.
        let rank = |rule| Rule::ALL.iter().position(|known| *known == rule);
        let before = |finding: &Finding| rank(finding.rule) <= rank(Rule::Sight);
        let place = report.findings.iter().rposition(before).map_or(0, |last| last + 1);
        report.findings.splice(place..place, seen);
    }
    Ok(CheckReport { batches: batches(sensor), ..report })
}

/// Callback that receives the number of finished items and the total number of items.
pub type Progress<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// Applies the rules that can keep a sensor from being built, for callers that check many variants of a sensor.
///
/// Masses are not computed (`batches` stays empty), and rules that are not for variants, such as overhangs, are left
/// out.
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
/// [`InvalidBody`] if the solid of a body is not valid.
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
    // Denominator of the progress: one tick for each pair, for each pour in `casting`, for each rising pour in `air`,
    // and for each pull.
    let rising = pours.iter().filter(|(_, pour)| pour.up.norm() > 0.0).count();
    let all = pairs.len() + pours.len() + rising + removals.len();
    let done = AtomicUsize::new(0);
    let tick = &|| progress(done.fetch_add(1, Ordering::Relaxed) + 1, all);
    let case = RuleInput {
        sensor,
        scene,
        memo,
        pairs,
        pours,
        removals,
        tick,
        questions: MaterialQuestions::default(),
        motion_findings: RefCell::default(),
    };
    let (mut findings, mut examined) = (Vec::new(), Vec::new());
    for Declaration { rule, examines, look, .. } in asked {
        let (found, count) = look(&case)?;
        findings.extend(found);
        examined.push(ExaminedCount { rule: *rule, count, what: examines });
    }
    let not_known = case.questions.unanswered();
    Ok(CheckReport { findings, examined, batches: Vec::new(), not_known })
}

/// Applies only the rule of the camera's view, with straight rays.
///
/// # Errors
/// [`InvalidBody`] if the solid of a body is not valid.
pub fn check_camera_view(sensor: &Sensor) -> Result<Vec<Finding>, InvalidBody> {
    let questions = MaterialQuestions::default();
    Ok(crate::camera_view::examine(sensor, &Assemblies::new(sensor)?, &questions).0)
}

/// Applies only the comparison of the drawn bodies with the share of the surface that a published sensor is said to
/// see.
///
/// # Errors
/// [`InvalidBody`] if the solid of a body is not valid.
pub fn check_visibility(sensor: &Sensor) -> Result<Vec<Finding>, InvalidBody> {
    crate::visibility::examine(sensor)
}

/// Applies only the rules for lenses that are focused by hand and for steps that overlap in time.
pub fn check_manual_steps(sensor: &Sensor) -> Vec<Finding> {
    [lens_adjustment::examine(sensor), overlapping_steps::examine(sensor)].concat()
}

/// Applies only the rule of motions: whether every body and every tool can reach its place.
///
/// # Errors
/// [`InvalidBody`] if the solid of a body is not valid.
///
/// ```
/// use fabkit_checks::{check_motions, example};
/// use fabkit_geometry::{Action, Solid, Step};
/// let mut sensor = example::puck();
/// let put = |name: &str| Step {
///     bodies: vec![name.into()],
///     action: Action::Assemble,
///     ..sensor.chain[0].clone()
/// };
/// sensor.chain = vec![put("dish"), put("lid")];
/// assert!(check_motions(&sensor)?.is_empty());
/// // The lid does not get into a hollow ball.
/// sensor.bodies[0].solid = Solid::sphere(40.0).minus(Solid::sphere(30.0));
/// assert_eq!(check_motions(&sensor)?[0].bodies[0], "lid");
/// # Ok::<(), fabkit_checks::InvalidBody>(())
/// ```
pub fn check_motions(sensor: &Sensor) -> Result<Vec<Finding>, InvalidBody> {
    Ok(check_rules(sensor, &[Rule::Motion], &Memo::default())?.findings)
}

/// Finds overlaps between those pairs of bodies for which `is_asked` returns true, given their names. Press fits are
/// ignored: neither do they allow an overlap, nor is a missing one reported.
///
/// # Errors
/// [`InvalidBody`] if the solid of a body is not valid.
///
/// ```
/// use fabkit_checks::{check_interference_between, example};
/// use fabkit_geometry::Pose;
/// let mut sensor = example::puck();
/// sensor.bodies[1].placements[0].assembly_from_body = Pose::translation(0.0, 0.0, -0.5);
/// let overlaps =
///     |a, b| check_interference_between(&sensor, &|x, y| [x, y] == [a, b] || [x, y] == [b, a]);
/// // The lid cuts into dish and puck; puck and dish do not touch it.
/// assert_eq!(overlaps("lid", "dish")?.len(), 1);
/// assert_eq!(overlaps("puck", "dish")?.len(), 0);
/// # Ok::<(), fabkit_checks::InvalidBody>(())
/// ```
pub fn check_interference_between(
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
