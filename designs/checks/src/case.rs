//! What rules look at: a sensor, and what several of them ask of it.

use std::cell::{RefCell, RefMut};

use fabkit_geometry::{Pour, Pull, Sensor};

use crate::finding::Finding;
use crate::memo::Memo;
use crate::scene::{Assemblies, InvalidBody, Placed};

/// What a rule found, and how much it looked at.
pub(crate) type Looked = Result<(Vec<Finding>, usize), InvalidBody>;

/// A sensor as rules look at it.
pub(crate) struct Case<'a> {
    pub(crate) sensor: &'a Sensor,
    pub(crate) scene: &'a Assemblies<'a>,
    pub(crate) memo: &'a Memo,
    /// Bodies that may overlap.
    pub(crate) pairs: Vec<Pair<'a>>,
    pub(crate) pours: Vec<(Place<'a>, &'a Pour)>,
    pub(crate) removals: Vec<Removal<'a>>,
    /// Is called after each pair, pour and pull.
    pub(crate) tick: &'a (dyn Fn() + Sync),
    /// Found once for several rules.
    pub(crate) ways: RefCell<Option<Ways>>,
}

/// What was found of ways and of tools, and how much was looked at.
#[derive(Default)]
pub(crate) struct Ways {
    pub(crate) findings: Vec<Finding>,
    pub(crate) bodies: usize,
    pub(crate) tools: usize,
}

impl<'a> Case<'a> {
    /// The pours whose air rises somewhere. A direction of no length is reported by the chain's rule.
    pub(crate) fn rising(&self) -> impl Iterator<Item = &(Place<'a>, &'a Pour)> {
        self.pours.iter().filter(|(_, pour)| pour.up.norm() > 0.0)
    }

    /// What was found of ways, looked for by whoever asks first.
    pub(crate) fn ways(&self, find: impl FnOnce() -> Ways) -> RefMut<'_, Ways> {
        RefMut::map(self.ways.borrow_mut(), |ways| ways.get_or_insert_with(find))
    }
}

/// Where something happens.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place<'a> {
    pub(crate) step: &'a str,
    pub(crate) assembly: &'a str,
}

/// A tool, and what stands against it when it is pulled.
pub(crate) struct Removal<'a> {
    pub(crate) place: Place<'a>,
    pub(crate) pull: &'a Pull,
    pub(crate) tools: Vec<&'a Placed<'a>>,
    pub(crate) cast: Vec<&'a Placed<'a>>,
}

/// One pair of bodies whose boxes meet.
pub(crate) struct Pair<'a> {
    pub(crate) assembly: &'a str,
    pub(crate) a: &'a Placed<'a>,
    pub(crate) b: &'a Placed<'a>,
    /// Index of the press fit that is declared for it.
    pub(crate) fit: Option<usize>,
}
