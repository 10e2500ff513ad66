//! Declarations of rules. Each rule declares itself in its own file and is registered by a line in `lib.rs`.

use crate::rule::Rule;
use crate::rule_input::{RuleInput, RuleResult};

/// Declaration of a rule.
pub(crate) struct Declaration {
    pub(crate) rule: Rule,
    /// Kind of items that it examines, a noun in the plural.
    pub(crate) examines: &'static str,
    /// Texts for the table of rules: what the rule finds, and its limits with their sources.
    pub(crate) description_and_limit: [&'static str; 2],
    /// Whether the rule is applied to each of many variants of a sensor.
    pub(crate) for_variants: bool,
    pub(crate) look: fn(&RuleInput<'_>) -> RuleResult,
}

/// Declares the rule of a file: adds a constant to [`Rule`] and a `RULE` to the file.
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
            description_and_limit: [$finds, $limit],
            for_variants: $for_variants,
            look: $look,
        };
    };
}
pub(crate) use rule;
