//! A trace built frame by frame from candump's notation, and how the analyzer decodes each frame.

use canvass_analyzer::Meaning;
use canvass_analyzer::network::{Decoded, Network};
use canvass_traces::{ChannelId, Duration, Record, Timestamp, parse_frame};

/// A network, and a clock that advances by a millisecond with every frame.
pub struct Trace {
    /// The network, for inspection by tests.
    pub network: Network,
    /// The time of the latest frame.
    pub now: Timestamp,
}

/// How the analyzer decodes a frame.
pub struct Said {
    /// The decoded frame.
    pub decoded: Decoded,
    /// The decoded frame as text.
    pub text: String,
}

impl Trace {
    /// A network without prior knowledge.
    pub fn new() -> Self {
        Self { network: Network::new(), now: Timestamp(1_000_000_000) }
    }

    /// Decodes the next frame, written as `7E5#0401000000000000`; blanks are ignored.
    pub fn say(&mut self, frame: &str) -> Said {
        let compact: String = frame.split_whitespace().collect();
        let record = parse_frame(&compact).unwrap_or_else(|error| panic!("{frame}: {error:?}"));
        self.record(record)
    }

    /// Decodes the next frame, with the time of the trace.
    pub fn record(&mut self, mut record: Record) -> Said {
        self.now += Duration(1_000_000);
        record.timestamp = self.now;
        record.channel = ChannelId(0);
        let decoded = self.network.handle(&record);
        let bus = self.network.bus(ChannelId(0)).expect("a bus once a frame was seen");
        let text = Meaning::new(&record, &decoded, bus).to_string();
        Said { decoded, text }
    }
}

impl Said {
    /// The service, by its name in JSON.
    pub fn service(&self) -> &'static str {
        self.decoded.service.name()
    }
}
