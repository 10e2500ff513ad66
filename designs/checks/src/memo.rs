//! What has been found clean before.
//!
//! Variants of one sensor have much in common, and one sensor has the same layers in several tools.
//! What a rule found nothing about need not be looked at again: a rule's answer depends on the shapes
//! and their places alone. What it found something about is looked at again, so that every finding
//! says what it would say without a memory.

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hasher};
use std::sync::Mutex;

use fabkit_geometry::{Placement, Solid, Vector3};

/// Answers kept at most: some 30 MB.
const MOST_KEPT: usize = 1_000_000;

/// Remembers, over many calls of [`check_variant`](crate::check_variant), what was clean.
///
/// May be shared by threads; answers do not depend on what is in it.
#[derive(Debug, Default)]
pub struct Memo {
    clean: Mutex<HashSet<u128>>,
}

impl Memo {
    /// Whether this was found clean before; otherwise `examine` tells, and is remembered.
    pub(crate) fn is_clean(&self, key: &Key, examine: impl FnOnce() -> bool) -> bool {
        let key = key.finish();
        if self.clean.lock().is_ok_and(|clean| clean.contains(&key)) {
            return true;
        }
        let is_clean = examine();
        if is_clean
            && let Ok(mut clean) = self.clean.lock()
            && clean.len() < MOST_KEPT
        {
            clean.insert(key);
        }
        is_clean
    }
}

/// All that an answer depends on, as 128 bits: two of a billion answers are taken for each other once
/// in 10^20 sweeps.
#[derive(Clone, Debug)]
pub(crate) struct Key([DefaultHasher; 2]);

impl Key {
    /// `rule` tells one rule's answers from another's.
    pub(crate) fn new(rule: u64) -> Self {
        Self([0, 1].map(|half| {
            let mut hasher = DefaultHasher::new();
            hasher.write_u64(half);
            hasher.write_u64(rule);
            hasher
        }))
    }

    pub(crate) fn word(mut self, word: u64) -> Self {
        self.0.iter_mut().for_each(|hasher| hasher.write_u64(word));
        self
    }

    pub(crate) fn number(self, number: f64) -> Self {
        self.word(number.to_bits())
    }

    pub(crate) fn vector(self, vector: &Vector3<f64>) -> Self {
        vector.iter().fold(self, |key, v| key.number(*v))
    }

    /// One that has been finished.
    pub(crate) fn key(self, key: u128) -> Self {
        self.word(key as u64).word((key >> 64) as u64)
    }

    pub(crate) fn finish(&self) -> u128 {
        let [low, high] = &self.0;
        u128::from(low.finish()) | u128::from(high.finish()) << 64
    }
}

/// A shape in its place.
pub(crate) fn of_body(solid: &Solid, placement: &Placement) -> u128 {
    let pose = &placement.assembly_from_body;
    let shape = solid.shape_key();
    let key = shape.into_iter().fold(Key::new(0), Key::word);
    let key = pose.rotation().iter().fold(key, |key, v| key.number(*v));
    key.vector(pose.translation_mm()).finish()
}
