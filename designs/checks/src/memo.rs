//! Cache of examinations that found nothing.
//!
//! Variants of one sensor have much in common, and one sensor has the same layers in several tools. The findings of a
//! rule depend only on shapes and their poses, so an examination without findings need not be repeated. An examination
//! with findings is repeated, so that every finding reads as it would without the cache.

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hasher};
use std::sync::Mutex;

use fabkit_geometry::{Placement, Solid, Vector3};

/// Maximum number of cached keys: about 30 MB.
const MAX_KEYS: usize = 1_000_000;

/// Cache of clean examinations over many calls of [`check_variant`](crate::check_variant).
///
/// It can be shared between threads. Results do not depend on its content.
#[derive(Debug, Default)]
pub struct Memo {
    clean: Mutex<HashSet<u128>>,
}

impl Memo {
    /// Returns true if `key` is known to be clean; otherwise runs `examine` and caches a clean result.
    pub(crate) fn is_clean(&self, key: &Key, examine: impl FnOnce() -> bool) -> bool {
        let key = key.finish();
        // A poisoned lock only means that nothing is cached.
        if self.clean.lock().is_ok_and(|clean| clean.contains(&key)) {
            return true;
        }
        let is_clean = examine();
        if is_clean
            && let Ok(mut clean) = self.clean.lock()
            && clean.len() < MAX_KEYS
        {
            clean.insert(key);
        }
        is_clean
    }
}

/// Hash of everything that an examination depends on, 128 bits: among a billion examinations, two collide once in 10^20
/// sweeps.
#[derive(Clone, Debug)]
pub(crate) struct Key([DefaultHasher; 2]);

impl Key {
    /// Creates a key; `rule` keeps the keys of different rules apart.
    pub(crate) fn new(rule: u64) -> Self {
        // Two hashers with different seeds give 128 bits.
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
        // Bits, not values: 0.0 and -0.0 are different keys, which costs at most a repeated examination.
        self.word(number.to_bits())
    }

    pub(crate) fn vector(self, vector: &Vector3<f64>) -> Self {
        vector.iter().fold(self, |key, v| key.number(*v))
    }

    /// Appends a finished key.
    pub(crate) fn key(self, key: u128) -> Self {
        self.word(key as u64).word((key >> 64) as u64)
    }

    pub(crate) fn finish(&self) -> u128 {
        let [low, high] = &self.0;
        u128::from(low.finish()) | u128::from(high.finish()) << 64
    }
}

/// Returns the key of a solid at a placement.
pub(crate) fn body_key(solid: &Solid, placement: &Placement) -> u128 {
    let pose = &placement.assembly_from_body;
    let shape = solid.shape_key();
    let key = shape.into_iter().fold(Key::new(0), Key::word);
    let key = pose.rotation().iter().fold(key, |key, v| key.number(*v));
    key.vector(pose.translation_mm()).finish()
}
