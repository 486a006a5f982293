//! Distributes the tests over machines: each machine gets the next longest test when it has the least to do.

use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::fs;

/// The cost of each test in seconds of processor time, from the measurement of a whole run (`target/vcan/costs.txt`).
/// If a test is new or has become longer, its machine ends later than the others; the costs have no other effect.
const COSTS: &str = "tests/vcan/costs.txt";
/// The assumed cost of a test that the file does not list.
const UNKNOWN: f64 = 5.0;

pub struct Costs(BTreeMap<String, f64>);

impl Costs {
    pub fn read() -> Result<Self> {
        let text = fs::read_to_string(COSTS).context(COSTS)?;
        let costs = text.lines().map(|line| {
            let (seconds, name) = line.split_once(' ').with_context(|| format!("{COSTS}: {line}"))?;
            Ok((name.to_owned(), seconds.parse()?))
        });
        costs.collect::<Result<_>>().map(Self)
    }

    fn of(&self, name: &str) -> f64 {
        self.0.get(name).copied().unwrap_or(UNKNOWN)
    }
}

/// The names of the tests for each machine.
pub fn deal(names: &[String], machines: usize, costs: &Costs) -> Vec<Vec<String>> {
    let mut longest_first: Vec<&String> = names.iter().collect();
    longest_first.sort_by(|a, b| costs.of(b).total_cmp(&costs.of(a)));
    let mut dealt = vec![(0.0_f64, Vec::new()); machines];
    for name in longest_first {
        if let Some((load, names)) = dealt.iter_mut().min_by(|a, b| a.0.total_cmp(&b.0)) {
            *load += costs.of(name);
            names.push(name.clone());
        }
    }
    dealt.into_iter().map(|(_, names)| names).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_come_first_and_nobody_waits_for_one() {
        let costs = [("a", 9.0), ("b", 6.0), ("c", 4.0), ("d", 1.0)];
        let costs = Costs(costs.map(|(name, cost)| (name.to_owned(), cost)).into());
        let names = ["d", "c", "new", "b", "a"].map(str::to_owned);
        assert_eq!(deal(&names, 2, &costs), [vec!["a", "c"], vec!["b", "new", "d"]]);
    }
}
