//! The errors that nodes have reported by EMCY and not yet taken back, for all rules.

use crate::findings::Seen;
use crate::message::{Message, Service};
use crate::network::{Decoded, OpenErrors, Source};
use crate::wire::emcy::EmcyCode;
use crate::{NodeId, PerNode};
use canvass_traces::{Record, Timestamp};

/// The present errors of all nodes of a bus.
#[derive(Default)]
pub struct Errors {
    nodes: PerNode<OpenErrors<Raised>>,
}

/// The first message of an error. Smaller than a whole [`Seen`], as a node may have many errors.
pub struct Raised {
    record: Record,
    node: NodeId,
    source: Source,
}

impl Raised {
    /// Time of the message.
    pub const fn time(&self) -> Timestamp {
        self.record.timestamp
    }

    /// The message as a kept frame.
    pub fn seen(&self) -> Seen {
        Seen { record: self.record.clone(), decoded: Decoded::emcy(self.node, self.source, self.record.frame.data()) }
    }
}

impl Errors {
    /// Handles a frame; returns the errors that end with it.
    pub(super) fn frame(&mut self, record: &Record, decoded: &Decoded) -> Vec<(EmcyCode, Raised)> {
        let Some(node) = decoded.node else { return Vec::new() };
        let errors = &mut self.nodes[node];
        match decoded.message {
            _ if decoded.service == Service::BootUp => errors.clear(),
            Message::Emcy(emcy) => {
                let source = decoded.source;
                return errors.handle(&emcy, || Raised { record: record.clone(), node, source });
            }
            _ => {}
        }
        Vec::new()
    }

    /// All present errors.
    pub fn open(&self) -> impl Iterator<Item = (NodeId, EmcyCode, &Raised)> {
        self.nodes.iter().flat_map(|(node, errors)| errors.iter().map(move |(code, raised)| (node, code, raised)))
    }
}
