//! tshark: pcap and pcapng.

use crate::agreement::Way;
use crate::kept::*;
use crate::recording::{self, Seen};
use canvass_traces::{ChunkCompression, Format};
use std::path::Path;
use std::process::Command;

fn tshark(path: &Path, args: &[&str]) -> String {
    let mut command = Command::new("tshark");
    let output = command.arg("-n").arg("-r").arg(path).args(args).output();
    let output = output.unwrap_or_else(|error| panic!("tshark: {error}; cargo xtask ci installs it"));
    assert!(output.status.success(), "tshark: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

const FIELDS: [&str; 12] = [
    "frame.time_epoch",
    "frame.interface_name",
    "frame.packet_flags_direction",
    "frame.protocols",
    "can.id",
    "can.flags.xtd",
    "can.flags.rtr",
    "can.flags.err",
    "can.len",
    "canfd.flags.brs",
    "canfd.flags.esi",
    "data.data",
];

/// The class bits of an error frame, each with its own field in tshark.
const CLASSES: [&str; 9] = [
    "can.err.tx_timeout",
    "can.err.lostarb",
    "can.err.ctrl",
    "can.err.prot",
    "can.err.trx",
    "can.err.ack",
    "can.err.busoff",
    "can.err.buserror",
    "can.err.restarted",
];

/// The frames of a capture as tshark dissects them, in the lines of [`Seen`].
fn dissected(path: &Path) -> Vec<String> {
    let mut args = vec!["--disable-protocol", "autosar-nm", "-T", "fields", "-E", "separator=|"];
    args.extend(FIELDS.iter().chain(&CLASSES).flat_map(|field| ["-e", field]));
    let mut errors = error_bytes(path).into_iter();
    tshark(path, &args).lines().map(|row| line(row, &mut errors)).collect()
}

/// The bytes of all error frames, in hexadecimal: tshark dissects only the bytes to which the class gives a meaning.
fn error_bytes(path: &Path) -> Vec<String> {
    let packets = tshark(path, &["-Y", "can.flags.err == 1", "-T", "jsonraw", "-J", "frame", "-x"]);
    let packets: Vec<serde_json::Value> = serde_json::from_str(&packets).unwrap();
    let bytes = packets.iter().map(|packet| packet["_source"]["layers"]["frame_raw"][0].as_str().unwrap());
    bytes.map(|packet| packet[16..].to_uppercase()).collect()
}

fn line(row: &str, errors: &mut impl Iterator<Item = String>) -> String {
    let fields: Vec<&str> = row.split('|').collect();
    let (fields, classes) = fields.split_at(FIELDS.len());
    let [time, interface, direction, protocols, id, xtd, rtr, err, len, brs, esi, data] = fields else {
        panic!("{row}");
    };
    let (seconds, fraction) = time.split_once('.').unwrap();
    let set = |flag: &str| flag == "1";
    let id = || id.parse::<u32>().unwrap();
    let is_fd = protocols.contains("canfd") || !brs.is_empty();
    let flags = 4 | u8::from(set(brs)) | u8::from(set(esi)) << 1;
    let data = data.to_uppercase();
    let frame = match () {
        () if !is_fd && set(err) => {
            let class: u32 = classes.iter().enumerate().map(|(bit, flag)| u32::from(set(flag)) << bit).sum();
            format!("{:08X}#{}", 0x2000_0000 | class, errors.next().unwrap())
        }
        () if set(xtd) => format!("{:08X}#", id()),
        () => format!("{:03X}#", id()),
    };
    let body = match () {
        () if is_fd => format!("#{flags:X}{data}"),
        () if set(err) => String::new(),
        () if set(rtr) => format!("R{}", if *len == "0" { "" } else { len }),
        () => data,
    };
    let channel = if interface.is_empty() { "can0" } else { interface };
    let direction = match direction.trim_start_matches("0x").trim_start_matches('0') {
        "1" => " Rx",
        "2" => " Tx",
        _ => "",
    };
    format!("{seconds}{fraction} {channel} {frame}{body}{direction}")
}

fn reads(format: Format, losses: &[Kept]) {
    let name = format!("tshark reads {format}");
    Way { name: &name, before: &[], losses, defects: &[] }.agrees(|path: &Path, frames: &[Seen]| {
        recording::write(path, format, ChunkCompression::None, frames);
        Ok(dissected(path))
    });
}

#[test]
fn tshark_reads_pcap() {
    reads(Format::Pcap, &[one_channel, no_direction]);
}

#[test]
fn tshark_reads_pcapng() {
    reads(Format::Pcapng, &[]);
}

/// tshark rewrites a pcapng file in another format.
fn writes(kind: &str, format: Format, before: &[Kept], losses: &[Kept]) {
    let name = format!("tshark writes {kind}");
    Way { name: &name, before, losses, defects: &[] }.agrees(|path: &Path, frames: &[Seen]| {
        let (from, to) = (path.with_extension("from"), path.with_extension("to"));
        recording::write(&from, Format::Pcapng, ChunkCompression::None, frames);
        tshark(&from, &["-F", kind, "-w", to.to_str().unwrap()]);
        recording::read(&to, format)
    });
}

/// As [`writes`], for formats with one channel only.
fn one_channel_writes(kind: &str, format: Format, before: &[Kept]) {
    writes(kind, format, before, &[no_direction]);
}

#[test]
fn tshark_writes_pcap() {
    one_channel_writes("pcap", Format::Pcap, &[one_channel, micros]);
    one_channel_writes("nsecpcap", Format::Pcap, &[one_channel]);
}

#[test]
fn tshark_writes_pcapng() {
    writes("pcapng", Format::Pcapng, &[], &[]);
}
