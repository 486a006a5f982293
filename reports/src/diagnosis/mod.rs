//! What was on the buses of a capture and what was wrong: as a table, JSON, Markdown, JUnit and an HTML page.

mod findings;
pub mod html;
mod json;
mod node_table;
mod reading;
mod report;
mod rules;
mod story;
mod suites;

pub use json::evidence;
pub use reading::Reading;
pub use report::{Advice, DiagnosisReport};
pub use rules::{explain, handbook};

use crate::provenance::Provenance;
use crate::quality::CaptureQuality;
use canvass_analyzer::Service;
use canvass_analyzer::findings::{Exhibit, Finding, Results, Severity};
use canvass_traces::{ChannelId, Channels, Timestamp};
use std::fmt::Write as _;

/// A diagnosis that is to be shown.
#[derive(Clone, Copy, Debug)]
pub struct Diagnosed<'a> {
    /// What was found.
    pub results: &'a Results,
    /// The names of the channels.
    pub channels: &'a Channels,
    /// The captures that were read, and their quality.
    pub captures: &'a [CaptureQuality<'a>],
    /// Where the result comes from.
    pub provenance: &'a Provenance,
}

impl Diagnosed<'_> {
    /// All frames that were looked at.
    pub fn frames(&self) -> u64 {
        self.results.buses.iter().map(|(_, bus)| bus.total()).sum::<u64>() + self.results.unwatched
    }

    /// How many findings are of a severity.
    pub fn count(&self, severity: Severity) -> usize {
        self.results.findings.iter().filter(|finding| finding.severity == severity).count()
    }

    /// The frames of all buses by service.
    fn by_service(&self) -> impl Iterator<Item = (Service, u64)> {
        Service::ALL.into_iter().map(|service| {
            let frames = self.results.buses.iter().map(|(_, bus)| bus.frames[service as usize]);
            (service, frames.sum())
        })
    }

    /// When the first frame of all buses was seen.
    fn start(&self) -> Option<Timestamp> {
        self.results.buses.iter().map(|(_, bus)| bus.first).min()
    }

    /// A time since the start of the captures, in seconds.
    fn since_start(&self, time: Timestamp) -> String {
        let start = self.start().unwrap_or(time);
        let micros = time.since(start).nanos() / 1000;
        format!("{}.{:06}", micros / 1_000_000, micros % 1_000_000)
    }

    /// Where an exhibit stands: the file's name where there is only one, and the line or packet.
    fn place(&self, exhibit: &Exhibit) -> String {
        match self.captures {
            [capture] => format!("{}:{}", capture.name, exhibit.place.number),
            _ => format!("#{}", exhibit.place.number),
        }
    }

    /// The node and channel of a finding: `node 5 on can0`, or nothing where it is about no bus.
    fn whom(&self, finding: &Finding) -> String {
        let node = finding.node.map(|node| format!("node {node}"));
        let channel = finding.channel.filter(|_| self.results.buses.len() > 1).map(|id| self.channel(id));
        match (node, channel) {
            (Some(node), Some(channel)) => format!("{node} on {channel}"),
            (Some(whom), None) | (None, Some(whom)) => whom,
            (None, None) => String::new(),
        }
    }

    fn channel(&self, id: ChannelId) -> String {
        self.channels.name(id).to_owned()
    }
}

/// The frame of an exhibit: its CAN-ID and bytes; nothing where there is none.
fn frame(exhibit: &Exhibit) -> String {
    exhibit.record.as_ref().map(|record| record.frame.to_string()).unwrap_or_default()
}

/// `, 12 times until 3.4 s`, where it happened more than once.
fn times(diagnosed: &Diagnosed<'_>, finding: &Finding) -> String {
    let mut text = String::new();
    if finding.count > 1 {
        // Writing to a string can't fail.
        let _ = write!(text, " ({} times, the last at {} s)", finding.count, diagnosed.since_start(finding.last));
    }
    text
}
