//! Frames of a run in words, by the analyzer's own network.

use super::evidence::Annotate;
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_analyzer::network::Network;
use canvass_analyzer::{Meaning, NodeId};
use canvass_traces::Record;

/// Says of each frame what `canvass decode` would say.
#[derive(Default)]
pub struct Annotator {
    network: Network,
}

impl Annotator {
    /// An annotator that knows nothing of the devices.
    pub fn new() -> Self {
        Self::default()
    }

    /// Says which device a node is.
    pub fn describe(&mut self, node: NodeId, description: DeviceDescription) {
        self.network.describe(node, description);
    }
}

impl Annotate for Annotator {
    fn annotate(&mut self, record: &Record) -> String {
        let decoded = self.network.handle(record);
        let bus = self.network.bus(record.channel);
        bus.map(|bus| Meaning::new(record, &decoded, bus).to_string()).unwrap_or_default()
    }
}
