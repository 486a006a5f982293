//! Fuzz targets for all readers of foreign bytes. No input may make a reader panic, and each refusal must have a
//! message. `CANVASS_FUZZ_TARGET=TARGET cargo +nightly fuzz run --fuzz-dir fuzz-targets reader` fuzzes one with coverage
//! feedback; without a target the program lists them. A test of the workspace feeds random and mutated real inputs to
//! the readers with every toolchain.

use canvass_analyzer::dictionary::DeviceDescription;
use canvass_analyzer::filter::Filter;
use canvass_analyzer::{Meaning, NodeId, network::Network};
use canvass_bus::slcan::{Decoder, Message, write_frame};
use canvass_device::MotionSpec;
use canvass_device::models::Model;
use canvass_fuzzer::reproducer;
use canvass_suite::waiver::Waivers;
use canvass_traces::{CanId, Capture, ChannelId, Format, Frame, ReadOptions, Record, Source, Timestamp};

/// A reader of foreign bytes.
#[derive(Clone, Copy)]
pub struct Target {
    /// Its name; for a capture format the id of the format.
    pub name: &'static str,
    reader: Reader,
    /// The folders of real inputs, beside its own.
    seeds: &'static [&'static str],
}

#[derive(Clone, Copy)]
enum Reader {
    /// Of captures, read as this format.
    Capture(Format),
    /// Of anything else.
    Other(fn(&[u8])),
}

impl Target {
    /// Reads the bytes.
    pub fn read(&self, bytes: &[u8]) {
        match self.reader {
            Reader::Capture(format) => read(bytes, Some(format)),
            Reader::Other(read) => read(bytes),
        }
    }

    /// The folders of real inputs, from the root of the repository: those of other tests, and its own if there is one.
    pub fn seeds(&self) -> Vec<String> {
        let own = format!("fuzz-targets/seeds/{}", self.name);
        self.seeds.iter().map(|&folder| folder.to_owned()).chain([own]).collect()
    }
}

/// The folder of captures of every format.
pub const SAMPLES: &str = "traces/samples";

/// The readers that are not of one capture format.
const OTHERS: &[Target] = &[
    other("capture", capture, &[SAMPLES]),
    other("wire", wire, &[]),
    other("description", description, &["analyzer/tests/eds", "conformance/device/models"]),
    other("filter", filter, &[]),
    other("waivers", waivers, &[]),
    other("model", model, &["conformance/device/models"]),
    other("slcan", slcan, &[]),
    other("reproducer", reproducer, &[SAMPLES]),
    other("motion", motion, &[]),
];

const fn other(name: &'static str, read: fn(&[u8]), seeds: &'static [&'static str]) -> Target {
    Target { name, reader: Reader::Other(read), seeds }
}

/// All readers: one for each capture format, and the others.
pub fn targets() -> Vec<Target> {
    let capture = |format: Format| Target { name: format.id(), reader: Reader::Capture(format), seeds: &[SAMPLES] };
    Format::all().map(capture).chain(OTHERS.iter().copied()).collect()
}

fn read(bytes: &[u8], format: Option<Format>) {
    let options = ReadOptions { format, ..ReadOptions::default() };
    let Ok(capture) = Capture::from_source("fuzz", Source::from_bytes(bytes), &options) else { return };
    for item in capture {
        if let Err(damage) = item {
            assert!(!damage.to_string().is_empty());
        }
    }
}

/// Captures of every format, recognised by their content, also compressed.
fn capture(bytes: &[u8]) {
    read(bytes, None);
}

/// Any frames in any order: each gets one line of text without control characters.
fn wire(bytes: &[u8]) {
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
}

/// Device descriptions: EDS, DCF, XDD and XDC.
fn description(bytes: &[u8]) {
    if let Ok(description) = DeviceDescription::read(bytes) {
        for problem in &description.problems {
            assert!(!problem.to_string().is_empty());
        }
    }
}

/// Filter expressions.
fn filter(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Err(error) = text.parse::<Filter>() {
        assert!(error.column <= text.chars().count() + 1);
        assert!(!error.to_string().is_empty());
    }
}

/// Files of waivers.
fn waivers(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match Waivers::read(text) {
        Ok(waivers) => drop(waivers.deviations("2026-01-01")),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// The two files of a model: the bytes before the first NUL are its sheet, the bytes after it are its EDS. All bytes
/// together are also read as the EDS of a device without sheet.
fn model(bytes: &[u8]) {
    let end = bytes.iter().position(|&byte| byte == 0);
    let (sheet, eds) = bytes.split_at(end.unwrap_or(0));
    if let (Ok(sheet), Ok(eds)) = (std::str::from_utf8(sheet), std::str::from_utf8(eds)) {
        // A sheet alone is judged, too: the empty EDS is refused only after it.
        if let Err(error) = Model::read(eds.trim_start_matches('\0'), sheet) {
            assert!(!error.to_string().is_empty());
        }
    }
    if let Err(error) = Model::generic("fuzz", bytes) {
        assert!(!error.to_string().is_empty());
    }
}

/// The output of an SLCAN adapter, in pieces of any length. Each frame that is understood can be written and read
/// again.
fn slcan(bytes: &[u8]) {
    let mut decoder = Decoder::default();
    let cut = bytes.first().map_or(0, |&byte| usize::from(byte)).min(bytes.len());
    let (head, tail) = bytes.split_at(cut);
    for piece in [head, tail] {
        decoder.push(piece, |message| {
            let Message::Frame { record, .. } = message else { return };
            let mut line = Vec::new();
            if write_frame(&record, &mut line).is_none() {
                return;
            }
            let mut again = None;
            Decoder::default().push(&line, |message| again = Some(message));
            let frame = record.frame;
            assert!(
                matches!(&again, Some(Message::Frame { record: read, .. }) if read.frame == frame),
                "{frame} is written as {line:?}"
            );
        });
    }
}

/// Reproducers of the fuzzer, and captures to replay.
fn reproducer(bytes: &[u8]) {
    match reproducer::read(bytes, NodeId::MIN) {
        Ok(sequences) => {
            for sequence in &sequences {
                // A sequence that was read can be written and read again.
                let again = reproducer::read(reproducer::candump(sequence).as_bytes(), NodeId::MIN);
                assert!(again.is_ok() || sequence.stimuli.iter().any(|stimulus| stimulus.frame.len() > 8), "{again:?}");
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// The points of a motion.
fn motion(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Err(error) = MotionSpec::from_csv(text) {
        assert!(!error.to_string().is_empty());
    }
    if let Err(error) = text.parse::<MotionSpec>() {
        assert!(!error.to_string().is_empty());
    }
}
