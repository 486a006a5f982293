//! Any frames in any order: each gets one line of text without control characters.
#![no_main]

use canvass_analyzer::{Meaning, network::Network};
use canvass_traces::{CanId, ChannelId, Frame, Record, Timestamp};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut network = Network::new();
    for (n, chunk) in (0_u64..).zip(bytes.chunks_exact(11)) {
        let id = CanId::standard_masked(u32::from(u16::from_le_bytes([chunk[0], chunk[1]])));
        let payload = &chunk[3..3 + usize::from(chunk[2] % 9)];
        let frame = if chunk[2] & 0x80 != 0 { Frame::remote(id, chunk[2] % 9) } else { Frame::new(id, payload) };
        let Some(frame) = frame else { continue };
        let record = Record::new(Timestamp(n * 1_000_000), ChannelId(0), frame);
        let decoded = network.handle(&record);
        if let Some(bus) = network.bus(record.channel) {
            let text = Meaning::new(&record, &decoded, bus).to_string();
            assert!(!text.is_empty() && !text.chars().any(char::is_control), "{text:?}");
        }
    }
});
