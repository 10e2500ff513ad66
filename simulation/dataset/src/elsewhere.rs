//! Halves that are cast elsewhere: each shard depends on the job alone, so that it can be computed
//! on any machine, and as often as it gets lost. What is sent is looked at before it is kept.

use super::store::DatasetError;
use super::{Begun, Job, halves, shard_file, size_px};

/// Files by their paths below a data set's folder.
pub type Files = Vec<(String, Vec<u8>)>;

/// A shard of halves, with the hash of the plan that it belongs to.
///
/// # Errors
/// Files that cannot be made.
pub fn shard(job: &Job, number: u64) -> Result<(String, Files), DatasetError> {
    let halves = halves::arrays(job, size_px(job));
    let plan = hash(&job.plan.document(job));
    Ok((plan, halves::shard_files(job, &halves, number)?))
}

impl Begun {
    /// The hash of the plan, which [`shard`] tells too.
    pub fn plan_hash(&self) -> String {
        hash(&self.plan)
    }

    /// Which shards of halves are missing.
    pub fn missing(&self) -> Vec<u64> {
        let is_missing = |shard: &u64| {
            let names = halves::shard_names(&self.halves, *shard);
            !names.iter().all(|name| self.folder.has(name))
        };
        let all = self.halves.first().map_or(0, |array| array.shards());
        (0..all).filter(is_missing).collect()
    }

    /// Keeps the files of a [`shard`] that somebody else computed, each whole or not at all.
    ///
    /// # Errors
    /// [`DatasetError::Stranger`]: a name that is none of the plan's, content that is no shard;
    /// then nothing of it is kept. Files that cannot be written.
    pub fn keep(&self, files: &Files) -> Result<(), DatasetError> {
        for (name, bytes) in files {
            let stranger = |what| DatasetError::Stranger { name: name.clone(), what };
            let Some((array, shard)) = halves::shard_of(&self.halves, name) else {
                return Err(stranger("which is no file of halves of this data set".into()));
            };
            shard_file::check(array, shard, bytes)
                .map_err(|what| stranger(format!("which is not what it should be: {what}")))?;
        }
        files.iter().try_for_each(|(name, bytes)| Ok(self.folder.put(name, bytes)?))
    }
}

fn hash(plan: &serde_json::Value) -> String {
    blake3::hash(plan.to_string().as_bytes()).to_hex()[..16].to_owned()
}
