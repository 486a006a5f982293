//! The traffic on the buses of a capture and its faults, as a table, JSON, Markdown, JUnit and an HTML page.

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

/// A diagnosis to report.
#[derive(Clone, Copy, Debug)]
pub struct Diagnosed<'a> {
    /// The results of the diagnosis.
    pub results: &'a Results,
    /// The names of the channels.
    pub channels: &'a Channels,
    /// The captures that were read, and their quality.
    pub captures: &'a [CaptureQuality<'a>],
    /// The provenance of the result.
    pub provenance: &'a Provenance,
}

impl Diagnosed<'_> {
    /// Number of frames that the diagnosis has seen.
    pub fn frames(&self) -> u64 {
        self.results.buses.iter().map(|(_, bus)| bus.total()).sum::<u64>() + self.results.unwatched
    }

    /// Number of findings of a severity.
    pub fn count(&self, severity: Severity) -> usize {
        self.results.findings.iter().filter(|finding| finding.severity == severity).count()
    }

    /// Number of frames on all buses by service.
    fn by_service(&self) -> impl Iterator<Item = (Service, u64)> {
        Service::ALL.into_iter().map(|service| {
            let frames = self.results.buses.iter().map(|(_, bus)| bus.frames[service as usize]);
            (service, frames.sum())
        })
    }

    /// The time of the first frame on any bus.
    fn start(&self) -> Option<Timestamp> {
        self.results.buses.iter().map(|(_, bus)| bus.first).min()
    }

    /// A time since the start of the captures, in seconds.
    fn since_start(&self, time: Timestamp) -> String {
        let start = self.start().unwrap_or(time);
        let micros = time.since(start).nanos() / 1000;
        format!("{}.{:06}", micros / 1_000_000, micros % 1_000_000)
    }

    /// The place of an exhibit: the line or packet, and the name of the file if there is only one.
    fn place(&self, exhibit: &Exhibit) -> String {
        match self.captures {
            [capture] => format!("{}:{}", capture.name, exhibit.place.number),
            _ => format!("#{}", exhibit.place.number),
        }
    }

    /// The node and channel of a finding: `node 5 on can0`. Empty if the finding is about no bus.
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

/// The frame of an exhibit: its CAN-ID and bytes. Empty if the exhibit has no frame.
fn frame(exhibit: &Exhibit) -> String {
    exhibit.record.as_ref().map(|record| record.frame.to_string()).unwrap_or_default()
}

/// The number of occurrences of a finding: ` (12 times, the last at 3.4 s)`. Empty for a single occurrence.
fn times(diagnosed: &Diagnosed<'_>, finding: &Finding) -> String {
    let mut text = String::new();
    if finding.count > 1 {
        // Writing to a string can't fail.
        let _ = write!(text, " ({} times, the last at {} s)", finding.count, diagnosed.since_start(finding.last));
    }
    text
}
