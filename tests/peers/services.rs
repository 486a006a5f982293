//! tshark dissects the same traffic: both must name the same service for every frame, except where tshark is known to
//! see less because it keeps no state. `docs/wireshark.md` explains each of these differences to users.

use canvass_analyzer::network::Network;
use canvass_analyzer::{Message, Service};
use canvass_traces::{CanId, ChannelId, Channels, ErrorClass, Format, Frame, Record, Timestamp, WriteOptions};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

const FRAMES: usize = 100_000;

/// A known difference: its heading in the page, and the frames that it covers.
struct Difference {
    title: &'static str,
    covers: fn(&Record, Service, &Message, &str) -> bool,
}

const DIFFERENCES: &[Difference] = &[
    Difference {
        title: "Guarding requests",
        covers: |record, ours, _, theirs| record.frame.is_remote() && ours == Service::Guarding && theirs == "can",
    },
    Difference {
        title: "Requests for PDOs",
        covers: |record, ours, _, theirs| record.frame.is_remote() && ours == Service::Pdo && theirs == "can",
    },
    Difference {
        title: "Guarding answers",
        covers: |_, ours, _, theirs| ours == Service::Guarding && theirs == "heartbeat",
    },
    Difference {
        title: "Flying master",
        covers: |record, ours, _, theirs| {
            ours == Service::FlyingMaster && (0x071..=0x076).contains(&record.frame.id().raw()) && theirs != "nmt"
        },
    },
    Difference {
        title: "Global fail-safe command and SRDOs",
        covers: |record, ours, _, theirs| ours == Service::Srdo && record.frame.id().raw() <= 0x180 && theirs != "nmt",
    },
    Difference {
        title: "Moved SDO channels",
        covers: |record, ours, _, theirs| {
            ours == Service::Sdo && matches!(record.frame.id().raw(), 0x1C1 | 0x241) && theirs == "pdo"
        },
    },
    Difference {
        title: "Moved PDOs",
        covers: |record, ours, _, theirs| match record.frame.id().raw() {
            0x10A => ours == Service::Pdo && theirs == "unknown",
            0x18A => ours == Service::Unknown && theirs == "pdo",
            _ => false,
        },
    },
    Difference {
        title: "Empty EMCY messages",
        covers: |record, ours, _, theirs| ours == Service::BootUp && record.frame.is_empty() && theirs == "malformed",
    },
    Difference { title: "LMT", covers: |_, ours, _, theirs| ours == Service::Lmt && theirs == "lss" },
    Difference {
        title: "Frames that are too short",
        covers: |_, _, message, theirs| matches!(message, Message::Malformed(..)) && theirs == "malformed",
    },
];

#[test]
fn the_same_service_for_every_frame() {
    let records = traffic();
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("services.pcap");
    write(&records, &path);
    let theirs = dissected(&path);
    assert_eq!(theirs.len(), records.len());
    let mut network = Network::new();
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for (record, theirs) in records.iter().zip(&theirs) {
        let decoded = network.handle(record);
        if decoded.service.name() == theirs {
            continue;
        }
        let known = DIFFERENCES.iter().find(|known| (known.covers)(record, decoded.service, &decoded.message, theirs));
        let Some(known) = known else {
            panic!("{}: canvass says {}, tshark says {theirs}", record.notation(), decoded.service);
        };
        *counts.entry(known.title).or_default() += 1;
    }
    let page = std::fs::read_to_string("docs/wireshark.md").unwrap();
    for Difference { title, .. } in DIFFERENCES {
        assert!(counts.contains_key(title), "{title}: does not occur any more, take it off the list");
        assert!(page.contains(&format!("| {title} |")), "docs/wireshark.md does not explain: {title}");
    }
}

fn write(records: &[Record], path: &Path) {
    let mut channels = Channels::new();
    channels.intern("can0");
    let sink = std::fs::File::create(path).unwrap();
    let mut writer = Format::Pcap.create(Box::new(sink), &WriteOptions::default()).unwrap();
    records.iter().for_each(|record| writer.write(record, &channels).unwrap());
    writer.finish().unwrap();
}

/// The services that tshark names, translated to the names of canvass.
fn dissected(path: &Path) -> Vec<String> {
    let output = Command::new("tshark")
        .args(["-n", "-d", "can.subdissector,canopen", "--disable-protocol", "autosar-nm", "-r"])
        .arg(path)
        .args(["-T", "fields", "-E", "separator=|", "-e", "_ws.col.Protocol", "-e", "_ws.col.Info"])
        .output()
        .unwrap();
    assert!(output.status.success(), "tshark: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).lines().map(|line| service(line).to_owned()).collect()
}

fn service(line: &str) -> &'static str {
    let (protocol, info) = line.split_once('|').unwrap_or((line, ""));
    let begins = |text: &str| info.starts_with(text);
    match protocol {
        _ if info.contains("Malformed Packet") => "malformed",
        "CAN" if begins("ERR") => "error-frame",
        "CAN" if begins("Ext. ID") => "unknown",
        "CAN" => "can",
        _ if begins("NMT Error Control: Boot-up") => "boot-up",
        _ if begins("NMT Error Control") => "heartbeat",
        _ if begins("NMT") => "nmt",
        _ if begins("SYNC") => "sync",
        _ if begins("TIME STAMP") => "time",
        _ if begins("EMCY") => "emcy",
        _ if begins("PDO") => "pdo",
        _ if begins("Default-SDO") => "sdo",
        _ if begins("LSS") => "lss",
        _ => "unknown",
    }
}

/// A bus with all kinds of CANopen traffic, again and again.
fn traffic() -> Vec<Record> {
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let mut frames: Vec<Frame> = opening();
    while frames.len() < FRAMES {
        let node = 1 + random.below(127) as u32;
        let payload = random.next().to_le_bytes();
        match random.below(40) {
            0..=13 => {
                frames.push(data([0x180, 0x280, 0x380, 0x480][random.below(4)] + node, &payload[..random.below(9)]));
            }
            14..=17 => {
                frames.push(data([0x200, 0x300, 0x400, 0x500][random.below(4)] + node, &payload[..random.below(9)]));
            }
            18..=21 => frames.push(data(0x700 + node, &[[0x00, 0x04, 0x05, 0x7F][random.below(4)]])),
            22 => frames.push(data(0x080, &payload[..random.below(2)])),
            23 => frames.push(data(0x100, &[payload[0], payload[1], 0, 0, payload[2], 0])),
            24 => frames.push(data(0x080 + node, &payload)),
            25 => frames.push(data(0x000, &[[1, 2, 0x80, 0x81, 0x82, 0x77][random.below(6)], node as u8])),
            26..=32 => frames.extend(read_of(node, payload)),
            33 => frames.push(data(0x580 + node, &[0x80, 0x00, 0x60, 0x00, 0x00, 0x00, 0x02, 0x06])),
            34 => frames.push(data(0x7E5, &[0x5E, 0, 0, 0, 0, 0, 0, 0])),
            35 => frames.push(data(0x600 + node, &[0xE0, 0, 0, 0, 0, 0, 0, 0])),
            36 => frames.push(Frame::new(CanId::extended_masked(payload[0].into()), &payload).unwrap()),
            37 => frames.push(Frame::error(ErrorClass(4), &[0, 8, 0, 0, 0, 0, 0, 0]).unwrap()),
            38 => frames.push(data(0x680 + node.min(0x5F), &payload)),
            _ => frames.push(data(0x10A, &payload)),
        }
    }
    frames.truncate(FRAMES);
    let at = |n: usize| Timestamp(1_700_000_000_000_000_000 + 200_000 * n as u64);
    frames.iter().enumerate().map(|(n, frame)| Record::new(at(n), ChannelId(0), *frame)).collect()
}

/// Frames whose order matters: COB-IDs that move, guarding, safety pairs, short frames.
fn opening() -> Vec<Frame> {
    let remote = |id| Frame::remote(CanId::standard_masked(id), 0).unwrap();
    let mut frames = vec![
        // A master guards node 90.
        remote(0x75A),
        data(0x75A, &[0x85]),
        remote(0x75A),
        data(0x75A, &[0x05]),
        remote(0x185),
        // A device before CiA 301 V4 starts.
        data(0x080 + 99, &[]),
        // Flying masters, the global fail-safe command, and SRDO pairs.
        data(0x071, &[0, 5]),
        data(0x072, &[]),
        data(0x001, &[]),
    ];
    for value in [0x01, 0x02] {
        frames.extend([data(0x103, &[value; 8]), data(0x104, &[!value; 8])]);
    }
    // Node 10's first TPDO moves to 10Ah; node 65 has a second SDO server on 241h and 1C1h.
    frames.extend(write_of(10, 0x1800, 1, 0x8000_018A));
    frames.extend(write_of(10, 0x1800, 1, 0x0000_010A));
    frames.push(data(0x10A, &[1, 2, 3, 4, 5, 6, 7, 8]));
    frames.extend(read_answered(65, 0x1201, 1, 0x241));
    frames.extend(read_answered(65, 0x1201, 2, 0x1C1));
    frames.push(data(0x241, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]));
    frames.push(data(0x1C1, &[0x43, 0, 0x10, 0, 0x96, 1, 2, 0]));
    // LMT inquires the manufacturer's name.
    frames.push(data(0x7E5, &[0x24, 0, 0, 0, 0, 0, 0, 0]));
    frames.push(data(0x7E4, &[0x24, b'T', b'R', b'-', b'E', b'L', b'E', b'C']));
    // A message that only LSS has switches back to LSS.
    frames.push(data(0x7E5, &[0x5A, 0, 0, 0, 0, 0, 0, 0]));
    frames.push(data(0x600 + 7, &[0x40, 0]));
    frames
}

fn data(id: u32, payload: &[u8]) -> Frame {
    Frame::new(CanId::standard_masked(id), payload).unwrap()
}

fn read_of(node: u32, payload: [u8; 8]) -> [Frame; 2] {
    read_answered(node, 0x6004, 0, u32::from_le_bytes([payload[0], payload[1], payload[2], payload[3]]))
}

fn read_answered(node: u32, index: u16, sub: u8, value: u32) -> [Frame; 2] {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = value.to_le_bytes();
    [data(0x600 + node, &[0x40, low, high, sub, 0, 0, 0, 0]), data(0x580 + node, &[0x43, low, high, sub, a, b, c, d])]
}

fn write_of(node: u32, index: u16, sub: u8, value: u32) -> [Frame; 2] {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = value.to_le_bytes();
    [data(0x600 + node, &[0x23, low, high, sub, a, b, c, d]), data(0x580 + node, &[0x60, low, high, sub, 0, 0, 0, 0])]
}

/// Random numbers that are the same in every run (xorshift64).
struct Random(u64);

impl Random {
    const fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    const fn below(&mut self, n: u64) -> usize {
        (self.next() % n) as usize
    }
}
