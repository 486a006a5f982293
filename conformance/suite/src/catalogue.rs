//! All cases, and their selection.

use crate::case::Case;
use crate::dice::Dice;
use crate::glob;
use std::fmt;
use std::str::FromStr;

/// All cases in the order of their ids.
pub fn cases() -> Vec<&'static Case> {
    let mut cases: Vec<&'static Case> = inventory::iter::<Case>.into_iter().collect();
    cases.sort_unstable_by_key(|case| case.id);
    cases
}

/// The case with this id.
pub fn find(id: &str) -> Option<&'static Case> {
    inventory::iter::<Case>.into_iter().find(|case| case.id == id)
}

/// Checks that a pattern in a file matches a case; otherwise returns the error in the pattern.
pub(crate) fn expect(pattern: &str) -> Result<(), String> {
    match cases().iter().any(|known| glob::matches(pattern, known.id)) {
        true => Ok(()),
        false => Err(format!("no case is called \"{pattern}\": `canvass list cases` shows them")),
    }
}

/// One part of a selection.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Selector {
    /// The beginning of an id in whole words: `301/sdo`.
    Prefix(String),
    /// An id with `*` for any characters: `301/*/read-only`.
    Glob(String),
    /// The beginning of a section in whole numbers: `7.2.8` or `CiA 301 7.2.8`.
    Section {
        /// The standard, if it is named.
        standard: Option<String>,
        /// The section.
        section: String,
    },
}

/// A text that is no selector.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error(
    "\"{0}\" selects nothing: expected the beginning of an id (301/sdo), a pattern (301/*/read-only) or a section (7.2.8)"
)]
pub struct BadSelector(pub String);

impl FromStr for Selector {
    type Err = BadSelector;

    fn from_str(text: &str) -> Result<Self, BadSelector> {
        let text = text.trim();
        let is_section = |s: &str| s.contains('.') && s.bytes().all(|b| b.is_ascii_digit() || b == b'.');
        if text.is_empty() {
            return Err(BadSelector(text.to_owned()));
        }
        if text.contains('*') {
            return Ok(Self::Glob(text.to_owned()));
        }
        match text.rsplit_once(' ') {
            Some((standard, section)) if is_section(section) => {
                Ok(Self::Section { standard: Some(standard.trim().to_owned()), section: section.to_owned() })
            }
            Some(_) => Err(BadSelector(text.to_owned())),
            None if is_section(text) => Ok(Self::Section { standard: None, section: text.to_owned() }),
            None => Ok(Self::of_id(text.trim_end_matches('/'))),
        }
    }
}

/// The selector as the user types it.
impl fmt::Display for Selector {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Prefix(text) | Self::Glob(text) | Self::Section { standard: None, section: text } => {
                f.write_str(text)
            }
            Self::Section { standard: Some(standard), section } => write!(f, "{standard} {section}"),
        }
    }
}

impl Selector {
    /// Selects the cases below an id. If there are none, selects the ids that continue with a hyphen: `301/nmt/reset`
    /// selects `301/nmt/reset-node/parameters`; `301/heartbeat`, below which there are cases, selects none of
    /// `301/heartbeat-consumer`.
    fn of_id(id: &str) -> Self {
        let any = |separator| cases().iter().any(|case| is_prefix(id, case.id, separator));
        if !any('/') && any('-') { Self::Glob(format!("{id}-*")) } else { Self::Prefix(id.to_owned()) }
    }

    /// Whether the selector selects the case.
    pub fn selects(&self, case: &Case) -> bool {
        match self {
            Self::Prefix(prefix) => is_prefix(prefix, case.id, '/'),
            Self::Glob(pattern) => glob::matches(pattern, case.id),
            Self::Section { standard, section } => {
                standard.as_ref().is_none_or(|standard| standard.eq_ignore_ascii_case(case.clause.standard))
                    && case.clause.section.is_some_and(|own| is_prefix(section.trim_end_matches('.'), own, '.'))
            }
        }
    }
}

/// The cases that a selector selects, in the order in which they run: by id, but cases that can lose the device are
/// last. All cases if there is no selector.
///
/// # Errors
/// A selector that selects no case: most likely a typing error that would leave a test out.
pub fn select(selectors: &[Selector]) -> Result<Vec<&'static Case>, Selector> {
    let mut cases = cases();
    if let Some(idle) = selectors.iter().find(|selector| !cases.iter().any(|case| selector.selects(case))) {
        return Err(idle.clone());
    }
    if !selectors.is_empty() {
        cases.retain(|case| selectors.iter().any(|selector| selector.selects(case)));
    }
    cases.sort_by_key(|case| case.can_lose_the_device());
    Ok(cases)
}

/// The cases in a random order, equal for equal seeds. Cases that can lose the device are last, as in [`select`].
pub fn shuffled(cases: &[&'static Case], seed: u64) -> Vec<&'static Case> {
    let mut dice = Dice::new(seed);
    let mut drawn: Vec<(bool, u64, &'static Case)> =
        cases.iter().map(|case| (case.can_lose_the_device(), dice.next(), *case)).collect();
    drawn.sort_unstable_by_key(|(risky, number, _)| (*risky, *number));
    drawn.into_iter().map(|(_, _, case)| case).collect()
}

/// A question for the error message of a selector that selects nothing: which family or case it may have meant.
pub fn meant(selector: &Selector) -> String {
    let names = cases().into_iter().flat_map(|case| [case.family(), case.id]);
    canvass_analyzer::meant(&selector.to_string(), names)
}

/// Whether `text` equals `prefix` or continues after it with a separator.
fn is_prefix(prefix: &str, text: &str, separator: char) -> bool {
    text.strip_prefix(prefix).is_some_and(|rest| rest.is_empty() || rest.starts_with(separator))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn selected(text: &str) -> Vec<&'static str> {
        let selector: Selector = text.parse().unwrap();
        cases().into_iter().filter(|case| selector.selects(case)).map(|case| case.id).collect()
    }

    #[test]
    fn ids_are_unique() {
        let ids: BTreeSet<&str> = cases().iter().map(|case| case.id).collect();
        assert_eq!(ids.len(), cases().len());
    }

    #[test]
    fn what_can_lose_the_device_runs_last() {
        let shape = |selectors: &[Selector]| {
            let cases = select(selectors).unwrap();
            let first = cases.partition_point(|case| !case.can_lose_the_device());
            let (safe, risky) = cases.split_at(first);
            assert!(risky.iter().all(|case| case.can_lose_the_device()));
            assert!(safe.is_sorted_by_key(|case| case.id) && risky.is_sorted_by_key(|case| case.id));
            (safe.len(), risky.len())
        };
        let (safe, risky) = shape(&[]);
        assert!(safe + risky == cases().len() && risky > 10);
        let selected = ["305/node-id", "301/restore", "301/time"].map(|text| text.parse().unwrap());
        assert!(shape(&selected).1 > 0);
    }

    #[test]
    fn a_shuffled_order_has_every_case_once_and_risky_cases_last() {
        let usual = select(&[]).unwrap();
        let ids = |cases: &[&'static Case]| cases.iter().map(|case| case.id).collect::<Vec<_>>();
        let (one, again, other) = (shuffled(&usual, 1), shuffled(&usual, 1), shuffled(&usual, 2));
        assert_eq!(ids(&one), ids(&again));
        assert!(ids(&one) != ids(&other) && ids(&one) != ids(&usual));
        assert_eq!(one.iter().map(|case| case.id).collect::<BTreeSet<_>>().len(), usual.len());
        assert!(one.is_sorted_by_key(|case| case.can_lose_the_device()));
    }

    #[test]
    fn every_case_names_a_fault_and_a_requirement() {
        for case in cases() {
            assert!(!case.catches.is_empty() && case.summary().len() > 20, "{}", case.id);
        }
    }

    #[test]
    fn selectors() {
        assert!(selected("301/sdo").iter().all(|id| id.starts_with("301/sdo/")));
        assert!(selected("301/sd").is_empty(), "whole words only");
        assert!(selected("301/nmt/reset").len() > 1);
        assert!(selected("301/nmt/reset").iter().all(|id| id.starts_with("301/nmt/reset-")));
        assert!(!selected("301/heartbeat").is_empty());
        assert!(selected("301/heartbeat").iter().all(|id| id.starts_with("301/heartbeat/")));
        assert_eq!(selected("301/sdo/download/read-only"), ["301/sdo/download/read-only"]);
        assert_eq!(selected("301/sdo/*load/read-only").len(), 2);
        assert!(!selected("7.2.8").is_empty());
        assert_eq!(selected("CiA 301 7.2.8"), selected("7.2.8"));
        assert!(selected("CiA 305 7.2.8").is_empty());
        assert!("".parse::<Selector>().is_err());
        assert_eq!(meant(&Selector::Prefix("301/heartbeet".to_owned())), " (is 301/heartbeat meant?)");
        assert_eq!(meant(&Selector::Prefix("nonsense".to_owned())), "");
        let idle = select(&["301/sod".parse().unwrap()]).map(|cases| cases.len());
        assert_eq!(idle, Err(Selector::Prefix("301/sod".to_owned())));
    }
}
