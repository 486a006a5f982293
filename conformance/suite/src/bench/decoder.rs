//! The decoded text of evidence. The analyzer writes the text; it gets all frames of the run.

use super::{Annotate, Target};
use canvass_analyzer::Meaning;
use canvass_analyzer::dictionary::KnownDevice;
use canvass_analyzer::network::Network;
use canvass_traces::Record;

/// Annotates frames with the analyzer's decoding, in the context of the run.
#[derive(Default)]
pub struct Decoder {
    network: Network,
}

impl Decoder {
    /// A decoder that knows the device under test by its description, if there is one.
    pub fn new(target: &Target) -> Self {
        let mut network = Network::new();
        if let Some(description) = &target.description {
            let (description, manual) = (description.clone(), target.manual.clone());
            network.describe(target.node, KnownDevice { description, manual });
        }
        Self { network }
    }
}

impl Annotate for Decoder {
    fn annotate(&mut self, record: &Record) -> String {
        let decoded = self.network.handle(record);
        match self.network.bus(record.channel) {
            Some(bus) => Meaning::new(record, &decoded, bus).to_string(),
            None => String::new(),
        }
    }
}
