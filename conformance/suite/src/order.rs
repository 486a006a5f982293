//! The order of cases for a run that may not last long: the cases that find most faults per second come first.
//!
//! The measure is the catalogue's own: the faults that each case names in `catches`, which the selftest proves.

use crate::case::Case;
use canvass_device::Fault;
use canvass_traces::Duration;
use std::collections::HashSet;

/// A case with the time that it takes on a device like the one under test.
#[derive(Clone, Copy, Debug)]
pub struct Timed {
    /// The case.
    pub case: &'static Case,
    /// The time on the bus.
    pub takes: Duration,
}

/// Sorts the cases: first the case that catches most faults per second, then in each step the case that catches most
/// further faults per second. A further fault is one that no earlier case catches. Cases that catch no further fault
/// come last, quick ones first.
pub fn by_benefit(cases: &[Timed]) -> Vec<Timed> {
    let (mut left, mut sorted, mut caught) = (cases.to_vec(), Vec::with_capacity(cases.len()), HashSet::new());
    while let Some(at) = best(&left, &caught) {
        let next = left.remove(at);
        caught.extend(next.case.catches);
        sorted.push(next);
    }
    left.sort_by_key(|timed| timed.takes);
    sorted.extend(left);
    sorted
}

/// The place of the case with the best ratio of further faults to time; `None` if no case catches a further fault.
fn best(cases: &[Timed], caught: &HashSet<&Fault>) -> Option<usize> {
    let benefit = |timed: &Timed| {
        let further = timed.case.catches.iter().filter(|fault| !caught.contains(fault)).count();
        // A case that takes no time on a simulated bus costs something on a live one.
        further as f64 / timed.takes.nanos().max(1_000_000) as f64
    };
    let ratios = cases.iter().map(benefit).enumerate().filter(|(_, ratio)| *ratio > 0.0);
    // Of cases with the same ratio the first one, so that the order is that of the catalogue.
    let best = ratios.fold(None, |best: Option<(usize, f64)>, one| match best {
        Some(known) if known.1 >= one.1 => best,
        _ => Some(one),
    });
    best.map(|(at, _)| at)
}

/// The first cases of [`by_benefit`] that together catch `percent` of the faults that all these cases catch, in the
/// order of the catalogue.
pub fn quick(cases: &[Timed], percent: usize) -> Vec<Timed> {
    let all = caught(cases);
    let mut caught: HashSet<&Fault> = HashSet::new();
    let mut chosen = Vec::new();
    for timed in by_benefit(cases) {
        if caught.len() * 100 >= all * percent {
            break;
        }
        caught.extend(timed.case.catches);
        chosen.push(timed);
    }
    chosen.sort_by_key(|timed| timed.case.id);
    chosen
}

/// Number of faults that at least one of these cases catches.
pub fn caught(cases: &[Timed]) -> usize {
    cases.iter().flat_map(|timed| timed.case.catches).collect::<HashSet<_>>().len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::cases;

    /// All cases. Each takes a second, except the cases in `slow`, which take the given number of seconds.
    fn timed(slow: &[(&str, u64)]) -> Vec<Timed> {
        let takes = |id: &str| slow.iter().find(|row| row.0 == id).map_or(1, |row| row.1);
        cases().into_iter().map(|case| Timed { case, takes: Duration::from_secs(takes(case.id)) }).collect()
    }

    fn further(sorted: &[Timed]) -> Vec<usize> {
        let mut caught = HashSet::new();
        sorted.iter().map(|timed| timed.case.catches.iter().filter(|fault| caught.insert(*fault)).count()).collect()
    }

    #[test]
    fn each_case_is_followed_by_the_one_with_most_further_faults() {
        let sorted = by_benefit(&timed(&[]));
        assert_eq!(sorted.len(), cases().len());
        let further = further(&sorted);
        assert!(further.is_sorted_by(|a, b| a >= b), "of cases of equal duration: {further:?}");
        assert!(further[0] > 1 && further.contains(&0));
    }

    #[test]
    fn a_slow_case_comes_later_and_none_is_lost() {
        let first = by_benefit(&timed(&[]))[0].case.id;
        let sorted = by_benefit(&timed(&[(first, 10_000)]));
        let place = sorted.iter().position(|timed| timed.case.id == first).unwrap();
        assert!(place > 10, "{place}");
        let mut ids: Vec<&str> = sorted.iter().map(|timed| timed.case.id).collect();
        ids.sort_unstable();
        assert!(ids.into_iter().eq(cases().into_iter().map(|case| case.id)));
    }

    #[test]
    fn a_quick_choice_catches_its_share_with_fewer_cases() {
        let cases = timed(&[]);
        let (most, all) = (quick(&cases, 90), quick(&cases, 100));
        assert_eq!(caught(&all), caught(&cases));
        assert!(caught(&most) * 100 >= caught(&cases) * 90 && most.len() < all.len());
        assert!(most.is_sorted_by_key(|timed| timed.case.id));
    }
}
