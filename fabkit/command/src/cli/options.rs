//! Options shared by the command and the Python package, declared once as `clap` reads them. Help texts, the book's
//! reference, and Python's signatures and docstrings all derive from them (`python.rs`).

/// Looks up option values by name, for callers other than the command line.
pub trait Named<T, E> {
    /// Returns the value of the option `name`, given or default.
    ///
    /// # Errors
    /// The value has another type.
    fn named(&self, name: &'static str) -> Result<T, E>;
}

/// Declares a struct of options that `clap` and [`Named`] values can fill.
macro_rules! options {
    (
        $(#[$about:meta])*
        pub struct $options:ident {
            $($(#[$meta:meta])* pub $name:ident: $kind:ty,)*
        }
    ) => {
        $(#[$about])*
        #[derive(Debug, clap::Args)]
        pub struct $options {
            $($(#[$meta])* pub $name: $kind,)*
        }

        impl $options {
            /// Reads each option by name. Limits are checked by the use case, not here.
            ///
            /// # Errors
            /// A value has another type.
            pub fn from_named<S, E>(given: &S) -> Result<Self, E>
            where
                $(S: $crate::cli::Named<$kind, E>,)*
            {
                Ok(Self { $($name: given.named(stringify!($name))?,)* })
            }
        }
    };
}

pub(super) use options;
