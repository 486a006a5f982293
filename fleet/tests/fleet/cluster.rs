//! A scheduler and two executors as processes give the same rows as one process, whatever happens to them.

use canvass_fleet::table::Table;
use canvass_fleet::views::VIEWS;
use hyper_util::rt::{TokioExecutor, TokioIo};
use hyper_util::server::conn::auto::Builder;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Time limit of each wait, sufficient even on a busy computer.
const PATIENCE: Duration = Duration::from_secs(50);

type Environment<'a> = &'a [(&'a str, String)];

fn program(arguments: &[&str], environment: Environment<'_>) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_canvass-fleet"));
    let environment = environment.iter().map(|(name, value)| (*name, value));
    command.args(arguments).envs(environment).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// A process that is killed at the end of the test, however the test ends.
struct Process {
    child: Child,
    lines: Receiver<String>,
}

impl Process {
    fn start(arguments: &[&str], environment: Environment<'_>) -> Self {
        let mut child = program(arguments, environment).stdout(Stdio::null()).spawn().unwrap();
        let (sender, lines) = channel();
        let stderr = BufReader::new(child.stderr.take().unwrap());
        // The thread reads standard error to its end, so that the process never blocks on it.
        thread::spawn(move || stderr.lines().map_while(Result::ok).for_each(|line| drop(sender.send(line))));
        Self { child, lines }
    }

    /// The first line that contains these words.
    fn line_with(&self, words: &str) -> String {
        let (end, mut seen) = (Instant::now() + PATIENCE, Vec::new());
        loop {
            match self.lines.recv_timeout(end.saturating_duration_since(Instant::now())) {
                Ok(line) if line.contains(words) => return line,
                Ok(line) => seen.push(line),
                Err(error) => panic!("{error}: no \"{words}\" in {seen:#?}"),
            }
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

struct Cluster {
    address: String,
    executors: Vec<Process>,
    _scheduler: Process,
}

impl Cluster {
    fn start(environment: Environment<'_>) -> Self {
        let scheduler = Process::start(&["scheduler", "--bind", "127.0.0.1:0"], environment);
        let line = scheduler.line_with("scheduler at ");
        let address = line.rsplit(' ').next().unwrap().to_owned();
        let arguments = ["executor", "--scheduler", &address, "--bind", "127.0.0.1:0", "--tasks", "2"];
        let executors: Vec<Process> = (0..2).map(|_| Process::start(&arguments, environment)).collect();
        // Each executor has registered when it logs this line.
        executors.iter().for_each(|executor| drop(executor.line_with("arrow flight")));
        Self { address: format!("df://{address}"), executors, _scheduler: scheduler }
    }
}

/// The result of a run.
struct Ended {
    status: Option<i32>,
    out: String,
    err: String,
}

fn ended(mut child: Child) -> Ended {
    let (mut out, mut err) = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
    let read_out = thread::spawn(move || {
        let mut text = String::new();
        out.read_to_string(&mut text).map(|_| text).unwrap()
    });
    let read_err = thread::spawn(move || {
        let mut text = String::new();
        err.read_to_string(&mut text).map(|_| text).unwrap()
    });
    let end = Instant::now() + PATIENCE;
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if Instant::now() > end {
            child.kill().unwrap();
        }
        thread::sleep(Duration::from_millis(10));
    };
    Ended { status: status.code(), out: read_out.join().unwrap(), err: read_err.join().unwrap() }
}

fn run(arguments: &[&str], environment: Environment<'_>) -> Ended {
    ended(program(arguments, environment).spawn().unwrap())
}

/// The sorted rows of a run that must succeed.
fn rows(arguments: &[&str], environment: Environment<'_>) -> Vec<String> {
    let ended = run(arguments, environment);
    assert_eq!(ended.status, Some(0), "{arguments:?}: {}", ended.err);
    let mut rows: Vec<String> = ended.out.lines().map(str::to_owned).collect();
    rows.sort();
    rows
}

/// Fills a folder with varied captures, a broken file, and results of test runs.
fn fill(folder: &Path) {
    let documents = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let copies = ["docs/examples/commissioning.log", "traces/samples/python-can.asc", "traces/samples/ros2-zstd.mcap"];
    for from in copies {
        let from = documents.join(from);
        std::fs::copy(&from, folder.join(from.file_name().unwrap())).unwrap();
    }
    std::fs::write(folder.join("broken.log"), "this is no capture\n").unwrap();
    for (name, verdict) in [("one", "pass"), ("two", "fail")] {
        let result = serde_json::json!({
            "schema": "canvass/test/1", "bus": "can0", "node": 5, "seed": 0, "cancelled": false,
            "device": { "vendor_id": 19, "product_code": 7, "software_version": name },
            "provenance": { "version": "0.1.0", "date": "2026-01-03T14:00:00+01:00" },
            "summary": { "pass": i32::from(verdict == "pass"), "fail": i32::from(verdict == "fail") },
            "cases": [{ "id": "301/nmt/back-to-back", "verdict": verdict, "level": "must", "flaky": false }],
        });
        std::fs::write(folder.join(format!("{name}.json")), result.to_string()).unwrap();
    }
}

/// Fills a folder with so many frames that an executor is still reading them when it is killed.
fn fill_with_much(folder: &Path) {
    for capture in 0..12 {
        let line =
            |n: u32| format!("({}.{:06}) can0 18{}#{n:08X}\n", 1_738_061_235 + n / 1000, n % 1000 * 1000, n % 4 + 1);
        std::fs::write(folder.join(format!("{capture}.log")), (0..40_000).map(line).collect::<String>()).unwrap();
    }
}

/// The statements of all views, and the number of rows of every table.
fn questions() -> String {
    let views = VIEWS.iter().map(|view| format!("SELECT * FROM {};", view.name));
    let counts = Table::ALL.map(|table| format!("SELECT '{0}' AS name, count(*) AS n FROM {0};", table.name()));
    views.chain(counts).collect()
}

fn answers_are_the_same(source: &str, environment: Environment<'_>) {
    let cluster = Cluster::start(environment);
    let questions = questions();
    let asked = ["sql", &questions, "--over", source, "--format", "json"];
    let alone = rows(&asked, environment);
    assert!(alone.len() > Table::ALL.len(), "{alone:?}");
    assert_eq!(rows(&[&asked[..], &["--cluster", &cluster.address]].concat(), environment), alone);
}

#[test]
fn the_questions_have_the_same_answers_over_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path());
    answers_are_the_same(folder.path().to_str().unwrap(), &[]);
}

#[tokio::test(flavor = "multi_thread")]
async fn the_questions_have_the_same_answers_over_s3() {
    let root = tempfile::tempdir().unwrap();
    let bucket = root.path().join("field");
    std::fs::create_dir(&bucket).unwrap();
    fill(&bucket);
    let endpoint = serve_s3(root.path()).await;
    let environment = [
        ("AWS_ENDPOINT", endpoint),
        ("AWS_ALLOW_HTTP", "true".to_owned()),
        ("AWS_REGION", "us-east-1".to_owned()),
        ("AWS_ACCESS_KEY_ID", "key".to_owned()),
        ("AWS_SECRET_ACCESS_KEY", "secret".to_owned()),
    ];
    tokio::task::spawn_blocking(move || answers_are_the_same("s3://field/", &environment)).await.unwrap();
}

/// An S3 server over a folder.
async fn serve_s3(root: &Path) -> String {
    let mut service = s3s::service::S3ServiceBuilder::new(s3s_fs::FileSystem::new(root).unwrap());
    service.set_auth(s3s::auth::SimpleAuth::from_single("key", "secret"));
    let service = service.build();
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    tokio::spawn(async move {
        while let Ok((socket, _)) = listener.accept().await {
            let service = service.clone();
            tokio::spawn(async move {
                let builder = Builder::new(TokioExecutor::new());
                drop(builder.serve_connection(TokioIo::new(socket), service).await);
            });
        }
    });
    format!("http://{address}")
}

#[test]
fn an_executor_that_dies_makes_no_wrong_numbers() {
    let folder = tempfile::tempdir().unwrap();
    fill_with_much(folder.path());
    let mut cluster = Cluster::start(&[]);
    let pattern = folder.path().join("*.log");
    let statement = format!("SELECT id, count(*) AS n, min(t) AS t FROM frames('{}') GROUP BY id", pattern.display());
    let asked = ["sql", &statement, "--format", "json"];
    let running = program(&[&asked[..], &["--cluster", &cluster.address]].concat(), &[]).spawn().unwrap();
    let mut dying = cluster.executors.remove(0);
    // The executor has received a task: its work has begun.
    let _ = dying.line_with("task");
    dying.child.kill().unwrap();
    let ended = ended(running);
    if ended.status == Some(0) {
        let mut found: Vec<String> = ended.out.lines().map(str::to_owned).collect();
        found.sort();
        assert_eq!(found, rows(&asked, &[]));
    } else {
        assert!(ended.status == Some(2) && ended.err.contains("canvass-fleet: "), "{}", ended.err);
    }
}

#[test]
fn an_ingest_that_is_killed_ten_times_gives_the_same_lake() {
    let (folder, lakes) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    fill(folder.path());
    let source = folder.path().to_str().unwrap();
    let [killed, whole] = ["killed", "whole"].map(|name| lakes.path().join(name).display().to_string());
    let cluster = Cluster::start(&[]);
    let ingest = ["ingest", source, "--into", &killed, "--cluster", &cluster.address];
    for n in 0..10 {
        let mut child = program(&ingest, &[]).spawn().unwrap();
        thread::sleep(Duration::from_millis(60 * n));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    rows(&ingest, &[]);
    rows(&["ingest", source, "--into", &whole], &[]);
    let everything: String = Table::ALL.map(|table| format!("SELECT * FROM {};", table.name())).concat();
    let of = |lake: &str| rows(&["sql", &everything, "--lake", lake, "--format", "json"], &[]);
    assert_eq!(of(&killed), of(&whole));
}

#[test]
fn nobody_there_is_told_with_a_status_of_its_own() {
    // The system gives a free port, which is free again after this statement.
    let address = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let ended = run(&["sql", "SELECT 1", "--cluster", &format!("df://{address}")], &[]);
    assert_eq!(ended.status, Some(3), "{}", ended.err);
    assert!(ended.err.contains(&format!("no scheduler answers at {address}")), "{}", ended.err);
}
