//! Nothing: this crate asks outside crates for the features that the Python package and the tests need of them, so that
//! what the command has built is not built again for either.
