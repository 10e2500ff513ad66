//! Fuzzing of everything that fabkit reads.
//!
//! [`targets`] are functions that take bytes and must return, whatever the bytes are. libFuzzer drives them through
//! `tests/fuzz/fuzz_targets/` on a nightly compiler. On a stable one, [`running`] does, with inputs from [`mutation`]
//! of the files in `tests/fuzz/corpus/`. [`end_to_end`] feeds the same inputs to the command itself.

pub mod end_to_end;
pub mod mutation;
pub mod running;
pub mod targets;
