//! Mapped values that have no place in a sheet, each with the reason.

use canvass_analyzer::network::Decoded;
use canvass_analyzer::{Meaning, Message, NodeId, PdoNumber, SignalValue};
use canvass_traces::{ChannelId, Channels, Record};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Why values of a PDO are left out.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Reason {
    /// The mapping of the PDO is not known.
    NoMapping,
    /// The object is mapped beyond the end of the PDO.
    TooShort { object: String },
    /// The object has more than 64 bits.
    TooLong { object: String, bits: u8 },
}

/// The values that were left out.
#[derive(Default)]
pub struct Dropped(BTreeMap<(ChannelId, NodeId, PdoNumber, Reason), u64>);

/// Maximum number of different values that are told one by one.
const TOLD: usize = 10;
/// Maximum number of different values that are counted: more than any network has, and a limit for a hostile capture.
const MOST: usize = 4096;

impl Dropped {
    /// Whether nothing was left out.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Counts what the sheet does not have of a frame.
    pub(super) fn note(&mut self, record: &Record, decoded: &Decoded, pdo: PdoNumber, meaning: &Meaning<'_>) {
        let Some(node) = decoded.node else { return };
        let mut add = |reason| {
            let key = (record.channel, node, pdo, reason);
            if self.0.len() < MOST || self.0.contains_key(&key) {
                *self.0.entry(key).or_default() += 1;
            }
        };
        if matches!(decoded.message, Message::Pdo(_)) && !meaning.has_known_layout() {
            return add(Reason::NoMapping);
        }
        for signal in meaning.signals().filter(|signal| signal.raw.is_none()) {
            let object = name(&signal);
            add(if signal.bits > 64 {
                Reason::TooLong { object, bits: signal.bits }
            } else {
                Reason::TooShort { object }
            });
        }
    }

    /// A line for each kind of value that was left out, such as `node 5 TPDO 3: the mapping is not known (120 PDOs)`.
    pub fn lines(&self, channels: &Channels) -> Vec<String> {
        let several = self.0.keys().any(|(channel, ..)| self.0.keys().next().is_some_and(|first| first.0 != *channel));
        let line = |((channel, node, pdo, reason), count): (&(ChannelId, NodeId, PdoNumber, Reason), &u64)| {
            let mut line = if several { format!("{} ", channels.name(*channel)) } else { String::new() };
            // Writing to a string can't fail.
            let _ = write!(line, "node {node} {pdo}: ");
            let _ = match reason {
                Reason::NoMapping => write!(line, "the mapping is not known"),
                Reason::TooShort { object } => write!(line, "no {object}: the PDO ends before it"),
                Reason::TooLong { object, bits } => {
                    write!(line, "no {object}: a column has up to 64 bits, the object {bits}")
                }
            };
            let _ = write!(line, " ({count} {})", if *count == 1 { "PDO" } else { "PDOs" });
            line
        };
        let mut lines: Vec<String> = self.0.iter().take(TOLD).map(line).collect();
        if self.0.len() > TOLD {
            lines.push(format!("and {} more", self.0.len() - TOLD));
        }
        lines
    }

    /// The nodes with a PDO whose mapping is not known.
    pub fn unmapped(&self) -> impl Iterator<Item = NodeId> {
        let unmapped = self.0.keys().filter(|(.., reason)| *reason == Reason::NoMapping);
        let nodes: std::collections::BTreeSet<NodeId> = unmapped.map(|&(_, node, ..)| node).collect();
        nodes.into_iter()
    }
}

fn name(signal: &SignalValue<'_>) -> String {
    signal.name().map_or_else(|| signal.multiplexer().to_string(), |name| name.to_string())
}
