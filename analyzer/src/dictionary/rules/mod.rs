//! The rules of device descriptions: each with its text, reason, severity, an example that breaks it and an example
//! that keeps it.
//!
//! The code that reads a description and [`super::consistency`] find the breaches; each problem names its rule. A rule
//! is declared once, in a file of its family: `canvass explain`, the page of rules and the tests use that declaration.

pub(crate) mod declare;
pub(super) mod entry;
pub(super) mod field;
pub(super) mod file;
mod kind;
pub(super) mod list;
pub(super) mod module;
pub(super) mod number;
pub(super) mod pdo;
pub(super) mod section;
pub(super) mod standard;
pub(super) mod text;
pub(super) mod xdd;

pub use kind::{ProblemKind, Severity};
pub use text::{CONFLICT, HALF_READ};

use crate::clause::Clause;
pub(crate) use declare::rules;
use std::fmt;
use std::sync::LazyLock;

/// A rule of device descriptions.
pub struct Rule {
    /// A stable textual id, such as `eds/list/count`.
    pub id: &'static str,
    /// The severity of a breach.
    pub severity: Severity,
    /// The kind of a breach.
    pub kind: ProblemKind,
    /// The clause with the requirement.
    pub clause: Clause,
    /// Lines of an EDS that breaks the rule. A line `...` stands for irrelevant fields.
    pub fails: &'static str,
    /// The lines of `fails`, corrected.
    pub passes: &'static str,
    pub(crate) doc: &'static str,
}

impl fmt::Debug for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id)
    }
}

/// Rules with the same id are equal.
impl PartialEq for Rule {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl Eq for Rule {}

const ADVICE: &str = "\n # What to do\n";

impl Rule {
    /// The problem in one line, without full stop.
    pub fn title(&self) -> &'static str {
        self.doc.split("\n\n").next().unwrap_or_default().trim()
    }

    /// The requirement and its reason.
    pub fn what(&self) -> String {
        let text = self.doc.split(ADVICE).next().unwrap_or_default();
        paragraphs(text.split_once("\n\n").map_or("", |(_, what)| what))
    }

    /// The way to fix a breach.
    pub fn advice(&self) -> String {
        paragraphs(self.doc.split_once(ADVICE).map_or("", |(_, advice)| advice))
    }

    /// Whether the rule has this id or belongs to this family: `eds/list/count` belongs to `eds/list` and `eds`.
    pub fn is_in(&self, prefix: &str) -> bool {
        let rest = self.id.strip_prefix(prefix.trim_end_matches('/'));
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
    }
}

/// Joins the lines of each paragraph.
fn paragraphs(text: &str) -> String {
    let joined = |paragraph: &str| paragraph.split_whitespace().collect::<Vec<_>>().join(" ");
    text.split("\n\n").map(joined).filter(|paragraph| !paragraph.is_empty()).collect::<Vec<_>>().join("\n\n")
}

/// The rules of one device profile. The module of the profile registers them.
pub(crate) struct OfProfile(pub &'static [&'static Rule]);

inventory::collect!(OfProfile);

/// All rules in the order of the declarations; the rules of device profiles follow the rules of the standards.
static ALL: LazyLock<Vec<&'static Rule>> = LazyLock::new(|| {
    let mut profiles: Vec<&[&'static Rule]> = inventory::iter::<OfProfile>.into_iter().map(|of| of.0).collect();
    profiles.sort_by_key(|rules| rules.first().map(|rule| rule.id));
    let of_profiles = profiles.concat();
    let families = [
        text::RULES,
        section::RULES,
        field::RULES,
        file::RULES,
        number::RULES,
        list::RULES,
        entry::RULES,
        pdo::RULES,
        standard::RULES,
        &of_profiles,
        module::RULES,
        xdd::RULES,
    ];
    families.concat()
});

/// All rules, by family.
pub fn all() -> impl Iterator<Item = &'static Rule> {
    ALL.iter().copied()
}

/// The rule with that id.
pub fn find(id: &str) -> Option<&'static Rule> {
    all().find(|rule| rule.id == id)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_rule_says_what_it_asks_and_how_to_mend_a_breach() {
        let mut ids = BTreeSet::new();
        for rule in all() {
            assert!(ids.insert(rule.id), "{} twice", rule.id);
            assert!(rule.id.starts_with("eds/") || rule.id.starts_with("xdd/"), "{}", rule.id);
            assert!(
                rule.title().len() > 10 && !rule.title().contains('\n') && !rule.title().ends_with('.'),
                "{}",
                rule.id
            );
            assert!(rule.what().ends_with('.') && rule.advice().ends_with('.'), "{}", rule.id);
            assert!(!rule.fails.is_empty() && !rule.passes.is_empty() && rule.fails != rule.passes, "{}", rule.id);
        }
    }

    #[test]
    fn a_rule_belongs_to_its_families() {
        let rule = find("eds/list/count").unwrap();
        assert!(["eds", "eds/", "eds/list", "eds/list/count"].iter().all(|prefix| rule.is_in(prefix)));
        assert!(!["ed", "eds/li", "xdd", "eds/list/count/x"].iter().any(|prefix| rule.is_in(prefix)));
    }
}
