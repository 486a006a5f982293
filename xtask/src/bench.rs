//! How fast canvass is, beside its peers, measured in the same run on the same frames.

use crate::measure::{Cost, TIME, cost, machine, release};
use crate::packages::install;
use crate::peers::{PYTHON, install_all};
use crate::run::run;
use crate::simulation::simulation;
use anyhow::{Context, Result, bail};
use std::fs::{self, File};
use std::process::{Command, Stdio};

const FRAMES: u32 = 1_000_000;
/// Python is given the first of them only, as it is slow.
const FRAMES_FOR_PYTHON: u32 = 100_000;
const RUNS: usize = 3;
const READING_RUNS: &str = "15";

/// Measures and prints; nothing is asserted. Times are those of the processor, so that it matters little what else the
/// machine does.
pub fn bench() -> Result<()> {
    install(&[TIME])?;
    install_all()?;
    build()?;
    fs::create_dir_all("target/bench")?;
    for format in ["candump", "pcap", "pcapng", "mcap"] {
        let capture = File::create(capture(format))?;
        let written =
            Command::new(release("examples/traffic")).args([format, &FRAMES.to_string()]).stdout(capture).status()?;
        if !written.success() {
            bail!("the traffic could not be made: {written}");
        }
    }
    println!("machine: {}", machine());
    println!("{FRAMES} frames, best of {RUNS} runs, processor time");
    decoding()?;
    reading()?;
    simulation()
}

/// Builds what is measured, and what makes the traffic.
pub fn build() -> Result<()> {
    run("cargo", &["build", "--release", "--locked"])?;
    run("cargo", &["build", "--release", "--locked", "--package", "canvass-traces", "--examples"])
}

fn capture(format: &str) -> String {
    format!("target/bench/traffic.{format}")
}

/// One line of text for each frame.
fn decoding() -> Result<()> {
    println!("\ndecoding to a line per frame, output to /dev/null");
    let tshark = ["tshark", "-n", "-d", "can.subdissector,canopen", "-r", &capture("pcap")];
    let reference = rate(best(&tshark, None)?);
    println!("{:44} {reference:>6.2} M frames/s", "tshark (pcap)");
    let canvass = release("canvass");
    for (format, name) in [("text", "text"), ("json", "JSON")] {
        let ours = rate(best(&[&canvass, "decode", "--format", format, &capture("candump")], None)?);
        compare(&format!("canvass decode, {name} (candump log)"), ours, reference);
    }
    Ok(())
}

/// A format and who else reads it.
struct Reading {
    format: &'static str,
    peers: &'static [Peer],
}

enum Peer {
    /// A program that reads its standard input.
    Program(&'static str),
    /// tshark, showing one field.
    Tshark,
    /// A Python library, and an expression that gives frames out of the file `path`.
    Python(&'static str, &'static str),
}

const READING: [Reading; 4] = [
    Reading {
        format: "candump",
        peers: &[Peer::Program("log2long"), Peer::Python("python-can", "__import__('can').CanutilsLogReader(path)")],
    },
    Reading { format: "pcap", peers: &[Peer::Tshark] },
    Reading { format: "pcapng", peers: &[Peer::Tshark] },
    Reading {
        format: "mcap",
        peers: &[Peer::Python(
            "mcap (Python)",
            "make_reader(open(path, 'rb'), decoder_factories=[DecoderFactory()]).iter_decoded_messages()",
        )],
    },
];

/// To records, on one thread.
fn reading() -> Result<()> {
    println!("\nreading, one thread");
    for Reading { format, peers } in READING {
        let path = capture(format);
        let ours = reported(Command::new(release("examples/read_speed")).args([&path, READING_RUNS]))?;
        println!("{:44} {ours:>6.2} M frames/s", format!("{format}: canvass"));
        for peer in peers {
            let (name, theirs) = match peer {
                Peer::Program(name) => (*name, rate(best(&[name], Some(&path))?)),
                Peer::Tshark => {
                    let command = ["tshark", "-n", "-r", &path, "-T", "fields", "-e", "can.id"];
                    ("tshark -T fields", rate(best(&command, None)?))
                }
                Peer::Python(name, frames) => (*name, python(frames, &path)?),
            };
            println!(
                "{:44} {theirs:>6.2} M frames/s, canvass {:.1} times as fast",
                format!("{format}: {name}"),
                ours / theirs
            );
        }
    }
    Ok(())
}

fn python(frames: &str, path: &str) -> Result<f64> {
    let program = format!(
        "import itertools, sys, time\n\
         from mcap.reader import make_reader\n\
         from mcap_ros2.decoder import DecoderFactory\n\
         path, begin = sys.argv[1], time.process_time_ns()\n\
         count = sum(1 for _ in itertools.islice({frames}, {FRAMES_FOR_PYTHON}))\n\
         print(count, 0, time.process_time_ns() - begin)"
    );
    reported(Command::new(PYTHON).args(["-c", &program, path]))
}

/// The rate that a program reports as its number of frames, its number of damages, and its nanoseconds.
fn reported(command: &mut Command) -> Result<f64> {
    let output = command.stderr(Stdio::inherit()).output().with_context(|| format!("can't run {command:?}"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let numbers: Vec<f64> = text.split_whitespace().map_while(|word| word.parse().ok()).collect();
    match numbers[..] {
        [frames, 0.0, nanos] if frames > 0.0 => Ok(frames / nanos * 1e3),
        _ => bail!("{command:?} says {text}"),
    }
}

/// The cheapest of several runs.
fn best(command: &[&str], input: Option<&str>) -> Result<Cost> {
    let mut best: Option<Cost> = None;
    for _ in 0..RUNS {
        let input = input.map(File::open).transpose()?.map_or_else(Stdio::null, Stdio::from);
        let cost = cost(command, input)?;
        best = Some(best.filter(|best| best.cpu <= cost.cpu).unwrap_or(cost));
    }
    best.context("no run")
}

fn compare(name: &str, ours: f64, reference: f64) {
    println!("{name:44} {ours:>6.2} M frames/s, {:.1} times as fast", ours / reference);
}

/// In million frames per second.
fn rate(cost: Cost) -> f64 {
    f64::from(FRAMES) / cost.cpu / 1e6
}
