//! Sensors as their files describe them: built, checked, changed.

mod assemblies;
mod bodies;
mod checks;
mod constraints;
mod extends;
mod fixing;
mod flat_gel;
mod freedom;
mod marks;
mod materials;
mod modules;
mod new;
mod own;
mod own_family;
mod random_materials;
mod touch_surface;
mod value_effects;
