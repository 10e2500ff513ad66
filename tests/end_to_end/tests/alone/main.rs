//! What commands take of time and memory, and what they do when they are stopped: run alone, one test at a time.

mod budget;
mod failures;
mod memory;
mod refusals;
