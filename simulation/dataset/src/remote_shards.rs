//! Halves that are cast on other machines. Each shard depends on the job alone, so that any machine can compute it, and
//! again if it gets lost. Files that arrive are checked before they are kept.

use super::store::DatasetError;
use super::{DatasetJob, DatasetWriter, halves, shard_file, size_px};

/// Files by their paths relative to a data set's folder.
pub type ShardFiles = Vec<(String, Vec<u8>)>;

/// Computes a shard of halves. Also returns the hash of the plan that it belongs to.
///
/// # Errors
/// Fails if a file cannot be made.
pub fn compute_shard(job: &DatasetJob, number: u64) -> Result<(String, ShardFiles), DatasetError> {
    let halves = halves::arrays(job, size_px(job));
    let plan = hash(&job.plan.document(job));
    Ok((plan, halves::shard_files(job, &halves, number)?))
}

impl DatasetWriter {
    /// Computes the hash of the plan, which [`compute_shard`] returns too.
    pub fn plan_hash(&self) -> String {
        hash(&self.plan)
    }

    /// Lists the shards of halves that are missing.
    pub fn missing_shards(&self) -> Vec<u64> {
        let is_missing = |shard: &u64| {
            let names = halves::shard_names(&self.halves, *shard);
            !names.iter().all(|name| self.folder.is_finished(name))
        };
        let all = self.halves.first().map_or(0, |array| array.shards());
        (0..all).filter(is_missing).collect()
    }

    /// Keeps the files of a [`compute_shard`] that another machine computed, each completely or not at all.
    ///
    /// # Errors
    /// Returns [`DatasetError::ForeignFile`] for a name that is not in the plan, or content that is no shard; then no file
    /// is kept. Fails if a file cannot be written.
    pub fn keep_shard(&self, files: &ShardFiles) -> Result<(), DatasetError> {
        for (name, bytes) in files {
            let stranger = |what| DatasetError::ForeignFile { name: name.clone(), what };
            let Some((array, shard)) = halves::find_shard(&self.halves, name) else {
                return Err(stranger("which is no file of halves of this data set".into()));
            };
            shard_file::check(array, shard, bytes)
                .map_err(|what| stranger(format!("which is not what it should be: {what}")))?;
        }
        // Only after all files have passed: a shard is kept completely or not at all.
        files.iter().try_for_each(|(name, bytes)| Ok(self.folder.put(name, bytes)?))
    }
}

fn hash(plan: &serde_json::Value) -> String {
    blake3::hash(plan.to_string().as_bytes()).to_hex()[..16].to_owned()
}
