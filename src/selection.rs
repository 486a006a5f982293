//! `--node`, `--channel`, `--filter`: selection of frames.

use crate::devices::{self, DeviceArg};
use crate::inputs::Inputs;
use crate::output::diagnostic;
use crate::status::Failure;
use canvass_analyzer::filter::{Filter, Subject};
use canvass_analyzer::network::{Decoded, Network, Steady};
use canvass_analyzer::{NodeId, NodeRange};
use canvass_device::models::Model;
use canvass_traces::{ChannelId, Record};
use std::cell::Cell;
use std::sync::Arc;

/// Options that select frames.
#[derive(clap::Args)]
pub struct Selection {
    /// Only frames of these nodes, such as 5 or 1..8,63
    #[arg(long, value_name = "NODE", value_delimiter = ',')]
    node: Vec<NodeRange>,
    #[command(flatten)]
    channels: Channels,
    /// Only frames that pass this filter, such as 'service=sdo and node in 1..8 and index=0x6003 or abort'
    #[arg(long, value_name = "EXPRESSION")]
    filter: Option<Filter>,
    /// The device of a node: a built-in model, or an EDS or DCF file; several nodes as 1..8=motor.eds, or all=motor.eds
    #[arg(long, value_name = "NODE=MODEL|FILE")]
    device: Vec<DeviceArg>,
    #[arg(skip)]
    counts: Counts,
}

/// The option that selects channels.
#[derive(clap::Args)]
pub struct Channels {
    /// Only frames of these channels, such as can0; of several files, also FILE:CHANNEL
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    channel: Vec<String>,
}

impl Channels {
    /// Whether a channel is selected.
    pub fn has(&self, channel: ChannelId, inputs: &Inputs<'_>) -> bool {
        self.channel.is_empty() || {
            let (name, own) = (inputs.channels().name(channel), inputs.own_name(channel));
            self.channel.iter().any(|wanted| wanted == name || wanted == own)
        }
    }

    /// Warns of channels that no frame has: they are probably misspelt.
    pub fn warn_of_unknown(&self, inputs: &Inputs<'_>) {
        let seen: Vec<&str> = inputs.channels().names().collect();
        let is_own = |id: usize, wanted: &str| inputs.own_name(ChannelId(id as u16)) == wanted;
        for wanted in &self.channel {
            if !seen.iter().enumerate().any(|(id, name)| name == wanted || is_own(id, wanted)) {
                diagnostic(&format!("canvass: no channel is named {wanted}; there were: {}", seen.join(", ")));
            }
        }
    }
}

/// Number of frames tested, and number that passed each test.
#[derive(Clone, Default)]
struct Counts {
    asked: Cell<u64>,
    of_node: Cell<u64>,
    tried: Cell<u64>,
    passed: Cell<u64>,
}

fn count(counter: &Cell<u64>) {
    counter.set(counter.get() + 1);
}

impl Selection {
    /// Makes a network that knows the given devices.
    pub fn network(&self) -> Result<Network, Failure> {
        let mut network = Network::new();
        network.offer(Model::candidates());
        devices::each(&self.device, |node, known| network.describe(node, Arc::clone(known)))?;
        Ok(network)
    }

    /// The models and files that `--device` names.
    pub fn descriptions(&self) -> impl Iterator<Item = &str> {
        self.device.iter().map(|device| &*device.device)
    }

    /// Whether a filter was given.
    pub fn has_filter(&self) -> bool {
        self.filter.is_some()
    }

    /// Whether the selection needs decoded frames.
    pub fn needs_decoding(&self) -> bool {
        !self.node.is_empty() || self.filter.is_some()
    }

    /// Whether the record's channel is selected.
    pub fn has_channel(&self, record: &Record, inputs: &Inputs<'_>) -> bool {
        self.has_channel_id(record.channel, inputs)
    }

    /// Whether a channel is selected.
    pub fn has_channel_id(&self, channel: ChannelId, inputs: &Inputs<'_>) -> bool {
        self.channels.has(channel, inputs)
    }

    /// Whether a record is selected; its channel is not checked.
    pub fn has(&self, record: &Record, decoded: &Decoded, inputs: &Inputs<'_>) -> bool {
        count(&self.counts.asked);
        let of_node = self.has_node(decoded.node);
        if of_node {
            count(&self.counts.of_node);
        }
        of_node && self.passes(record, decoded, inputs)
    }

    /// Whether the node is selected.
    pub fn has_node(&self, node: Option<NodeId>) -> bool {
        self.node.is_empty() || node.is_some_and(|node| self.node.iter().any(|range| range.contains(node)))
    }

    /// Whether a record passes the filter; its channel and node are not checked.
    pub fn passes(&self, record: &Record, decoded: &Decoded, inputs: &Inputs<'_>) -> bool {
        let subject = Subject { record, decoded, channel: inputs.channels().name(record.channel) };
        count(&self.counts.tried);
        let passes = self.filter.as_ref().is_none_or(|filter| filter.matches(&subject));
        if passes {
            count(&self.counts.passed);
        }
        passes
    }

    /// Whether neither this frame nor any frame like it is selected; the channel is not checked.
    pub fn refuses_alike(&self, record: &Record, decoded: &Decoded, inputs: &Inputs<'_>, steady: Steady) -> bool {
        let subject = Subject { record, decoded, channel: inputs.channels().name(record.channel) };
        let by_filter = || self.filter.as_ref().is_some_and(|filter| filter.refuses_alike(&subject, steady));
        !self.has_node(decoded.node) || by_filter()
    }

    /// Warns of nodes, channels and filters that no frame matched: they are probably misspelt.
    pub fn warn_of_nothing(&self, inputs: &Inputs<'_>) {
        self.channels.warn_of_unknown(inputs);
        let Counts { asked, of_node, tried, passed } = &self.counts;
        if asked.get() > 0 && of_node.get() == 0 && !self.node.is_empty() {
            let nodes: Vec<String> = self.node.iter().map(ToString::to_string).collect();
            diagnostic(&format!("canvass: no frame is of node {} (--node)", nodes.join(", ")));
        } else if tried.get() > 0 && passed.get() == 0 && self.filter.is_some() {
            diagnostic("canvass: no frame passes the filter (`canvass help filter` shows what it can say)");
        }
    }
}
