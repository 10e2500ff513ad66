//! Options that the command and the Python package both have. They are declared once, as `clap` reads them: that is
//! where help, the book's reference, and signatures and docstrings of Python come from (`python.rs`).

/// Values by the names of options: what a door other than the command line was given.
pub trait Named<T, E> {
    /// The value of the option, which has been given or has a default.
    ///
    /// # Errors
    /// A value of another type.
    fn named(&self, name: &'static str) -> Result<T, E>;
}

/// Declares a struct of options, which `clap` and [`Named`] values can fill.
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
            /// Takes each option from values by name, whose limits the work itself knows.
            ///
            /// # Errors
            /// A value of another type.
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
