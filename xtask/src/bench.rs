//! Measures the speed of canvass and of other programs, in the same run on the same frames.

use crate::measure::{Cost, RUNS, TIME, best, best_of, machine, release};
use crate::packages::{Package, install};
use crate::peers::{PYTHON, install_all};
use crate::run::run;
use crate::simulation::{build_examples, simulation};
use anyhow::{Context, Result, bail};
use std::fs::{self, File};
use std::process::{Command, Stdio};

const FRAMES: u32 = 1_000_000;
/// Number of frames for Python, which is slow.
const FRAMES_FOR_PYTHON: u32 = 100_000;
const READING_RUNS: &str = "15";
/// Number of runs for tshark's JSON, which takes most of a minute.
const SLOW_RUNS: usize = 1;
/// Instructions are counted for few and for many frames; the difference excludes the start of the program.
const COUNTED: (u32, u32) = (20_000, 120_000);
/// Numbers of exchanges with simulated devices for which instructions are counted.
const EXCHANGED: (u32, u32) = (10_000, 60_000);
/// Numbers of exchanges of the fuzzer for which instructions are counted.
const FUZZED: (u32, u32) = (20_000, 60_000);

const RIPGREP: Package = Package { program: "rg", probe: &["--version"], package: "ripgrep" };
const VALGRIND: Package = Package { program: "valgrind", probe: &["--version"], package: "valgrind" };

/// Measures and prints; nothing is asserted. Processor time is measured, so other work of the machine matters little.
pub fn bench() -> Result<()> {
    install(&[TIME, RIPGREP])?;
    install_all()?;
    build()?;
    fs::create_dir_all("target/bench")?;
    for format in ["candump", "pcap", "pcapng", "mcap"] {
        make(format, FRAMES, &capture(format))?;
    }
    println!("machine: {}", machine());
    println!("{FRAMES} frames, best of {RUNS} runs, processor time");
    decoding()?;
    crate::diagnosing::diagnosing()?;
    reading()?;
    crate::describing::describing()?;
    simulation()
}

/// Measures only device descriptions.
pub fn descriptions() -> Result<()> {
    install(&[TIME])?;
    build()?;
    fs::create_dir_all("target/bench")?;
    println!("machine: {}", machine());
    crate::describing::describing()
}

/// Counts the instructions per decoded frame and per simulated exchange by callgrind. The numbers depend neither on the
/// load of the machine nor, within an architecture, on the machine.
pub fn instructions() -> Result<()> {
    install(&[VALGRIND])?;
    build()?;
    fs::create_dir_all("target/bench")?;
    let (few, many) = COUNTED;
    let captures = [few, many].map(|frames| (frames, format!("target/bench/traffic-{frames}.candump")));
    for (frames, path) in &captures {
        make("candump", *frames, path)?;
    }
    println!("instructions per frame (valgrind --tool=callgrind), candump log to /dev/null");
    let canvass = release("canvass");
    let to_pcapng: &[&str] = &["convert", "--force", "--to", "pcapng"];
    let commands: [(&[&str], Option<&str>); 6] = [
        (&["decode", "--format", "text"], None),
        (&["decode", "--format", "json"], None),
        (&["decode", "--format", "csv"], None),
        (&["decode", "--events"], None),
        (&["diagnose", "--fail-on", "never"], None),
        (to_pcapng, Some("/dev/null")),
    ];
    for (args, out) in commands {
        let count = |path: &str| counted(&[&[&*canvass], args, &[path], out.as_slice()].concat());
        let counts = (count(&captures[0].1)?, count(&captures[1].1)?);
        let each = |of: fn(Counted) -> u64| of(counts.1).saturating_sub(of(counts.0)) / u64::from(many - few);
        let beside = match each(|counted| counted.beside) {
            0 => String::new(),
            // valgrind does not support the processor's instructions for SHA-256.
            more => format!("  and {more} in another thread, for the SHA-256 of the capture"),
        };
        println!("canvass {:32} {:>8}{beside}", args.join(" "), each(|counted| counted.first));
    }
    simulated_instructions()
}

/// Counts instructions of the examples that exchange SDO messages with simulated devices. `bus_speed` exchanges them
/// with one device, and a tenth as many with one of ten devices; `soak` fuzzes with a fixed seed.
fn simulated_instructions() -> Result<()> {
    build_examples()?;
    println!("\ninstructions per exchange on the simulated bus");
    let soak = |target: &'static str| {
        move |exchanges: &str| {
            ["soak", "models", exchanges, "1", target, "-", "reference-301"].map(str::to_owned).to_vec()
        }
    };
    simulated("bus_speed", EXCHANGED, |exchanges| vec!["bus_speed".to_owned(), exchanges.to_owned()])?;
    for target in ["all", "sdo", "lss"] {
        simulated(&format!("fuzzing {target}"), FUZZED, soak(target))?;
    }
    Ok(())
}

/// Counts and prints the instructions of an example with its arguments, for two numbers of exchanges.
fn simulated(name: &str, (few, many): (u32, u32), command: impl Fn(&str) -> Vec<String>) -> Result<()> {
    let count = |exchanges: u32| {
        let words = command(&exchanges.to_string());
        let example = words.first().map_or_else(String::new, |name| release(&format!("examples/{name}")));
        let rest = words.iter().skip(1).map(String::as_str);
        counted(&std::iter::once(example.as_str()).chain(rest).collect::<Vec<_>>())
    };
    println!("{name:40} {:>8}", (count(many)?.first - count(few)?.first) / u64::from(many - few));
    Ok(())
}

/// The number of instructions of a whole run.
#[derive(Clone, Copy, Default)]
struct Counted {
    /// Instructions of the thread that reads the frames.
    first: u64,
    /// Instructions of all other threads.
    beside: u64,
}

/// Counts instructions: callgrind writes a file for each thread, `<file>-01` and on.
fn counted(command: &[&str]) -> Result<Counted> {
    let of_thread = |number: usize| format!("target/bench/callgrind.out-{number:02}");
    // Files of an earlier run with more threads would be counted, too.
    (1..).map(of_thread).take_while(|path| fs::remove_file(path).is_ok()).for_each(drop);
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--separate-threads=yes", "--callgrind-out-file=target/bench/callgrind.out"])
        .args(command)
        .stdout(Stdio::null())
        .output()
        .context("can't run valgrind")?;
    let written = (1..).map_while(|number| fs::read_to_string(of_thread(number)).ok());
    let threads: Vec<u64> = written.filter_map(|written| total(&written)).collect();
    let Some((&first, others)) = threads.split_first() else {
        bail!("{} under valgrind says {}", command.join(" "), String::from_utf8_lossy(&output.stderr));
    };
    Ok(Counted { first, beside: others.iter().sum() })
}

/// The total in a file of callgrind.
fn total(written: &str) -> Option<u64> {
    written.lines().find_map(|line| line.strip_prefix("totals:"))?.trim().parse().ok()
}

/// Makes a capture with this number of frames of usual traffic.
pub fn make(format: &str, frames: u32, path: &str) -> Result<()> {
    let capture = File::create(path)?;
    let written =
        Command::new(release("examples/traffic")).args([format, &frames.to_string()]).stdout(capture).status()?;
    if !written.success() {
        bail!("making the traffic failed: {written}");
    }
    Ok(())
}

/// Builds the measured programs, and the program that makes the traffic.
pub fn build() -> Result<()> {
    run("cargo", &["build", "--release", "--locked"])?;
    run("cargo", &["build", "--release", "--locked", "--package", "canvass-traces", "--examples"])
}

pub fn capture(format: &str) -> String {
    format!("target/bench/traffic.{format}")
}

/// Decoding to one line per frame, compared with tshark, and with the time for merely finding lines.
fn decoding() -> Result<()> {
    println!("\ndecoding to a line per frame, output to /dev/null");
    let (log, pcap, canvass) = (capture("candump"), capture("pcap"), release("canvass"));
    let dissect = ["tshark", "-n", "-d", "can.subdissector,canopen", "-r", &pcap];
    let json = [&dissect[..], &["-T", "ek"]].concat();
    for (format, peer, command, runs) in
        [("text", "tshark", &dissect[..], RUNS), ("json", "tshark -T ek", &json[..], SLOW_RUNS)]
    {
        let theirs = rate(best_of(runs, command, None)?);
        println!("{:44} {theirs:>6.2} M frames/s", format!("{peer} (pcap)"));
        let ours = rate(best(&[&canvass, "decode", "--format", format, &log], None)?);
        compare(&format!("canvass decode --format {format} (candump log)"), ours, theirs);
    }
    let lines = rate(best(&["rg", "-c", "", &log], None)?);
    println!("{:44} {lines:>6.2} M lines/s", "rg -c '' (candump log)");
    let ours = rate(best(&[&canvass, "decode", "--format", "text", &log], None)?);
    println!("{:44} {ours:>6.2} M frames/s, {:.1} times the time of rg", "canvass decode --format text", lines / ours);
    Ok(())
}

/// A format and the programs that read it.
struct Reading {
    format: &'static str,
    peers: &'static [Peer],
}

enum Peer {
    /// A program that reads standard input.
    Program(&'static str),
    /// tshark, printing one field.
    Tshark,
    /// A Python library, and an expression for the frames of the file `path`.
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

/// Reading to records, on one thread.
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

/// The rate from a program's output: number of frames, number of damages, nanoseconds.
fn reported(command: &mut Command) -> Result<f64> {
    let output = command.stderr(Stdio::inherit()).output().with_context(|| format!("can't run {command:?}"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let numbers: Vec<f64> = text.split_whitespace().map_while(|word| word.parse().ok()).collect();
    match numbers[..] {
        [frames, 0.0, nanos] if frames > 0.0 => Ok(frames / nanos * 1e3),
        _ => bail!("{command:?} says {text}"),
    }
}

fn compare(name: &str, ours: f64, reference: f64) {
    println!("{name:44} {ours:>6.2} M frames/s, {:.1} times as fast", ours / reference);
}

/// The rate in million frames per second.
fn rate(cost: Cost) -> f64 {
    f64::from(FRAMES) / cost.cpu / 1e6
}
