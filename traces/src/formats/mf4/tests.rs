//! Files that python-can does not write. Loggers write several channel groups into a data group, values of variable
//! length and constants, and do not finish a file when their supply is cut.

use crate::{Capture, Direction, Format, ReadOptions, Reader, Source, TimeBase};

/// A file, block after block.
struct File(Vec<u8>);

/// The offset of the first link of the header.
const FIRST_DATA_GROUP: usize = 64 + 24;
const HEADER_LINKS: usize = 6;
const SECOND: u64 = 1_000_000_000;

impl File {
    /// A file that has only its header; tests append the other blocks.
    fn new(signature: &[u8; 8], unfinished: u16) -> Self {
        let mut file =
            Self([signature, &b"4.10    canvass "[..], &[0; 36], &unfinished.to_le_bytes(), &[0; 2]].concat());
        let start = [&(1_700_000_000 * SECOND).to_le_bytes()[..], &[0; 24]].concat();
        assert_eq!(file.block(b"HD", &[0; HEADER_LINKS], &start), 64);
        file
    }

    fn block(&mut self, id: &[u8; 2], links: &[u64], data: &[u8]) -> u64 {
        let offset = self.0.len() as u64;
        let length = (24 + 8 * links.len() + data.len()) as u64;
        self.0.extend([b"##", &id[..], &[0; 4], &length.to_le_bytes(), &(links.len() as u64).to_le_bytes()].concat());
        links.iter().for_each(|link| self.0.extend(link.to_le_bytes()));
        self.0.extend(data);
        offset
    }

    /// A channel before `next`, with its values.
    fn channel(&mut self, next: u64, name: &str, kind: [u8; 4], byte: u32, bits: u32, values: u64) -> u64 {
        self.converted(next, name, kind, [byte, bits], [0, values])
    }

    /// A channel without a place in the record, whose value is a constant.
    fn constant(&mut self, next: u64, name: &str, value: f64) -> u64 {
        let conversion = self.conversion(1, &[value, 0.0]);
        self.converted(next, name, [6, 0, 0, 0], [0, 0], [conversion, 0])
    }

    fn conversion(&mut self, kind: u8, values: &[f64]) -> u64 {
        let head = [&[kind, 0, 0, 0, 0, 0][..], &(values.len() as u16).to_le_bytes(), &[0; 16]].concat();
        let values: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.block(b"CC", &[0; 4], &[head, values].concat())
    }

    /// A channel before `next`, with its conversion and its values.
    fn converted(
        &mut self,
        next: u64,
        name: &str,
        kind: [u8; 4],
        [byte, bits]: [u32; 2],
        [conversion, values]: [u64; 2],
    ) -> u64 {
        let text = [name.as_bytes(), &[0]].concat();
        let name = self.block(b"TX", &[], &text);
        let data = [&kind[..], &byte.to_le_bytes(), &bits.to_le_bytes(), &[0; 60]].concat();
        self.block(b"CN", &[next, 0, name, 0, conversion, values, 0, 0], &data)
    }

    fn group(&mut self, next: u64, channels: u64, id: u64, flags: u16, [count, length]: [u32; 2]) -> u64 {
        let head = [
            &id.to_le_bytes()[..],
            &u64::from(count).to_le_bytes(),
            &flags.to_le_bytes(),
            &[0; 6],
            &length.to_le_bytes(),
            &[0; 4],
        ];
        self.block(b"CG", &[next, channels, 0, 0, 0, 0], &head.concat())
    }

    /// The channels of data frames: time, identifier, length, and the place of the data among `values`.
    fn frame_channels(&mut self, values: u64) -> u64 {
        let data = self.channel(0, "CAN_DataFrame.DataBytes", [1, 0, 10, 0], 13, 64, values);
        let length = self.channel(data, "CAN_DataFrame.DataLength", [0, 0, 0, 0], 12, 8, 0);
        let id = self.channel(length, "CAN_DataFrame.ID", [0, 0, 0, 0], 8, 32, 0);
        self.channel(id, "Timestamp", [2, 1, 4, 0], 0, 64, 0)
    }

    fn data_group(&mut self, groups: u64, records: u64, width: u8) {
        let group = self.block(b"DG", &[0, groups, records, 0], &[width, 0, 0, 0, 0, 0, 0, 0]);
        self.0[FIRST_DATA_GROUP..FIRST_DATA_GROUP + 8].copy_from_slice(&group.to_le_bytes());
    }

    fn read(self) -> (Vec<String>, Vec<String>) {
        let mut capture = Capture::from_source("test", Source::from_bytes(self.0), &ReadOptions::default()).unwrap();
        assert_eq!(capture.format(), Format::Mf4);
        let (mut frames, mut damages) = (Vec::new(), Vec::new());
        for item in capture.by_ref() {
            match item {
                Ok(record) => frames.push(format!("{} {}", record.timestamp, record.frame)),
                Err(damage) => damages.push(damage.to_string()),
            }
        }
        assert_eq!(capture.time_base(), TimeBase::Utc);
        (frames, damages)
    }
}

fn record(seconds: f64, id: u32, length: u8, place: u64) -> Vec<u8> {
    [&seconds.to_le_bytes()[..], &id.to_le_bytes(), &[length], &place.to_le_bytes()].concat()
}

fn value(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes()[..], bytes].concat()
}

#[test]
fn values_of_variable_length_in_a_group_of_their_own() {
    let mut file = File::new(b"MDF     ", 0);
    let values = file.group(0, 0, 2, 1, [2, 0]);
    let channels = file.frame_channels(values);
    let frames = file.group(values, channels, 1, 2, [2, 21]);
    let records = [
        &[2][..],
        &value(&[0x40, 0, 0x10]),
        &[1],
        &record(1.0, 0x605, 3, 0),
        &[2],
        &value(&[5]),
        &[1],
        &record(0.5, 0x8000_0705, 1, 7),
    ];
    let records = file.block(b"DT", &[], &records.concat());
    file.data_group(frames, records, 1);
    let shown = ["1700000000.500000000 00000705#05".to_owned(), "1700000001.000000000 605#400010".to_owned()];
    let (frames, damages) = file.read();
    assert_eq!((frames, damages), (shown.to_vec(), Vec::new()), "in the order of time");
}

#[test]
fn values_of_variable_length_in_a_block() {
    let mut file = File::new(b"MDF     ", 0);
    let values = file.block(b"SD", &[], &[value(&[1, 2]), value(&[3])].concat());
    let list = file.block(b"DL", &[0, values], &[0; 24]);
    let channels = file.frame_channels(list);
    let frames = file.group(0, channels, 0, 2, [3, 21]);
    let records = [record(0.0, 0x181, 2, 0), record(0.1, 0x181, 1, 6), record(0.2, 0x181, 1, 99)];
    let records = file.block(b"DT", &[], &records.concat());
    file.data_group(frames, records, 0);
    let (frames, damages) = file.read();
    assert_eq!(frames, ["1700000000.000000000 181#0102", "1700000000.100000000 181#03"]);
    assert_eq!(damages.len(), 1, "{damages:?}");
    assert!(damages[0].contains("a place among the values") && damages[0].contains("99"), "{damages:?}");
}

/// Loggers have a group for each bus and kind of frames, so that bus, bits of the identifier, direction and CAN FD are
/// constants. The length is a table of the data length code.
#[test]
fn properties_that_all_records_of_a_group_share() {
    let mut file = File::new(b"MDF     ", 0);
    let values = file.block(b"SD", &[], &value(&[7; 12]));
    let mut channels = file.channel(0, "CAN_DataFrame.DataBytes", [1, 0, 10, 0], 13, 64, values);
    for (name, constant) in [("IDE", 1.0), ("EDL", 1.0), ("BRS", 0.0), ("Dir", 1.0), ("BusChannel", 2.0)] {
        channels = file.constant(channels, &format!("CAN_DataFrame.{name}"), constant);
    }
    let lengths = file.conversion(5, &[8.0, 8.0, 9.0, 12.0, 10.0, 16.0]);
    channels = file.converted(channels, "CAN_DataFrame.DataLength", [0; 4], [12, 8], [lengths, 0]);
    channels = file.channel(channels, "CAN_DataFrame.DLC", [0; 4], 12, 8, 0);
    channels = file.channel(channels, "CAN_DataFrame.ID", [0; 4], 8, 29, 0);
    channels = file.channel(channels, "t", [2, 1, 4, 0], 0, 64, 0);
    let frames = file.group(0, channels, 0, 2, [1, 21]);
    let records = file.block(b"DT", &[], &record(0.0, 0x123, 9, 0));
    file.data_group(frames, records, 0);
    let mut capture = Capture::from_source("test", Source::from_bytes(file.0), &ReadOptions::default()).unwrap();
    let record = capture.next().unwrap().unwrap();
    assert_eq!(record.frame.to_string(), "00000123##4070707070707070707070707");
    assert_eq!((record.direction, capture.channels().name(record.channel)), (Direction::Tx, "2"));
}

#[test]
fn a_file_that_was_not_finished_is_read_to_its_end() {
    let mut file = File::new(b"UnFinMF ", 4);
    let values = file.block(b"SD", &[], &value(&[7]));
    let channels = file.frame_channels(values);
    let frames = file.group(0, channels, 0, 2, [0, 21]);
    let records = file.0.len() as u64 + 64;
    file.data_group(frames, records, 0);
    assert_eq!(file.block(b"DT", &[], &[]), records);
    file.0.extend([record(0.0, 0x705, 1, 0), record(0.1, 0x705, 1, 0), vec![0; 5]].concat());
    let (frames, damages) = file.read();
    assert_eq!(frames, ["1700000000.000000000 705#07", "1700000000.100000000 705#07"]);
    assert!(damages.iter().any(|damage| damage.starts_with("unfinished file")), "{damages:?}");
}

#[test]
fn what_is_no_frame_is_told() {
    let mut signals = File::new(b"MDF     ", 0);
    let speed = signals.channel(0, "Speed", [0, 0, 0, 0], 8, 16, 0);
    let channels = signals.channel(speed, "t", [2, 1, 4, 0], 0, 64, 0);
    let group = signals.group(0, channels, 0, 0, [2, 10]);
    let records = signals.block(b"DT", &[], &[0; 20]);
    signals.data_group(group, records, 0);
    let (frames, damages) = signals.read();
    assert!(frames.is_empty());
    assert!(damages[0].contains("a group of CAN frames") && damages[0].contains("1 groups"), "{damages:?}");

    let mut unknown = File::new(b"MDF     ", 0);
    let channels = unknown.frame_channels(0);
    let group = unknown.group(0, channels, 1, 2, [0, 21]);
    let records = unknown.block(b"DT", &[], &[9, 0, 0]);
    unknown.data_group(group, records, 1);
    let (frames, damages) = unknown.read();
    assert!(frames.is_empty() && damages[0].contains("a record of a group that exists"), "{damages:?}");
}
