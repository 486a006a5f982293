//! The data of the page that findings and figures don't contain: frames, and values over time.

use super::excerpt::Excerpt;
use crate::signals::Sampler;
use crate::signals::buckets::{Buckets, Merge};
use crate::signals::series::Series;
use canvass_analyzer::findings::Observed;
use canvass_analyzer::network::Event;
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_analyzer::{Meaning, NodeId};
use canvass_traces::{ChannelId, Channels, Duration, Record, Timestamp};
use std::collections::BTreeMap;
use std::io;

/// Collects the data of the page while a capture is read, once, in bounded memory.
pub struct Collector {
    pub(super) excerpt: Excerpt,
    pub(super) sampler: Sampler,
    pub(super) series: Series,
    pub(super) emergencies: BTreeMap<(ChannelId, NodeId), Buckets<Emergencies, 256>>,
}

/// Number of nodes (four full buses) whose EMCY messages fill all buckets; further nodes have [`ROUGHLY`] buckets each.
const CLOSELY: usize = 508;
const ROUGHLY: usize = 32;

/// The EMCY messages of one node within a bucket.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Emergencies {
    /// The time of the first message.
    pub time: Timestamp,
    /// The error code of the first message that reports an error, or of the first message if no message reports an
    /// error.
    pub code: EmcyCode,
    /// Number of messages.
    pub count: u64,
}

impl Merge for Emergencies {
    fn merge(&mut self, later: Self) {
        self.count += later.count;
        if self.code.is_reset() {
            self.code = later.code;
        }
    }
}

impl Default for Collector {
    fn default() -> Self {
        Self {
            excerpt: Excerpt::default(),
            sampler: Sampler::new(None),
            series: Series::default(),
            emergencies: BTreeMap::new(),
        }
    }
}

impl Collector {
    /// Takes a frame after the diagnosis has taken it.
    ///
    /// # Errors
    /// None: the values of the page stay in memory. The result has the type of all sheets, some of which write to a
    /// file.
    pub fn frame(&mut self, record: &Record, channels: &Channels, observed: &Observed<'_>) -> io::Result<()> {
        self.excerpt.frame(record, observed);
        for event in observed.bus.events() {
            if let Event::Emergency(node, emergency) = event
                && let Some(code) = emergency.emcy.code()
            {
                let time = record.timestamp;
                // A user looks less closely at each of thousands of nodes.
                let most = if self.emergencies.len() < CLOSELY { usize::MAX } else { ROUGHLY };
                let new = || Buckets::new(time, Duration::from_millis(10)).limited_to(most);
                let buckets = self.emergencies.entry((record.channel, *node)).or_insert_with(new);
                buckets.add(time, Emergencies { time, code, count: 1 });
            }
        }
        let meaning = Meaning::new(record, observed.decoded, observed.bus);
        self.sampler.frame(record, channels, observed.decoded, &meaning, &mut self.series, &mut Vec::new())
    }
}
