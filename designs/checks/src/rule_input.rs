//! Input of the rules: a sensor, and intermediate results that several rules share.

use std::cell::{RefCell, RefMut};

use fabkit_geometry::{Pour, Pull, Sensor};

use crate::finding::Finding;
use crate::material_questions::MaterialQuestions;
use crate::memo::Memo;
use crate::scene::{Assemblies, InvalidBody, Placed};

/// Findings of a rule, and the number of items that it examined.
pub(crate) type RuleResult = Result<(Vec<Finding>, usize), InvalidBody>;

/// A sensor with the intermediate results that rules share.
pub(crate) struct RuleInput<'a> {
    pub(crate) sensor: &'a Sensor,
    pub(crate) scene: &'a Assemblies<'a>,
    pub(crate) memo: &'a Memo,
    /// Pairs of bodies that may overlap.
    pub(crate) pairs: Vec<Pair<'a>>,
    pub(crate) pours: Vec<(Place<'a>, &'a Pour)>,
    pub(crate) removals: Vec<Removal<'a>>,
    /// Progress callback, called after each pair, pour and pull.
    pub(crate) tick: &'a (dyn Fn() + Sync),
    /// Questions for properties of materials, of which the report lists those that nobody answered.
    pub(crate) questions: MaterialQuestions,
    /// Cached result of the motion search, which two rules report.
    pub(crate) motion_findings: RefCell<Option<MotionFindings>>,
}

/// Findings about the motions of bodies and about tools, and the number of each examined.
#[derive(Default)]
pub(crate) struct MotionFindings {
    pub(crate) findings: Vec<Finding>,
    pub(crate) bodies: usize,
    pub(crate) tools: usize,
}

impl<'a> RuleInput<'a> {
    /// Iterates over the pours whose up direction has a length. A direction of length zero is reported by the rule of
    /// the chain.
    pub(crate) fn rising_pours(&self) -> impl Iterator<Item = &(Place<'a>, &'a Pour)> {
        self.pours.iter().filter(|(_, pour)| pour.up.norm() > 0.0)
    }

    /// Returns the findings about motions, computed by `find` on the first call.
    pub(crate) fn motion_findings(
        &self,
        find: impl FnOnce() -> MotionFindings,
    ) -> RefMut<'_, MotionFindings> {
        RefMut::map(self.motion_findings.borrow_mut(), |ways| ways.get_or_insert_with(find))
    }
}

/// Step and assembly to which a finding belongs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place<'a> {
    pub(crate) step: &'a str,
    pub(crate) assembly: &'a str,
}

/// A tool that is pulled, and the bodies that are in contact with it at that time.
pub(crate) struct Removal<'a> {
    pub(crate) place: Place<'a>,
    pub(crate) pull: &'a Pull,
    pub(crate) tools: Vec<&'a Placed<'a>>,
    pub(crate) cast: Vec<&'a Placed<'a>>,
}

/// A pair of bodies whose bounding boxes overlap.
pub(crate) struct Pair<'a> {
    pub(crate) assembly: &'a str,
    pub(crate) a: &'a Placed<'a>,
    pub(crate) b: &'a Placed<'a>,
    /// Index of the press fit that is declared for the pair.
    pub(crate) fit: Option<usize>,
}
