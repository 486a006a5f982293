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

/// The class bits of an error frame, each a field of its own.
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

/// What tshark sees in a capture, in the lines of [`Seen`].
fn dissected(path: &Path) -> Vec<String> {
    let mut args = vec!["--disable-protocol", "autosar-nm", "-T", "fields", "-E", "separator=|"];
    args.extend(FIELDS.iter().chain(&CLASSES).flat_map(|field| ["-e", field]));
    tshark(path, &args).lines().map(line).collect()
}

fn line(row: &str) -> String {
    let fields: Vec<&str> = row.split('|').collect();
    let (fields, classes) = fields.split_at(FIELDS.len());
    let [time, interface, direction, protocols, id, xtd, rtr, err, len, brs, esi, data] = fields else {
        panic!("{row}");
    };
    let (seconds, fraction) = time.split_once('.').unwrap();
    let id = u32::from_str_radix(id.trim_start_matches("0x"), 16).unwrap();
    let set = |flag: &str| flag == "1";
    let class: u32 = classes.iter().enumerate().map(|(bit, flag)| u32::from(set(flag)) << bit).sum();
    let id = match () {
        () if set(err) => format!("{:08X}", 0x2000_0000 | class),
        () if set(xtd) => format!("{id:08X}"),
        () => format!("{id:03X}"),
    };
    let is_fd = protocols.contains("canfd") || !brs.is_empty();
    let body = match () {
        () if is_fd => format!("#{:X}{}", 4 | u8::from(set(brs)) | u8::from(set(esi)) << 1, data.to_uppercase()),
        () if set(rtr) => format!("R{}", if *len == "0" { "" } else { len }),
        () => data.to_uppercase(),
    };
    let channel = if interface.is_empty() { "can0" } else { interface };
    let direction = match direction.trim_start_matches("0x").trim_start_matches('0') {
        "1" => " Rx",
        "2" => " Tx",
        _ => "",
    };
    format!("{seconds}{fraction} {channel} {id}#{body}{direction}")
}

fn reads(format: Format, losses: &[Kept]) {
    let name = format!("tshark reads {format}");
    Way { name: &name, losses, defects: &[] }.agrees(|path: &Path, frames: &[Seen]| {
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
