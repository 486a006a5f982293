//! Damage in captures, printed and counted.

use crate::output::diagnostic;
use canvass_traces::{Damage, DamageKind};
use std::collections::BTreeMap;

/// Prints the first damages of each kind and counts all.
#[derive(Default)]
pub struct Damages {
    counts: BTreeMap<&'static str, u64>,
    /// Number of losses that the capture reports, and the number of frames lost by them.
    losses: (u64, u64),
}

/// Number of damages of a kind that are printed one by one.
const SHOWN: u64 = 10;

impl Damages {
    /// Prints a damage of the named source, unless [`SHOWN`] of its kind were printed already. Lost frames and fatal
    /// damage are always printed.
    pub fn report(&mut self, name: &str, damage: &Damage) {
        if let DamageKind::Dropped(frames) = damage.kind {
            self.losses = (self.losses.0 + 1, self.losses.1.saturating_add(frames));
        }
        let count = self.counts.entry(damage.kind.name()).or_default();
        *count += match damage.kind {
            DamageKind::Dropped(n) => n,
            _ => 1,
        };
        if *count <= SHOWN || matches!(damage.kind, DamageKind::Dropped(_) | DamageKind::Fatal) {
            let column = damage.column.map(|column| format!(":{column}")).unwrap_or_default();
            diagnostic(&format!("{name}:{}{column}: {damage}", damage.place.number));
        }
    }

    /// Prints the totals of the kinds that were not printed in full.
    pub fn summarise(&self) {
        if let (2.., frames) = self.losses {
            diagnostic(&format!("canvass: {frames} frames were lost in all"));
        }
        let dropped = DamageKind::Dropped(0).name();
        for (kind, count) in self.counts.iter().filter(|(kind, count)| **kind != dropped && **count > SHOWN) {
            diagnostic(&format!("canvass: {count} {kind} in all, the first {SHOWN} shown"));
        }
    }
}
