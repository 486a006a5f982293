//! `cargo xtask bench --fleet`: the speed of queries on captures and lakes, compared with the program, DuckDB and
//! python-can with pandas.

use super::cluster::{Cluster, asked};
use super::readers::{PYTHON, VENV};
use crate::bench::{build, make};
use crate::measure::{TIME, best, machine, release};
use crate::packages::install;
use anyhow::{Context, Result, ensure};
use std::fs;
use std::process::{Command, Stdio};
use std::time::Instant;

const FLEET: &str = "fleet/target/release/canvass-fleet";
/// Number of frames of each capture.
const FRAMES: u32 = 1_000_000;
/// Number of captures for python-can, which is slow.
const CAPTURES: u32 = 4;
const FOLDER: &str = "target/bench/fleet";
/// The device of the nodes, so that their process data have names.
const DEVICE: &str = "1..127=kuebler-sendix-58x8";
/// Number of repetitions on a cluster.
const TIMES: u32 = 8;
/// Numbers of short captures, to measure how the cost grows.
const MANY: [u32; 3] = [10, 100, 1000];
const FRAMES_OF_SHORT: u32 = 1000;

/// Queries whose filters reject most frames.
const FILTERS: [(&str, &str); 8] = [
    ("a node and an object", "SELECT t, meaning FROM messages('FILES') WHERE node = 5 AND index = 24580"),
    ("an object", "SELECT t, meaning FROM messages('FILES') WHERE index = 24580"),
    ("a node", "SELECT t, meaning FROM messages('FILES') WHERE node = 5"),
    ("a service", "SELECT t, meaning FROM messages('FILES') WHERE service = 'emcy'"),
    ("a CAN-ID", "SELECT t, meaning FROM messages('FILES') WHERE can_id = 389"),
    ("a CAN-ID, not decoded", "SELECT t, data FROM frames('FILES') WHERE can_id = 389"),
    ("events of a node", "SELECT t, event FROM events('FILES') WHERE node = 5"),
    ("a signal of a node", "SELECT t, value FROM signals('FILES') WHERE node = 5 AND index = 24580"),
];

/// Queries on a lake, for canvass-fleet and for DuckDB.
const QUESTIONS: [(&str, &str); 4] = [
    ("frames by service", "SELECT service, count(*) FROM messages GROUP BY service"),
    ("frames of a node", "SELECT count(*) FROM messages WHERE node = 5 AND service = 'pdo'"),
    ("mean by signal", "SELECT node, name, avg(value), max(value) FROM signals GROUP BY node, name"),
    ("slowest transfers", "SELECT node, max(duration_ns) FROM events WHERE event = 'sdo' GROUP BY node ORDER BY node"),
];

const DUCKDB: &str = "import sys, duckdb
for table in ('messages', 'signals', 'events'):
    duckdb.sql(f\"CREATE VIEW {table} AS SELECT * FROM read_parquet('{sys.argv[1]}/{table}/*/*.parquet', hive_partitioning=true)\")
duckdb.sql(sys.argv[2]).fetchall()";

/// The usual way today: read the frames into a data frame, and query the data frame.
const PANDAS: &str = "import sys, can, pandas
frames = pandas.DataFrame([(m.timestamp, m.arbitration_id, bytes(m.data)) for m in can.CanutilsLogReader(sys.argv[1])],
    columns=['t', 'id', 'data'])
print(frames[frames.id == 0x185].groupby('id').size())";

/// Measures and prints; nothing is asserted.
///
/// # Errors
/// If a program is missing or fails.
pub fn bench() -> Result<()> {
    install(&[TIME])?;
    VENV.install()?;
    build()?;
    super::release()?;
    fs::create_dir_all(format!("{FOLDER}/long"))?;
    for n in 0..CAPTURES {
        make("candump", FRAMES, &format!("{FOLDER}/long/{n}.log"))?;
    }
    println!("machine: {}", machine());
    println!(
        "{CAPTURES} candump logs of {FRAMES} frames each; processor time where nothing else is said, best of 3 runs"
    );
    scanning()?;
    pushing()?;
    lake()?;
    growing()?;
    on_processes()
}

fn one() -> String {
    format!("{FOLDER}/long/0.log")
}

fn sql(statement: &str, more: &[&str]) -> Result<f64> {
    let words = [&[FLEET, "sql", statement, "--format", "csv"], more].concat();
    Ok(best(&words, None)?.cpu)
}

/// Frames per second and core, compared with the program.
fn scanning() -> Result<()> {
    let million = f64::from(FRAMES) / 1e6;
    let decode = million / best(&[&release("canvass"), "decode", "--format", "text", &one()], None)?.cpu;
    println!("\ncanvass decode --format text           {decode:>6.2} M frames/s");
    for (name, statement) in [
        ("frames, counted", "SELECT count(can_id) FROM frames"),
        ("messages, counted", "SELECT count(service) FROM messages"),
        (
            "messages, all columns but data",
            "SELECT max(meaning), max(service), max(node), max(index), max(t) FROM messages",
        ),
    ] {
        let rate = million / sql(statement, &["--over", &one(), "--jobs", "1"])?;
        println!("{name:38} {rate:>6.2} M frames/s, {:.0} % of decode", rate / decode * 100.0);
    }
    Ok(())
}

/// The gain of filtering before a row is made, and of decoding only matching frames.
fn pushing() -> Result<()> {
    let million = f64::from(FRAMES * CAPTURES) / 1e6;
    println!("\n{million} M frames, asked with and without push-down");
    for (name, statement) in FILTERS {
        // Signals have names only if the device is known.
        let device: &[&str] = if statement.contains("signals(") { &["--device", DEVICE] } else { &[] };
        let statement = statement.replace("FILES", &format!("{FOLDER}/long"));
        let ask = |set: &str| sql(&format!("{set}{statement}"), &[&["--jobs", "1"], device].concat());
        let (asked, unasked) = (ask("")?, ask("SET canvass.push_down = false; ")?);
        println!("{name:38} {asked:>6.2} s, without push-down {unasked:.2} s: {:.1} times", unasked / asked);
    }
    Ok(())
}

/// Queries on a lake, compared with DuckDB on the same Parquet files and with pandas on the captures.
fn lake() -> Result<()> {
    let lake = format!("{FOLDER}/lake");
    drop(fs::remove_dir_all(&lake));
    let source = format!("{FOLDER}/long");
    let began = Instant::now();
    let ended = Command::new(FLEET)
        .args(["ingest", &source, "--into", &lake, "--device", DEVICE])
        .stdout(Stdio::null())
        .status()?;
    ensure!(ended.success(), "ingest ended with {ended}");
    let seconds = began.elapsed().as_secs_f64();
    println!(
        "\ningest                                 {:>6.2} M frames/s of the clock",
        f64::from(FRAMES * CAPTURES) / 1e6 / seconds
    );
    println!("of {} bytes of captures the lake has {}", size(&source)?, size(&lake)?);
    for (name, statement) in QUESTIONS {
        let ours = sql(statement, &["--lake", &lake])?;
        let theirs = best(&[PYTHON, "-c", DUCKDB, &lake, statement], None)?.cpu;
        println!("{name:38} {ours:>6.2} s, DuckDB {theirs:.2} s: {:.2} times", ours / theirs);
    }
    let pandas = best(&[PYTHON, "-c", PANDAS, &one()], None)?.cpu * f64::from(CAPTURES);
    let ours = sql("SELECT can_id, count(*) FROM messages WHERE can_id = 389 GROUP BY can_id", &["--lake", &lake])?;
    println!(
        "frames of a CAN-ID                     {ours:>6.2} s, python-can and pandas {pandas:.2} s: {:.0} times as fast",
        pandas / ours
    );
    Ok(())
}

/// The growth of the cost with the number of captures.
fn growing() -> Result<()> {
    println!("\n{FRAMES_OF_SHORT} frames a capture");
    let short = format!("{FOLDER}/short.log");
    make("candump", FRAMES_OF_SHORT, &short)?;
    for many in MANY {
        let folder = format!("{FOLDER}/{many}");
        fs::create_dir_all(&folder)?;
        for n in 0..many {
            fs::copy(&short, format!("{folder}/{n}.log")).with_context(|| format!("can't fill {folder}"))?;
        }
        let seconds = sql("SELECT node, count(*) FROM messages GROUP BY node", &["--over", &folder])?;
        println!(
            "{many:>5} captures                          {seconds:>6.2} s, {:.2} ms each",
            seconds / f64::from(many) * 1e3
        );
    }
    Ok(())
}

/// The same query in one process, and on a cluster of executors with one task each.
fn on_processes() -> Result<()> {
    let folder = format!("{FOLDER}/many");
    drop(fs::remove_dir_all(&folder));
    fs::create_dir_all(&folder)?;
    for n in 0..CAPTURES * TIMES {
        fs::hard_link(format!("{FOLDER}/long/{}.log", n % CAPTURES), format!("{folder}/{n}.log"))?;
    }
    let frames = u64::from(FRAMES) * u64::from(CAPTURES * TIMES);
    println!("\n{frames} frames in {} captures, by the clock", CAPTURES * TIMES);
    let folder = fs::canonicalize(folder)?.display().to_string();
    let question =
        ["sql", "SELECT node, max(meaning) FROM messages GROUP BY node", "--over", &folder, "--format", "csv"];
    let tell = |name: &str, seconds: f64, first: f64| {
        println!("{name:38} {seconds:>6.2} s, {:.2} times as fast as one", first / seconds);
    };
    let one = asked(FLEET, &[&question[..], &["--jobs", "1"]].concat())?;
    tell("one process, one task", one, one);
    tell("one process, two tasks", asked(FLEET, &[&question[..], &["--jobs", "2"]].concat())?, one);
    for executors in [1, 2] {
        let cluster = Cluster::start(FLEET, executors)?;
        let words = [&question[..], &["--jobs", "2", "--cluster", &cluster.address]].concat();
        tell(&format!("executors with one task: {executors}"), asked(FLEET, &words)?, one);
    }
    Ok(())
}

/// The total size of a folder.
fn size(folder: &str) -> Result<u64> {
    let mut sum = 0;
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let path = entry.path();
        sum += if path.is_dir() { size(&path.to_string_lossy())? } else { entry.metadata()?.len() };
    }
    Ok(sum)
}
