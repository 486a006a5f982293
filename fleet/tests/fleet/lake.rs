//! A lake holds the rows of its captures, no matter how many runs made it.

use crate::sink::Shared;
use canvass_fleet::capture::{CaptureFile, find};
use canvass_fleet::devices::Devices;
use canvass_fleet::lake::{self, Ingest, Location, Snapshot, Summary};
use canvass_fleet::render::{Format, answer};
use canvass_fleet::report;
use canvass_fleet::scan::register_files;
use canvass_fleet::session::{self, Settings};
use canvass_fleet::table::Table;
use canvass_fleet::views;
use datafusion::prelude::SessionContext;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

fn session() -> SessionContext {
    session::local(&Settings { partitions: Some(2), ..Settings::default() }).unwrap()
}

async fn ingest(source: &Path, lake: &Path) -> Summary {
    ingest_with(source, lake, Devices::default()).await
}

async fn ingest_with(source: &Path, lake: &Path, devices: Devices) -> Summary {
    let (sources, lake) = (vec![source.display().to_string()], lake.display().to_string());
    Ingest { sources, lake, devices, rehash: false, site: None }.run(&session(), &mut |_| {}).await.unwrap()
}

pub async fn rows(session: &SessionContext, statement: &str) -> Vec<Value> {
    let batches = session.sql(statement).await.unwrap().collect().await.unwrap();
    let Some(first) = batches.first() else { return Vec::new() };
    let out = Shared::default();
    let mut rendered = answer(Format::Json, &first.schema(), Box::new(out.clone())).unwrap();
    batches.iter().for_each(|batch| rendered.batch(batch).unwrap());
    rendered.finish().unwrap();
    let text = String::from_utf8(out.0.lock().unwrap().clone()).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// The rows of a table as texts, sorted.
async fn table(session: &SessionContext, table: Table) -> Vec<String> {
    let columns: Vec<String> = table.columns().iter().map(|column| format!("\"{}\"", column.field.name())).collect();
    let found = rows(session, &format!("SELECT {} FROM {}", columns.join(", "), table.name())).await;
    let mut texts: Vec<String> = found.iter().map(Value::to_string).collect();
    texts.sort();
    texts
}

pub async fn open(lake: &Path) -> SessionContext {
    let session = session();
    lake::register(&session, &lake.display().to_string()).await.unwrap();
    views::register(&session).await.unwrap();
    session
}

/// Fills a folder with varied captures, a broken file, and results of test runs.
fn fill(folder: &Path) {
    let documents = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let copy = |from: &str, to: &str| std::fs::copy(documents.join(from), folder.join(to)).unwrap();
    copy("docs/examples/commissioning.log", "commissioning.log");
    copy("traces/samples/python-can.asc", "python-can.asc");
    copy("traces/samples/ros2-zstd.mcap", "ros2-zstd.mcap");
    copy("traces/samples/two-interfaces.pcapng", "two-interfaces.pcapng");
    std::fs::write(folder.join("broken.log"), "this is no capture\n").unwrap();
    std::fs::write(folder.join("empty.log"), "").unwrap();
    for (name, verdict, version) in [("one", "pass", "1.0"), ("two", "fail", "2.0")] {
        std::fs::write(folder.join(format!("{name}.json")), result(verdict, version)).unwrap();
    }
}

/// A capture of a format that holds the bit rate.
fn with_bit_rate() -> String {
    let head = "ASCII Trace IXXAT MiniMon V3  Version: 1.1.4.4533\nDate: 28.01.2025\nStart time: 10:47:15\nStop time: \
                23:00:00\nOverruns: 0\nBaudrate: 250 kbit/s\n\"Time\";\"Identifier (hex)\";\"Format\";\"Flags\";\"Data (hex)\"\n";
    let frame = |n: u32| format!("\"10:47:15.{n:03}\";\"185\";\"Std\";\"\";\"01 02 03 04 05 06 07 08 \"\n");
    head.to_owned() + &(0..100).map(frame).collect::<String>()
}

fn result(verdict: &str, version: &str) -> String {
    let month = if version == "1.0" { 1 } else { 2 };
    serde_json::json!({
        "schema": "canvass/test/1", "bus": "can0", "node": 5, "seed": 0, "cancelled": false,
        "device": { "vendor_id": 19, "product_code": 7, "software_version": version },
        "provenance": { "version": "0.1.0", "date": format!("2026-{month:02}-03T14:00:00+01:00") },
        "summary": { "pass": i32::from(verdict == "pass"), "fail": i32::from(verdict == "fail") },
        "cases": [{ "id": "301/nmt/back-to-back", "verdict": verdict, "level": "must", "flaky": false }],
    })
    .to_string()
}

fn files(folder: &Path) -> BTreeSet<String> {
    let mut files = BTreeSet::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder_now) = folders.pop() {
        for entry in folder_now.read_dir().unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => folders.push(path),
                false => drop(files.insert(path.strip_prefix(folder).unwrap().display().to_string())),
            }
        }
    }
    files.retain(|file| !file.starts_with("log/"));
    files
}

#[tokio::test(flavor = "multi_thread")]
async fn a_lake_has_the_rows_of_its_captures() {
    let (source, lake) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    fill(source.path());
    let summary = ingest(source.path(), lake.path()).await;
    assert_eq!((summary.added, summary.known, summary.broken.len()), (8, 0, 2), "{summary:?}");
    let (of_lake, of_files) = (open(lake.path()).await, session());
    register_files(&of_files, &[source.path().display().to_string()]).unwrap();
    for of_table in Table::ALL {
        let (kept, mut read) = (table(&of_lake, of_table).await, table(&of_files, of_table).await);
        // Results of test runs are no captures. The table of a folder reports them as unreadable, a lake recognises
        // them.
        read.retain(|row| !(of_table == Table::Captures && row.contains(".json")));
        assert_eq!(kept, read, "{}", of_table.name());
        assert!(!kept.is_empty(), "{}", of_table.name());
    }
    let broken = rows(&of_lake, "SELECT capture, reason FROM captures WHERE reason IS NOT NULL ORDER BY capture").await;
    assert_eq!(broken.len(), 2);
    assert!(broken[0]["reason"].as_str().unwrap().starts_with("of no known format"), "{broken:?}");
    let days = rows(&of_lake, "SELECT DISTINCT date FROM messages WHERE date = '2025-01-28'").await;
    assert_eq!(days.len(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn nothing_goes_in_twice_and_changed_files_are_replaced() {
    let (source, lake) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    fill(source.path());
    ingest(source.path(), lake.path()).await;
    let before = files(lake.path());
    let again = ingest(source.path(), lake.path()).await;
    assert_eq!((again.added, again.replaced, again.known, again.rows), (0, 0, 8, 0), "{again:?}");
    assert_eq!(files(lake.path()), before);

    // A copy has no rows of its own.
    std::fs::copy(source.path().join("python-can.asc"), source.path().join("z-copy.asc")).unwrap();
    let copied = ingest(source.path(), lake.path()).await;
    assert_eq!((copied.copies, copied.added, copied.known), (1, 0, 8), "{copied:?}");
    assert_eq!(files(lake.path()), before);

    // The original of the copy changes: its former content is now stored under the name of the copy.
    let first = "(1738061235.000000) can0 705#00\n";
    std::fs::write(source.path().join("python-can.asc"), first).unwrap();
    let changed = ingest(source.path(), lake.path()).await;
    assert_eq!((changed.replaced, changed.known), (2, 7), "{changed:?}");
    let session = open(lake.path()).await;
    let frames = rows(
        &session,
        "SELECT arrow_cast(capture, 'Utf8') AS capture, count(*) AS frames FROM frames WHERE capture LIKE '%.asc' \
         GROUP BY capture ORDER BY capture",
    )
    .await;
    assert_eq!((frames.len(), &frames[0]["frames"]), (2, &1.into()), "{frames:?}");

    // Rules of devices change how captures are read.
    let devices = Devices::new(vec!["5=kuebler-sendix-58x8".parse().unwrap()]);
    let ruled = ingest_with(source.path(), lake.path(), devices).await;
    assert_eq!((ruled.known, ruled.added), (0, 0), "{ruled:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn what_a_killed_run_leaves_is_no_part_of_the_lake() {
    let (source, lake) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    fill(source.path());
    ingest(source.path(), lake.path()).await;
    let before = files(lake.path());
    let stray = lake.path().join("messages/date=2025-01-28/stray.parquet");
    std::fs::write(&stray, "half a file").unwrap();
    std::fs::write(lake.path().join("events/half.parquet#1"), "half").unwrap();
    assert!(!table(&open(lake.path()).await, Table::Messages).await.is_empty(), "it is not read");
    ingest(source.path(), lake.path()).await;
    assert_eq!(files(lake.path()), before);
}

#[tokio::test(flavor = "multi_thread")]
async fn two_runs_at_a_time_do_not_mix() {
    let lake = tempfile::tempdir().unwrap();
    let location = Location::of(&lake.path().display().to_string(), &session().runtime_env()).unwrap();
    let mut first = Snapshot::read(&location).await.unwrap();
    first.begin(&location).await.unwrap();
    let mut second = Snapshot::read(&location).await.unwrap();
    second.begin(&location).await.unwrap();
    let refused = first.commit(&location, Vec::new()).await.unwrap_err().to_string();
    assert!(refused.contains("another process ingests"), "{refused}");
    second.commit(&location, Vec::new()).await.unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn the_usual_questions_are_answered() {
    let (source, lake) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    fill(source.path());
    std::fs::write(source.path().join("bit-rate.csv"), with_bit_rate()).unwrap();
    ingest(source.path(), lake.path()).await;
    let session = open(lake.path()).await;
    for view in views::VIEWS {
        rows(&session, &format!("SELECT * FROM {}", view.name)).await;
    }
    let first_bad = rows(&session, "SELECT * FROM first_bad_release").await;
    assert_eq!((first_bad.len(), &first_bad[0]["first_bad"]), (1, &"2.0".into()), "{first_bad:?}");
    let aborts = rows(&session, "SELECT * FROM sdo_aborts").await;
    assert!(aborts.iter().any(|row| row["abort_code"] == 0x0602_0000), "{aborts:?}");
    let load = rows(&session, "SELECT * FROM bus_load WHERE load_percent IS NOT NULL").await;
    assert_eq!(
        (load.len(), &load[0]["bit_rate"]),
        (1, &250_000.into()),
        "no other capture tells its bit rate: {load:?}"
    );
    let percent = load[0]["load_percent"].as_f64().unwrap();
    assert!((40.0..60.0).contains(&percent), "a frame of 111 to 135 bits each millisecond: {percent}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_page_shows_totals_plots_and_all_questions() {
    let (source, lake) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    fill(source.path());
    ingest(source.path(), lake.path()).await;
    let fleet = report::ask(&open(lake.path()).await, "<lake>", 1).await.unwrap();
    let total = |name| fleet.totals.iter().find(|total| total.0 == name).map(|total| &*total.1);
    assert_eq!((total("Captures"), total("Test runs")), (Some("6"), Some("2")), "{:?}", fleet.totals);
    let by_day = fleet.plots.iter().find(|plot| plot.title == "Captures by day").unwrap();
    assert_eq!(
        (&by_day.labels[..], &by_day.lines[0].values),
        (&["2023-11-14".to_owned(), "2025-01-28".to_owned()][..], &vec![Some(3.0), Some(1.0)])
    );
    let names: Vec<&str> = fleet.questions.iter().map(|question| question.name).collect();
    assert_eq!(names, views::VIEWS.iter().map(|view| view.name).collect::<Vec<_>>());
    let load = fleet.questions.iter().find(|question| question.name == "bus_load").unwrap();
    assert_eq!((load.rows.len(), load.is_cut, &*load.columns[0]), (1, true, "capture"));
    let mut page = Vec::new();
    canvass_reports::fleet::render(&fleet, &mut page).unwrap();
    assert!(String::from_utf8(page).unwrap().contains("<h1>&lt;lake&gt;</h1>"));
}

#[tokio::test(flavor = "multi_thread")]
async fn devices_are_named_by_the_identity_that_they_show() {
    let folder = tempfile::tempdir().unwrap();
    let mut log = String::new();
    let frames = [
        "000#8105",
        "705#00",
        "605#4018100200000000",
        "585#4318100211200000",
        "605#40001A0000000000",
        "585#4F001A0001000000",
        "605#40001A0100000000",
        "585#43001A0120000460",
        "000#0105",
        "185#01020000",
    ];
    for (n, frame) in frames.iter().enumerate() {
        log.push_str(&format!("(1738061235.{:06}) can0 {frame}\n", n * 1000));
    }
    std::fs::write(folder.path().join("a.log"), log).unwrap();
    let mut scan = canvass_fleet::scan::Options::default();
    scan.devices = "product:0x2011=kuebler-sendix-58x8".to_owned();
    let session = session::local(&Settings { scan, ..Settings::default() }).unwrap();
    let found =
        rows(&session, &format!("SELECT * FROM events('{}') WHERE event = 'device'", folder.path().display())).await;
    assert_eq!((found.len(), &found[0]["model"]), (1, &"kuebler-sendix-58x8".into()), "{found:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn files_are_found_in_the_order_of_their_names() {
    let source = tempfile::tempdir().unwrap();
    fill(source.path());
    let pattern = format!("{}/*.{{log,asc}}", source.path().display());
    let found = find(&pattern, &session().runtime_env()).await.unwrap();
    let names: Vec<&str> = found.iter().map(|file: &CaptureFile| file.name.rsplit('/').next().unwrap()).collect();
    assert_eq!(names, ["broken.log", "commissioning.log", "empty.log", "python-can.asc"]);
    assert!(find("/nowhere/*.log", &session().runtime_env()).await.is_err());
}

/// The number of frames of each capture, by the end of its name.
async fn frames_of(lake: &Path) -> Vec<(String, i64)> {
    let session = open(lake).await;
    let statement = "SELECT arrow_cast(capture, 'Utf8') AS capture, count(*) AS frames FROM frames \
                     GROUP BY capture ORDER BY capture";
    let of = |row: &Value| (row["capture"].as_str().unwrap().to_owned(), row["frames"].as_i64().unwrap());
    rows(&session, statement).await.iter().map(of).collect()
}

fn log(frames: usize) -> String {
    (0..frames).map(|n| format!("({}.000000) can0 705#05\n", 1_738_061_235 + n)).collect()
}

pub async fn ingest_at(source: &str, lake: &Path, site: Option<&str>) -> Summary {
    let (sources, lake) = (vec![source.to_owned()], lake.display().to_string());
    let ingest = Ingest { sources, lake, devices: Devices::default(), rehash: false, site: site.map(str::to_owned) };
    ingest.run(&session(), &mut |_| {}).await.unwrap()
}

/// A file is its absolute path: another spelling adds nothing, an equal name in another folder replaces nothing, and
/// two sites with equal paths are two files.
#[tokio::test(flavor = "multi_thread")]
async fn a_file_has_one_identity() {
    let (source, lake) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    for (folder, frames) in [("one", 3), ("two", 5)] {
        std::fs::create_dir(source.path().join(folder)).unwrap();
        std::fs::write(source.path().join(folder).join("a.log"), log(frames)).unwrap();
    }
    let at = |path: &str| source.path().join(path).display().to_string();
    assert_eq!(ingest_at(&at("one"), lake.path(), None).await.added, 1);
    assert_eq!(ingest_at(&at("two/../one/a.log"), lake.path(), None).await.known, 1);
    assert_eq!(ingest_at(&at("two"), lake.path(), None).await.added, 1);
    let counts: Vec<i64> = frames_of(lake.path()).await.into_iter().map(|(_, frames)| frames).collect();
    assert_eq!(counts, [3, 5]);
    std::fs::write(source.path().join("one/a.log"), log(4)).unwrap();
    assert_eq!(ingest_at(&at("one"), lake.path(), Some("bench-7")).await.added, 1);
    let found = frames_of(lake.path()).await;
    assert_eq!(found.iter().map(|(_, frames)| *frames).collect::<Vec<_>>(), [3, 5, 4]);
    assert!(found[2].0.starts_with("bench-7:/") && found[2].0.ends_with("/one/a.log"), "{found:?}");
}

/// The rows of a copy are those of its original until that changes, also if the copy is not among the sources.
#[tokio::test(flavor = "multi_thread")]
async fn a_copy_keeps_its_rows() {
    let (source, lake) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    for name in ["a.log", "b.log"] {
        std::fs::write(source.path().join(name), log(3)).unwrap();
    }
    let at = |path: &str| source.path().join(path).display().to_string();
    let both = ingest_at(&source.path().display().to_string(), lake.path(), None).await;
    assert_eq!((both.added, both.copies), (1, 1));
    std::fs::write(source.path().join("a.log"), log(7)).unwrap();
    let changed = ingest_at(&at("a.log"), lake.path(), None).await;
    assert!(changed.broken.is_empty(), "{changed:?}");
    let counts: Vec<i64> = frames_of(lake.path()).await.into_iter().map(|(_, frames)| frames).collect();
    assert_eq!(counts, [7, 3]);
}

/// Two sites with equal files have rows of their own: one computer can't read the files of the other one.
#[tokio::test(flavor = "multi_thread")]
async fn sites_share_no_rows() {
    let (source, lake) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let path = source.path().join("a.log");
    std::fs::write(&path, log(3)).unwrap();
    let at = path.display().to_string();
    for site in ["one", "two"] {
        assert_eq!(ingest_at(&at, lake.path(), Some(site)).await.added, 1);
    }
    // The file of the second site changes; what the first one has recorded stays.
    std::fs::write(&path, log(7)).unwrap();
    assert_eq!(ingest_at(&at, lake.path(), Some("two")).await.replaced, 1);
    let counts: Vec<i64> = frames_of(lake.path()).await.into_iter().map(|(_, frames)| frames).collect();
    assert_eq!(counts, [3, 7]);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_lake_may_lie_anywhere() {
    let source = tempfile::tempdir().unwrap();
    std::fs::write(source.path().join("a.log"), log(3)).unwrap();
    for name in ["ü", "#1", "100%", "a[1]", "{x}", "~y", "a b", "%41"] {
        let folder = tempfile::tempdir().unwrap();
        let lake = folder.path().join(name);
        ingest(source.path(), &lake).await;
        assert_eq!(frames_of(&lake).await[0].1, 3, "{name}");
        assert!(lake.join("messages").is_dir(), "{name}: the lake is in its folder");
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("here")).unwrap();
    let around = folder.path().join("here/../lake");
    ingest(source.path(), &around).await;
    assert_eq!(frames_of(&folder.path().join("lake")).await[0].1, 3);
}

/// A clock that was set back: the filter by time finds what lies before the first frame.
#[tokio::test(flavor = "multi_thread")]
async fn a_time_is_found_wherever_it_stands() {
    let (source, lake) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let text = "(1738061235.000000) can0 705#05\n(1738051235.000000) can0 705#04\n(1738061236.000000) can0 705#7F\n";
    std::fs::write(source.path().join("a.log"), text).unwrap();
    ingest(source.path(), lake.path()).await;
    let session = open(lake.path()).await;
    let before =
        "SELECT count(*) AS n FROM frames WHERE t < arrow_cast(1738061235000000000, 'Timestamp(Nanosecond, None)')";
    assert_eq!(rows(&session, before).await[0]["n"], 1);
}
