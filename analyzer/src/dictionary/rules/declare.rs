//! How a rule is declared.

/// Declares the rules of a family, and their list:
///
/// ```text
/// rules! {
///     /// the title: what is wrong
///     ///
///     /// What the rule asks, and why.
///     ///
///     /// # What to do
///     ///
///     /// How to fix it.
///     COUNT: Warning Count, "eds/list/count", "CiA 306" "4.5" Known,
///         fails "[MandatoryObjects]\nSupportedObjects=9\n...",
///         passes "[MandatoryObjects]\nSupportedObjects=3\n...";
/// }
/// ```
macro_rules! rules {
    ($($(#[doc = $doc:literal])+ $name:ident: $severity:ident $kind:ident, $id:literal,
        $standard:literal $($section:literal)? $confidence:ident, fails $fails:literal, passes $passes:literal;)+) => {
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
            fails: $fails,
            passes: $passes,
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

pub(super) use {rules, section};
