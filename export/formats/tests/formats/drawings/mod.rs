//! Drawings: outlines against formulas and distances, files against readers of their own.

mod files;
mod kerf;
mod nesting;
mod readers;
