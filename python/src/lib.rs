//! fabkit for Python: thin bindings, one file a topic.
//!
//! What is here is private to the package (`fabkit._fabkit`): its classes and functions take and give
//! what is cheap to hand over, numpy arrays and JSON documents. Names, defaults, docstrings and types
//! that people see are in `python/fabkit/`.

mod command;
mod design;
mod errors;
mod mesh;
mod running;

/// `fabkit._fabkit`.
#[pyo3::pymodule]
mod _fabkit {
    #[pymodule_export]
    use crate::command::command;
    #[pymodule_export]
    use crate::design::{Design, Project, load, sensors};
    #[pymodule_export]
    use crate::mesh::Mesh;

    #[pymodule_export]
    const VERSION: &str = fabkit::export::VERSION;
}
