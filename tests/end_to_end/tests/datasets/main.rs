//! Folders of many captures and variants, filled by runs that may be stopped.

mod dataset;
mod resumed;
mod sweep;
