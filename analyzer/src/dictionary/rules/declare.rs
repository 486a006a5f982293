//! The macro that declares rules.

/// Declares the rules of a family and their list, with the extension of their example files:
///
/// ```text
/// rules! {
///     "eds";
///
///     /// the title: what is wrong
///     ///
///     /// What the rule asks, and why.
///     ///
///     /// # What to do
///     ///
///     /// How to fix it.
///     COUNT: Warning Count, "eds/list/count", "CiA 306" "4.5" Known;
/// }
/// ```
///
/// The examples of this rule are `fails.eds` and `passes.eds` in `tests/rules/eds/list/count`.
macro_rules! rules {
    ($ending:literal; $($(#[doc = $doc:literal])+ $name:ident: $severity:ident $kind:ident, $id:literal,
        $standard:literal $($section:literal)? $confidence:ident;)+) => {
        $($(#[doc = $doc])+
        pub static $name: $crate::dictionary::rules::Rule = $crate::dictionary::rules::Rule {
            id: $id,
            severity: $crate::dictionary::rules::Severity::$severity,
            kind: $crate::dictionary::rules::ProblemKind::$kind,
            clause: $crate::clause::Clause {
                standard: $standard,
                section: $crate::dictionary::rules::declare::section!($($section)?),
                confidence: $crate::clause::Confidence::$confidence,
            },
            fails: $crate::dictionary::rules::declare::example!($id, "fails.", $ending),
            passes: $crate::dictionary::rules::declare::example!($id, "passes.", $ending),
            doc: concat!($($doc, "\n"),+),
        };)+

        pub(super) static RULES: &[&$crate::dictionary::rules::Rule] = &[$(&$name),+];
    };
}

macro_rules! section {
    () => {
        None
    };
    ($section:literal) => {
        Some($section)
    };
}

macro_rules! example {
    ($id:literal, $name:literal, $ending:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/rules/", $id, "/", $name, $ending)).trim_ascii_end()
    };
}

pub(super) use {example, rules, section};
