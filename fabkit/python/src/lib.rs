//! Python bindings of fabkit, one file for each topic.
//!
//! This module (`fabkit._fabkit`) is private to the package: its classes and functions exchange only what is cheap to
//! pass, numpy arrays and JSON documents. The public names, defaults, docstrings and types are in
//! `fabkit/python/fabkit/`.
//! that people see are in `fabkit/python/fabkit/`.

mod arrays;
mod calibrate;
mod camera;
mod command;
mod dataset;
mod design;
mod errors;
mod export;
mod hints;
mod keywords;
mod live;
mod marks;
mod mesh;
mod press;
mod process_pool;
mod running;
mod scene;
mod sweep;

/// Extension module `fabkit._fabkit`.
#[pyo3::pymodule]
mod _fabkit {
    #[pymodule_export]
    use crate::calibrate::{
        Extrinsics, Intrinsics, board, extrinsics, find_corners, find_pins, intrinsics, plan,
    };
    #[pymodule_export]
    use crate::camera::{Camera, split_camera_path};
    #[pymodule_export]
    use crate::command::command;
    #[pymodule_export]
    use crate::dataset::{BegunDataset, DatasetOrder, DatasetReader, Samples};
    #[pymodule_export]
    use crate::design::{Design, Project, load, sensors};
    #[pymodule_export]
    use crate::errors::{hint, length_mm};
    #[pymodule_export]
    use crate::export::{Exported, write_files, write_folder};
    #[pymodule_export]
    use crate::live::{Live, LiveSkin};
    #[pymodule_export]
    use crate::marks::MarkFollower;
    #[pymodule_export]
    use crate::mesh::Mesh;
    #[pymodule_export]
    use crate::press::press;
    #[pymodule_export]
    use crate::running::fall;
    #[pymodule_export]
    use crate::scene::{Reconstructor, Scene, false_color};
    #[pymodule_export]
    use crate::sweep::{SweepPlan, SweepStore, run_sweep, save_sweep};

    /// Starts the threads of this process.
    #[pymodule_init]
    fn init(_module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        crate::process_pool::start_pool();
        Ok(())
    }

    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "Python's name for it")]
    const __version__: &str = fabkit_application::export::VERSION;
}
