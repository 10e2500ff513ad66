//! What a rule says of itself. Each does so in its own file, and is registered by a line in `lib.rs`.

use crate::case::{Case, Looked};
use crate::rule::Rule;

/// What a rule says of itself.
pub(crate) struct Declaration {
    pub(crate) rule: Rule,
    /// What it looks at, in the plural.
    pub(crate) examines: &'static str,
    /// What it finds, and its limits with their sources, for the table of rules.
    pub(crate) told: [&'static str; 2],
    /// Whether it is asked about each of many variants.
    pub(crate) for_variants: bool,
    pub(crate) look: fn(&Case<'_>) -> Looked,
}

/// Declares the rule of a file: [`Rule`] gets a constant of its name, and the file a `RULE`.
macro_rules! rule {
    (
        $(#[$summary:meta])+
        $name:ident = $word:literal,
        examines: $examines:literal,
        finds: $finds:literal,
        limit: $limit:literal,
        for_variants: $for_variants:literal,
        look: $look:path,
    ) => {
        impl Rule {
            $(#[$summary])+
            #[allow(non_upper_case_globals, reason = "rules are told apart as kinds are")]
            pub const $name: Self = Self($word);
        }

        pub(crate) const RULE: $crate::declaration::Declaration = $crate::declaration::Declaration {
            rule: Rule::$name,
            examines: $examines,
            told: [$finds, $limit],
            for_variants: $for_variants,
            look: $look,
        };
    };
}
pub(crate) use rule;
