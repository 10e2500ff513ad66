//! Empty crate. It requests the features of external crates that the Python package and the tests need, so that the
//! command's build artefacts are reused for both.
