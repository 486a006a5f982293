//! What could not be read, shown and counted.

use crate::output::diagnostic;
use canvass_traces::{Damage, DamageKind};
use std::collections::BTreeMap;

/// Shows the first damages of each kind and counts all.
#[derive(Default)]
pub struct Damages {
    counts: BTreeMap<&'static str, u64>,
    /// How often frames were said to be lost, and how many.
    losses: (u64, u64),
}

/// How many of a kind are shown one by one.
const SHOWN: u64 = 10;

impl Damages {
    /// Shows a damage of the source of that name, unless many of its kind were shown.
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

    /// Says how many there were, if there were more than were shown.
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
