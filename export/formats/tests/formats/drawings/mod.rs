//! Drawings: outlines against formulas and distances, files against independent readers.

mod files;
mod kerf;
mod nesting;
mod readers;
