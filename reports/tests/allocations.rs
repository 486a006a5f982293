//! In steady state the decoder allocates no memory for a frame, from the capture's bytes to the line.

#[cfg(test)]
mod steady_state {
    use canvass_analyzer::network::Network;
    use canvass_analyzer::{Meaning, NodeId};
    use canvass_device::models::Model;
    use canvass_reports::decode::{CsvLines, JsonLines, Line, Lines, TableLines, TextLines, TimeStyle};
    use canvass_traces::{Capture, ReadOptions, Reader, Source};
    use std::fmt::Write;
    use std::io::Cursor;

    /// Process data, heartbeats, SYNC, EMCY and expedited transfers of two nodes, one of them described.
    const CYCLE: &str = "\
080#
1BF#BA4C0000
3BF#1000
181#0102030405060708
73F#05
701#05
63F#4004600000000000
5BF#43046000BA4C0000
63F#2B17100064000000
5BF#6017100000000000
63F#40005000AABBCCDD
5BF#8000500000000206
63F#4050210000000000
5BF#4B50210003010000
0BF#1043200900000000
0BF#0000000000000000
";

    /// Number of cycles until all buffers have their final size.
    const WARM_UP: usize = 8;
    const COUNTED: usize = 100;

    fn capture() -> Vec<u8> {
        let mut log = String::new();
        let frames = std::iter::repeat_n(CYCLE, WARM_UP + COUNTED).flat_map(str::lines);
        for (n, frame) in frames.enumerate() {
            writeln!(log, "(1738061235.{n:06}) can0 {frame}").unwrap();
        }
        log.into_bytes()
    }

    fn allocations(mut lines: impl Lines) -> u64 {
        let model = Model::by_id("kuebler-sendix-58x8").unwrap();
        let mut network = Network::new();
        network.describe(NodeId::new(63).unwrap(), canvass_analyzer::dictionary::KnownDevice::clone(model.device()));
        let source = Source::new(Cursor::new(capture()));
        let mut capture = Capture::from_source("test", source, &ReadOptions::default()).unwrap();
        let mut out = Vec::new();
        let mut frames = |n: usize| {
            for _ in 0..n {
                let record = capture.next().unwrap().unwrap();
                let decoded = network.handle(&record);
                let bus = network.bus(record.channel).unwrap();
                let meaning = Meaning::new(&record, &decoded, bus);
                out.clear();
                lines.line(
                    &Line { record: &record, channels: capture.channels(), decoded: &decoded, meaning },
                    &mut out,
                );
            }
        };
        let cycle = CYCLE.lines().count();
        frames(WARM_UP * cycle);
        allocation_counter::measure(|| frames(COUNTED * cycle)).count_total
    }

    /// The counter counts allocations.
    #[test]
    fn an_allocation_is_seen() {
        let counted = allocation_counter::measure(|| drop(std::hint::black_box(vec![1_u8])));
        assert_eq!(counted.count_total, 1);
    }

    #[test]
    fn text_lines_allocate_nothing() {
        assert_eq!(allocations(TextLines::new(TimeStyle::Absolute, true)), 0);
        assert_eq!(allocations(TextLines::new(TimeStyle::Utc, false)), 0);
    }

    #[test]
    fn json_lines_allocate_nothing() {
        assert_eq!(allocations(JsonLines::new()), 0);
    }

    #[test]
    fn rows_allocate_nothing() {
        assert_eq!(allocations(CsvLines::new(TimeStyle::Absolute)), 0);
        assert_eq!(allocations(TableLines::new(TimeStyle::Relative, false, Some(100))), 0);
    }
}
