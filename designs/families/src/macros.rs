//! Macros by which families declare their parameters and their layout.

/// Declares several sections of parameters, with [`parameters!`] for each.
macro_rules! sections {
    ($($(#[doc = $doc:literal])+ pub struct $name:ident { $($fields:tt)+ })+) => {$(
        $crate::parameters! { $(#[doc = $doc])+ pub struct $name { $($fields)+ } }
    )+};
}
pub(crate) use sections;

/// Declares a layout struct: each position or size with its name, documentation and formula, stated once. A `let`
/// declares a local value that is not part of the struct.
macro_rules! layout {
    // Consumes one item per step: the rules behind `@` collect fields, their names and `let` statements in the three
    // brackets.
    ($(#[$doc:meta])+ pub struct $name:ident from $p:ident: &$params:ty { $($rest:tt)+ }) => {
        $crate::layout!(@ $p: $params, [$(#[$doc])+ $name] [] [] [] $($rest)+);
    };
    (@ $p:ident: $params:ty, $head:tt [$($field:tt)*] [$($made:ident)*] [$($lets:tt)*]
        let $local:pat = $value:expr; $($rest:tt)*) => {
        $crate::layout!(
            @ $p: $params, $head [$($field)*] [$($made)*] [$($lets)* let $local = $value;] $($rest)*
        );
    };
    (@ $p:ident: $params:ty, $head:tt [$($field:tt)*] [$($made:ident)*] [$($lets:tt)*]
        $(#[$doc:meta])+ $at:ident = $value:expr; $($rest:tt)*) => {
        $crate::layout!(
            @ $p: $params, $head [$($field)*] [$($made)*] [$($lets)*]
            $(#[$doc])+ $at: f64 = $value; $($rest)*
        );
    };
    (@ $p:ident: $params:ty, $head:tt [$($field:tt)*] [$($made:ident)*] [$($lets:tt)*]
        $(#[$doc:meta])+ $at:ident: $type:ty = $value:expr; $($rest:tt)*) => {
        $crate::layout!(
            @ $p: $params, $head [$($field)* $(#[$doc])+ pub $at: $type,] [$($made)* $at]
            [$($lets)* let $at = $value;] $($rest)*
        );
    };
    (@ $p:ident: $params:ty, [$(#[$doc:meta])+ $name:ident] [$($field:tt)*] [$($made:ident)*]
        [$($lets:tt)*]) => {
        $(#[$doc])+
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name {
            $($field)*
        }

        impl $name {
            /// Derives the layout; meaningful only for parameters that satisfy the family's constraints.
            pub fn new($p: &$params) -> Self {
                $($lets)*
                Self { $($made),* }
            }
        }
    };
}
pub(crate) use layout;
