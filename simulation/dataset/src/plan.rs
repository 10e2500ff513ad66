//! Plan of a data set, fixed before the first ray is cast.

use fabkit_geometry::csv::CsvTable;
use fabkit_geometry::sequences::SplitMix64;
use serde_json::{Value, json};

use super::store::KIND;
use super::{DatasetJob, HalfImages, PressPattern, size_px};

/// Purpose of a pattern, and of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Training.
    Train,
    /// Validation: choice of a model and of the moment to stop.
    Validation,
    /// Test: reported results.
    Test,
    /// Sample whose two patterns have different purposes: its use would leak shapes between splits.
    Mixed,
}

impl Split {
    /// Name of the split in `samples.csv`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Validation => "validation",
            Self::Test => "test",
            Self::Mixed => "mixed",
        }
    }
}

/// Numbers of patterns for validation and test, of 10; the rest is for training.
const VALIDATION_OF_TEN: usize = 1;
const TEST_OF_TEN: usize = 1;

/// Names, splits and origin of a data set, as its document states them.
///
/// ```
/// use fabkit_dataset::{DatasetPlan, PressPattern, Split};
///
/// let pattern = |i| PressPattern { name: format!("p{i}"), left: vec![], right: vec![], response: None };
/// let patterns: Vec<PressPattern> = (0..20).map(pattern).collect();
/// let plan = DatasetPlan::new(&patterns, 7, serde_json::json!({}));
/// let count = |split| plan.splits.iter().filter(|own| **own == split).count();
/// // Of ten patterns, one is for validation and one for the test.
/// assert_eq!([Split::Train, Split::Validation, Split::Test].map(count), [16, 2, 2]);
/// assert_eq!(plan.samples_csv().lines().nth(1).and_then(|line| line.get(..13)), Some("0,0,20,p0,p0,"));
/// # Ok::<(), ()>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DatasetPlan {
    /// Names of the patterns, in order.
    pub patterns: Vec<String>,
    /// Names of the bodies of each pattern; the first has the label 2.
    pub bodies: Vec<Vec<String>>,
    /// Split of each pattern.
    pub splits: Vec<Split>,
    /// Caller's part of the document: sensor, design hash, camera, frames, units, seed.
    pub origin: Value,
}

impl DatasetPlan {
    /// Assigns patterns to splits by a shuffle that depends on the seed alone.
    ///
    /// With fewer than ten patterns there is one for the test and, from three on, one for
    /// validation.
    pub fn new(patterns: &[PressPattern], seed: u64, origin: Value) -> Self {
        let names =
            |pattern: &PressPattern| pattern.left.iter().map(|body| body.name.clone()).collect();
        let bodies = patterns.iter().map(names).collect();
        let patterns: Vec<String> = patterns.iter().map(|pattern| pattern.name.clone()).collect();
        let count = patterns.len();
        // A tenth, rounded down, but one as soon as there are enough patterns.
        let share = |of_ten: usize, at_least: usize| {
            (count * of_ten / 10).max(usize::from(count >= at_least))
        };
        let (test, validation) = (share(TEST_OF_TEN, 2), share(VALIDATION_OF_TEN, 3));
        let mut splits = vec![Split::Train; count];
        for (rank, pattern) in shuffled_indices(count, seed).into_iter().enumerate() {
            if rank < test {
                splits[pattern] = Split::Test;
            } else if rank < test + validation {
                splits[pattern] = Split::Validation;
            }
        }
        Self { patterns, bodies, splits, origin }
    }

    /// Returns the split of the sample of two patterns.
    ///
    /// ```
    /// use fabkit_dataset::{DatasetPlan, Split};
    /// let plan = DatasetPlan {
    ///     patterns: vec!["a".into(), "b".into()],
    ///     bodies: vec![vec![], vec![]],
    ///     splits: vec![Split::Train, Split::Test],
    ///     origin: serde_json::json!({}),
    /// };
    /// assert_eq!(plan.split_of(1, 1), Split::Test);
    /// // A shape of the test must not be seen in training.
    /// assert_eq!(plan.split_of(0, 1), Split::Mixed);
    /// ```
    pub fn split_of(&self, left: usize, right: usize) -> Split {
        let (left, right) = (self.splits[left], self.splits[right]);
        if left == right { left } else { Split::Mixed }
    }

    /// Writes a table with a line for each sample: its number, the indices of its two halves in `halves/`, its split.
    pub fn samples_csv(&self) -> String {
        let count = self.patterns.len();
        let mut table = CsvTable::new("sample,left_half,right_half,left,right,split");
        for left in 0..count {
            for right in 0..count {
                let (names, split) = (&self.patterns, self.split_of(left, right).word());
                table.row([
                    (left * count + right).into(),
                    left.into(),
                    (count + right).into(),
                    (&names[left]).into(),
                    (&names[right]).into(),
                    split.into(),
                ]);
            }
        }
        table.finish()
    }

    /// Attributes of the Zarr group.
    pub(super) fn attributes(&self) -> Value {
        json!({ "format": "fabkit-dataset", "version": KIND.version, "see": "dataset.json" })
    }

    /// Writes `dataset.json` without its list of files.
    pub(super) fn document(&self, job: &DatasetJob) -> Value {
        let [height_px, width_px] = size_px(job);
        let pattern = |((name, bodies), split): ((&String, &Vec<String>), &Split)| json!({ "name": name, "bodies": bodies, "split": split.word() });
        let patterns = self.patterns.iter().zip(&self.bodies).zip(&self.splits).map(pattern);
        json!({
            "format": "fabkit-dataset",
            "version": KIND.version,
            "materialised": job.materialise,
            "size_px": [height_px, width_px],
            "image_channels": job.captures.map(HalfImages::channels),
            "halves": 2 * self.patterns.len(),
            "samples": self.patterns.len().pow(2),
            "patterns": patterns.collect::<Vec<_>>(),
            "label": "0: no surface or seam, 1: surface, 2 and up: the pattern's bodies in order",
            "splits": "by pattern; a sample whose two patterns are for different things is mixed",
            "sample": "left_half * patterns + (right_half - patterns)",
            "range_mm": "reference range minus indentation; NaN in the reference where no surface \
                         is seen",
            "about": self.origin,
        })
    }
}

/// Returns the numbers below `count` in an order given by the seed.
pub(super) fn shuffled_indices(count: usize, seed: u64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    SplitMix64::new(seed).shuffle(&mut order);
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(count: usize, seed: u64) -> DatasetPlan {
        let named = |i| PressPattern {
            name: format!("p{i}"),
            left: Vec::new(),
            right: Vec::new(),
            response: None,
        };
        DatasetPlan::new(&(0..count).map(named).collect::<Vec<_>>(), seed, Value::Null)
    }

    #[test]
    fn no_pattern_is_in_two_splits_and_mixed_samples_are_named() {
        let plan = plan(20, 7);
        let of = |split| plan.splits.iter().filter(|s| **s == split).count();
        assert_eq!((of(Split::Train), of(Split::Validation), of(Split::Test)), (16, 2, 2));
        let csv = plan.samples_csv();
        assert_eq!(csv.lines().count(), 1 + 400);
        for line in csv.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let half = |i: usize| cells[i].parse::<usize>().unwrap();
            let (left, right) = (half(1), half(2) - 20);
            assert_eq!(half(0), left * 20 + right);
            let same = plan.splits[left] == plan.splits[right];
            assert_eq!(cells[5] != "mixed", same);
        }
    }

    #[test]
    fn the_seed_decides_the_order_of_patterns() {
        assert_eq!(plan(100, 1), plan(100, 1));
        assert_ne!(plan(100, 1).splits, plan(100, 2).splits);
        let mut order = shuffled_indices(50, 3);
        order.sort_unstable();
        assert_eq!(order, (0..50).collect::<Vec<_>>());
        assert_eq!(plan(1, 1).splits, [Split::Train]);
        assert_eq!(plan(2, 1).splits.iter().filter(|s| **s == Split::Test).count(), 1);
    }
}
