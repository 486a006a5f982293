//! `--node`, `--channel`, `--filter`: which frames of a capture.

use crate::devices::{DeviceArg, parse_node};
use crate::inputs::Inputs;
use crate::output::diagnostic;
use crate::status::Failure;
use canvass_analyzer::NodeId;
use canvass_analyzer::filter::{Filter, Subject};
use canvass_analyzer::network::{Decoded, Network};
use canvass_device::models::Model;
use canvass_traces::{ChannelId, Record};

/// Which frames are chosen.
#[derive(clap::Args)]
pub struct Selection {
    /// Only frames of these nodes
    #[arg(long, value_name = "NODE", value_parser = parse_node, value_delimiter = ',')]
    node: Vec<NodeId>,
    /// Only frames of these channels, such as can0; of several files, also FILE:CHANNEL
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    channel: Vec<String>,
    /// Only frames that pass this filter, such as 'service=sdo and node in 1..8 and index=0x6003 or abort'
    #[arg(long, value_name = "EXPRESSION")]
    filter: Option<Filter>,
    /// Which device a node is: a built-in model or an EDS or DCF file
    #[arg(long, value_name = "NODE=MODEL|FILE")]
    device: Vec<DeviceArg>,
}

impl Selection {
    /// A network that knows the devices named.
    pub fn network(&self) -> Result<Network, Failure> {
        let mut network = Network::new();
        network.offer(Model::candidates());
        for device in &self.device {
            network.describe(device.node, device.describe()?);
        }
        Ok(network)
    }

    /// Whether a filter was given.
    pub fn has_filter(&self) -> bool {
        self.filter.is_some()
    }

    /// Whether frames must be decoded to be chosen.
    pub fn needs_decoding(&self) -> bool {
        !self.node.is_empty() || self.filter.is_some()
    }

    /// Whether a record's channel is chosen.
    pub fn has_channel(&self, record: &Record, inputs: &Inputs<'_>) -> bool {
        self.has_channel_id(record.channel, inputs)
    }

    /// Whether a channel is chosen.
    pub fn has_channel_id(&self, channel: ChannelId, inputs: &Inputs<'_>) -> bool {
        self.channel.is_empty() || {
            let (name, own) = (inputs.channels().name(channel), inputs.own_name(channel));
            self.channel.iter().any(|wanted| wanted == name || wanted == own)
        }
    }

    /// Whether a record is chosen, whatever its channel.
    pub fn has(&self, record: &Record, decoded: &Decoded, inputs: &Inputs<'_>) -> bool {
        self.has_node(decoded.node) && self.passes(record, decoded, inputs)
    }

    /// Whether what is about that node is chosen.
    pub fn has_node(&self, node: Option<NodeId>) -> bool {
        self.node.is_empty() || node.is_some_and(|node| self.node.contains(&node))
    }

    /// Whether a record passes the filter, whatever its channel and node.
    pub fn passes(&self, record: &Record, decoded: &Decoded, inputs: &Inputs<'_>) -> bool {
        let subject = Subject { record, decoded, channel: inputs.channels().name(record.channel) };
        self.filter.as_ref().is_none_or(|filter| filter.matches(&subject))
    }

    /// Says which channels were asked for and never seen: most likely they are called otherwise.
    pub fn warn_of_unknown_channels(&self, inputs: &Inputs<'_>) {
        let seen: Vec<&str> = inputs.channels().names().collect();
        let is_own = |id: usize, wanted: &str| inputs.own_name(canvass_traces::ChannelId(id as u16)) == wanted;
        for wanted in &self.channel {
            if !seen.iter().enumerate().any(|(id, name)| name == wanted || is_own(id, wanted)) {
                let seen: Vec<String> = seen.iter().map(|name| name.escape_debug().to_string()).collect();
                diagnostic(&format!("canvass: no channel is named {wanted}; there were: {}", seen.join(", ")));
            }
        }
    }
}
