//! How fast canvass is, beside its peers, measured in the same run on the same frames.

use crate::packages::{Package, install};
use crate::run::run;
use anyhow::{Context, Result, ensure};
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const FRAMES: u64 = 1_000_000;
const RUNS: usize = 3;

/// Measures and prints; nothing is asserted.
pub fn bench() -> Result<()> {
    install(&[Package { program: "tshark", probe: "--version", package: "tshark" }])?;
    run("cargo", &["build", "--release", "--locked"])?;
    let folder = PathBuf::from("target/bench");
    fs::create_dir_all(&folder)?;
    let capture = Capture::write(&folder)?;
    println!("machine: {}", machine());
    println!("{FRAMES} frames, best of {RUNS} runs, output to /dev/null");
    let canvass = |format| vec!["target/release/canvass", "decode", "--format", format, capture.log()];
    let tshark = ["tshark", "-n", "-d", "can.subdissector,canopen", "-r", capture.pcap()];
    let reference = measure("tshark, one line per frame (pcap)", &tshark)?;
    compare("canvass decode, text (candump log)", &canvass("text"), reference)?;
    compare("canvass decode, JSON (candump log)", &canvass("json"), reference)?;
    Ok(())
}

/// The same frames as a candump log and as pcap.
struct Capture {
    log: String,
    pcap: String,
}

impl Capture {
    fn write(folder: &Path) -> Result<Self> {
        let path = |name: &str| folder.join(name).to_string_lossy().into_owned();
        let capture = Self { log: path("traffic.log"), pcap: path("traffic.pcap") };
        let mut log = BufWriter::new(File::create(&capture.log)?);
        let mut pcap = BufWriter::new(File::create(&capture.pcap)?);
        // Nanosecond pcap, big-endian fields would do as well; link type 227 is SocketCAN.
        for word in [0xA1B2_3C4D_u32, 0x0004_0002, 0, 0, 0x40000, 227] {
            pcap.write_all(&word.to_le_bytes())?;
        }
        let mut traffic = Traffic::new();
        for _ in 0..FRAMES {
            let (time_us, id, data) = traffic.next_frame();
            let hex: String = data.iter().map(|byte| format!("{byte:02X}")).collect();
            writeln!(log, "({}.{:06}) can0 {id:03X}#{hex}", time_us / 1_000_000, time_us % 1_000_000)?;
            write_packet(&mut pcap, time_us, id, &data)?;
        }
        log.flush()?;
        pcap.flush()?;
        Ok(capture)
    }

    fn log(&self) -> &str {
        &self.log
    }

    fn pcap(&self) -> &str {
        &self.pcap
    }
}

fn write_packet(pcap: &mut impl Write, time_us: u64, id: u16, data: &[u8]) -> std::io::Result<()> {
    let seconds = (time_us / 1_000_000) as u32;
    let nanos = (time_us % 1_000_000 * 1000) as u32;
    for word in [seconds, nanos, 16, 16] {
        pcap.write_all(&word.to_le_bytes())?;
    }
    let mut packet = [0; 16];
    packet[..4].copy_from_slice(&u32::from(id).to_be_bytes());
    packet[4] = data.len() as u8;
    packet[8..8 + data.len()].copy_from_slice(data);
    pcap.write_all(&packet)
}

/// An eight-node bus as machines have it: mostly PDOs, then SDO dialogues, heartbeats and SYNC.
struct Traffic {
    random: u64,
    time_us: u64,
    pending: Option<(u16, Vec<u8>)>,
}

impl Traffic {
    const fn new() -> Self {
        Self { random: 0x2545_F491_4F6C_DD1D, time_us: 1_700_000_000_000_000, pending: None }
    }

    /// xorshift64: repeatable, and enough for traffic.
    const fn random(&mut self) -> u64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        self.random
    }

    fn next_frame(&mut self) -> (u64, u16, Vec<u8>) {
        self.time_us += 100 + self.random() % 800;
        let (id, data) = self.pending.take().unwrap_or_else(|| self.fresh_frame());
        (self.time_us, id, data)
    }

    fn fresh_frame(&mut self) -> (u16, Vec<u8>) {
        let node = (self.random() % 8 + 1) as u16;
        let payload = self.random().to_le_bytes();
        match self.random() % 100 {
            0..60 => (0x180 + node, payload.to_vec()),
            60..72 => (0x280 + node, payload[..4].to_vec()),
            72..80 => (0x700 + node, vec![0x05]),
            80..86 => (0x080, Vec::new()),
            _ => {
                self.pending = Some((0x580 + node, vec![0x43, 0x04, 0x60, 0, payload[0], payload[1], 0, 0]));
                (0x600 + node, vec![0x40, 0x04, 0x60, 0, 0, 0, 0, 0])
            }
        }
    }
}

/// The best time of several runs.
fn best(command: &[&str]) -> Result<Duration> {
    let mut best = Duration::MAX;
    for _ in 0..RUNS {
        let begin = Instant::now();
        let status = Command::new(command[0])
            .args(&command[1..])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .with_context(|| format!("can't run {}", command[0]))?;
        ensure!(status.success(), "{} ended with {status}", command.join(" "));
        best = best.min(begin.elapsed());
    }
    Ok(best)
}

fn measure(name: &str, command: &[&str]) -> Result<Duration> {
    let time = best(command)?;
    println!("{name:40} {:>8.3} s  {:>6.2} M frames/s", time.as_secs_f64(), rate(time));
    Ok(time)
}

fn compare(name: &str, command: &[&str], reference: Duration) -> Result<()> {
    let time = best(command)?;
    let ratio = reference.as_secs_f64() / time.as_secs_f64();
    println!("{name:40} {:>8.3} s  {:>6.2} M frames/s  {ratio:>6.1} times as fast", time.as_secs_f64(), rate(time));
    Ok(())
}

fn rate(time: Duration) -> f64 {
    FRAMES as f64 / time.as_secs_f64() / 1e6
}

/// The processor and how many of it there are.
fn machine() -> String {
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|line| line.strip_prefix("model name")).unwrap_or(" unknown processor");
    let cores = info.lines().filter(|line| line.starts_with("processor")).count();
    format!("{}, {cores} cores", model.trim_start_matches(['\t', ':', ' ']))
}
