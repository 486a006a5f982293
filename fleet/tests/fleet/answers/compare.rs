//! Compares the answers of SQL row by row with the output of `canvass`.

use super::engine::Engine;
use super::program::{document, lines, written};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Compares all tables of a capture.
pub fn all(engine: &Engine, capture: &Path) {
    messages(engine, capture);
    events(engine, capture);
    signals(engine, capture);
    diagnosis(engine, capture);
    quality(engine, capture);
}

/// The non-null columns of a row, under their names in JSON.
fn renamed(row: &Value, columns: &[(&str, &str)]) -> Value {
    let there = |(column, name): &(&str, &str)| {
        let value = row.get(*column).unwrap_or_else(|| panic!("{column} is no column of {row}"));
        (!value.is_null()).then(|| ((*name).to_owned(), value.clone()))
    };
    Value::Object(columns.iter().filter_map(there).collect())
}

/// A JSON object reduced to these members, without members that are null or false.
fn reduced(object: &Value, names: &[&str]) -> Value {
    let told = |name: &&str| {
        let value = object.get(*name)?;
        (!value.is_null() && *value != Value::Bool(false)).then(|| ((*name).to_owned(), value.clone()))
    };
    Value::Object(names.iter().filter_map(told).collect())
}

fn messages(engine: &Engine, capture: &Path) {
    let decoded = lines(&["decode", "--format", "json"], capture);
    let rows = engine.table("messages", capture);
    assert_eq!(rows.len(), decoded.len(), "{}", capture.display());
    let frames = engine.table("frames", capture);
    assert_eq!(frames.len(), decoded.len(), "{}", capture.display());
    let of_frames = ["t", "channel", "extended", "remote", "error", "fd", "xl", "direction", "data"];
    let of_messages = ["node", "service", "source", "index", "sub", "object", "comment"];
    for ((row, frame), line) in rows.iter().zip(&frames).zip(&decoded) {
        let both: Vec<&str> = of_frames.iter().chain(&of_messages).copied().collect();
        let mut expected = reduced(line, &both);
        expected["can_id"] = line["id"].clone();
        expected["meaning"] = line["text"].clone();
        let violation = &line["violation"]["rule"];
        if !violation.is_null() {
            expected["violation"] = violation.clone();
        }
        let columns: Vec<&str> = both.iter().chain(&["can_id", "meaning", "violation"]).copied().collect();
        assert_eq!(reduced(row, &columns), expected, "{}", capture.display());
        let columns: Vec<&str> = of_frames.iter().chain(&["can_id", "number", "length"]).copied().collect();
        assert_eq!(reduced(frame, &columns), reduced(row, &columns), "{}", capture.display());
        let length = line.get("dlc").cloned().unwrap_or_else(|| json!(line["data"].as_str().unwrap().len() / 2));
        assert_eq!(row["length"], length, "{line}");
    }
}

/// The columns of `events` whose names differ in JSON, by the kind of event.
fn event_columns(kind: &str) -> &'static [(&'static str, &'static str)] {
    match kind {
        "sdo" => &[
            ("index", "index"),
            ("sub", "sub"),
            ("object", "object"),
            ("direction", "direction"),
            ("mode", "mode"),
            ("outcome", "outcome"),
            ("started", "started"),
            ("duration_ns", "duration_ns"),
            ("bytes", "bytes"),
            ("segments", "segments"),
            ("announced", "announced"),
            ("data", "data"),
            ("value", "value"),
        ],
        "state" | "boot-up" => &[("from_state", "from"), ("to_state", "to"), ("cause", "cause")],
        "emcy" => &[
            ("emcy_state", "state"),
            ("emcy_code", "code"),
            ("emcy_register", "register"),
            ("manufacturer", "manufacturer"),
            ("duration_ns", "duration_ns"),
            ("text", "text"),
        ],
        "lss" | "lmt" => &[
            ("role", "role"),
            ("previous_unanswered", "previous_unanswered"),
            ("delay_ns", "delay_ns"),
            ("data", "data"),
            ("text", "text"),
        ],
        "node-id" => &[("from_node", "from"), ("to_node", "to"), ("index", "index"), ("sub", "sub")],
        "bit-rate" => &[("bit_rate", "bit_rate"), ("delay_ns", "delay_ns")],
        "device" => &[("model", "model")],
        "cob-id" => &[("used_for", "use"), ("from_can_id", "from"), ("to_can_id", "to"), ("source", "source")],
        "mapping" => &[("pdo", "pdo")],
        "comment" => &[("text", "text")],
        other => panic!("{other} is no kind of event"),
    }
}

fn events(engine: &Engine, capture: &Path) {
    let told = lines(&["decode", "--events", "--format", "json"], capture);
    let rows = engine.table("events", capture);
    assert_eq!(rows.len(), told.len(), "{}", capture.display());
    for (row, event) in rows.iter().zip(&told) {
        let detail: Value = serde_json::from_str(row["detail"].as_str().unwrap()).unwrap();
        assert_eq!(detail, *event, "{}", capture.display());
        let kind = event["event"].as_str().unwrap();
        let head = ["t", "channel", "node", "event"];
        let columns: Vec<_> =
            head.iter().map(|name| (*name, *name)).chain(event_columns(kind).iter().copied()).collect();
        let names: Vec<&str> = columns.iter().map(|(_, name)| *name).collect();
        let flags_kept = |value: Value| match event.get("previous_unanswered") {
            Some(flag) => with(value, "previous_unanswered", flag),
            None => value,
        };
        assert_eq!(flags_kept(renamed(row, &columns)), flags_kept(reduced(event, &names)), "{}", capture.display());
        let abort = renamed(row, &[("abort_code", "code"), ("abort_by", "by")]);
        assert_eq!(abort, reduced(&event["abort"], &["code", "by"]), "{event}");
        let violation = event["violation"]["rule"].clone();
        assert_eq!(row["violation"], violation, "{event}");
    }
}

fn with(mut object: Value, name: &str, value: &Value) -> Value {
    object[name] = value.clone();
    object
}

/// Compares the signals of each frame with `decode`, and the latest value of each column with `signals`.
fn signals(engine: &Engine, capture: &Path) {
    let decoded = lines(&["decode", "--format", "json"], capture);
    let told: Vec<(&Value, &Value)> = decoded
        .iter()
        .flat_map(|line| line["signals"].as_array().into_iter().flatten().map(move |signal| (line, signal)))
        .collect();
    let rows = engine.table("signals", capture);
    assert_eq!(rows.len(), told.len(), "{}", capture.display());
    for (row, (line, signal)) in rows.iter().zip(&told) {
        let head = ["t", "channel", "node", "service"];
        assert_eq!(reduced(row, &head), reduced(line, &head), "{}", capture.display());
        let texts = ["index", "sub", "name", "unit", "scaled_unit"];
        assert_eq!(reduced(row, &texts), reduced(signal, &texts), "{}", capture.display());
        for name in ["value", "scaled"] {
            assert!(is_same_number(&row[name], &signal[name]), "{row} {signal}");
        }
        if row["raw"].is_null() {
            assert!(!signal["raw"].is_u64() || signal["raw"].as_u64() > Some(i64::MAX as u64), "{row} {signal}");
        } else {
            assert!(is_same_number(&row["raw"], &signal["raw"]), "{row} {signal}");
        }
    }
    columns(&rows, capture);
}

fn is_same_number(row: &Value, told: &Value) -> bool {
    let number = |value: &Value| value.as_f64().or_else(|| value.as_bool().map(|is| f64::from(u8::from(is))));
    match (number(row), number(told)) {
        // A REAL32 is printed with only the digits that distinguish it from other REAL32 values.
        (Some(row), Some(told)) => row == told || row as f32 == told as f32,
        (row, told) => row == told || told.is_none(),
    }
}

fn columns(rows: &[Value], capture: &Path) {
    let told = lines(&["signals", "--format", "json"], capture);
    let mut latest: Map<String, Value> = Map::new();
    let mut of_pdos = rows.iter().filter(|row| !row["pdo"].is_null()).peekable();
    for line in &told {
        let head = ["t", "channel", "node", "pdo"];
        // `signals` has no line for a PDO without numeric values.
        while of_pdos.next_if(|row| is_without_number(row) && reduced(row, &head) != reduced(line, &head)).is_some() {}
        let row = of_pdos.peek().unwrap_or_else(|| panic!("{line} has no rows: {}", capture.display()));
        assert_eq!(reduced(row, &head), reduced(line, &head), "{}", capture.display());
        let number = row["number"].clone();
        while let Some(row) = of_pdos.next_if(|row| row["number"] == number && row["t"] == line["t"]) {
            for (value, unit) in [("value", "unit"), ("scaled", "scaled_unit")] {
                if !row[value].is_null() {
                    latest.insert(column(row, unit), row[value].clone());
                }
            }
        }
        for (name, value) in line.as_object().unwrap().iter().filter(|(name, _)| !head.contains(&name.as_str())) {
            // The address distinguishes two objects of the same name.
            if let Some(known) = latest.get(name) {
                assert!(is_same_number(known, value), "{name} {known} {line}");
            }
        }
    }
    assert!(of_pdos.all(is_without_number), "{}", capture.display());
}

fn is_without_number(row: &Value) -> bool {
    row["value"].is_null() && row["scaled"].is_null()
}

fn column(row: &Value, unit: &str) -> String {
    let text = |name: &str| row[name].as_str().map(str::to_owned);
    let address = || format!("{:04X}h:{:02X}", row["index"].as_u64().unwrap(), row["sub"].as_u64().unwrap());
    let unit = text(unit).filter(|unit| !unit.is_empty()).map(|unit| format!(" [{unit}]")).unwrap_or_default();
    let name = text("name").unwrap_or_else(address);
    format!("{}.{}.{name}{unit}", text("channel").unwrap(), row["node"])
}

fn diagnosis(engine: &Engine, capture: &Path) {
    let told = document(&["diagnose", "--format", "json", "--fail-on", "never"], capture);
    findings(engine, capture, &told);
    nodes(engine, capture, &told);
    statistics(engine, capture, &told);
}

fn findings(engine: &Engine, capture: &Path, told: &Value) {
    let rows = engine.table("findings", capture);
    let found = told["findings"].as_array().unwrap();
    assert_eq!(rows.len(), found.len(), "{}", capture.display());
    let names = [
        "rule", "severity", "t", "t_last", "count", "node", "origin", "channel", "object", "title", "message", "advice",
    ];
    for (row, finding) in rows.iter().zip(found) {
        assert_eq!(reduced(row, &names), reduced(finding, &names), "{}", capture.display());
        let evidence: Value = serde_json::from_str(row["evidence"].as_str().unwrap()).unwrap();
        assert_eq!(evidence, finding["evidence"]);
        if let Some(id) = finding["case"]["id"].as_str() {
            assert_eq!(row["test_case"], id);
        }
    }
}

fn nodes(engine: &Engine, capture: &Path, told: &Value) {
    let rows = engine.table("nodes", capture);
    let nodes = told["nodes"].as_array().unwrap();
    assert_eq!(rows.len(), nodes.len(), "{}", capture.display());
    let same = ["node", "channel", "present", "frames", "bits", "load_percent", "boot_ups"];
    let identity = [
        "device_type",
        "vendor_id",
        "product_code",
        "revision_number",
        "serial_number",
        "name",
        "hardware_version",
        "software_version",
    ];
    for (row, node) in rows.iter().zip(nodes) {
        assert_eq!(reduced(row, &same), reduced(node, &same), "{}", capture.display());
        assert_eq!(reduced(row, &identity), reduced(&node["identity"], &identity), "{}", capture.display());
        assert_eq!((&row["t"], &row["t_last"]), (&node["first_t"], &node["last_t"]));
        assert_eq!((&row["sdo_completed"], &row["sdo_aborted"]), (&node["sdo"]["completed"], &node["sdo"]["aborted"]));
        for part in ["min", "p50", "p95", "p99", "max"] {
            assert_eq!(row[format!("sdo_response_{part}_ns")], node["sdo"]["response_ns"][part], "{part}");
        }
        let counted = |service: &str| node["counts"][service].as_u64().unwrap_or(0);
        assert_eq!(
            (row["heartbeats"].as_u64(), row["emcys"].as_u64()),
            (Some(counted("heartbeat")), Some(counted("emcy")))
        );
    }
}

fn statistics(engine: &Engine, capture: &Path, told: &Value) {
    let rows = engine.table("statistics", capture);
    let mut rows = rows.iter();
    for bus in told["buses"].as_array().unwrap() {
        let whole = rows.next().unwrap();
        let same = ["channel", "frames", "bits", "load_percent", "bit_rate", "copies"];
        assert_eq!(reduced(whole, &same), reduced(bus, &same), "{}", capture.display());
        assert_eq!((&whole["t"], &whole["t_last"]), (&bus["first_t"], &bus["last_t"]));
        for (at, column) in [("t", "peak_t"), ("percent", "peak_percent")] {
            assert_eq!(whole[column], bus["peak"][at], "{}", capture.display());
        }
        let counts = bus["counts"].as_object().unwrap();
        let of_services: Vec<&Value> = rows.by_ref().take(counts.len()).collect();
        for row in of_services {
            let service = row["service"].as_str().unwrap();
            assert_eq!((&row["frames"], &row["frames_per_second"]), (&counts[service], &bus["rates"][service]));
            let load = &bus["load_by_service"][service];
            assert_eq!(row["bits"], load.get("bits").cloned().unwrap_or_else(|| json!(0)), "{service}");
        }
    }
    assert!(rows.next().is_none(), "{}", capture.display());
}

fn quality(engine: &Engine, capture: &Path) {
    let told = written(&["decode", "--quality", "json", "--quality-out"], capture);
    let (rows, source) = (engine.table("captures", capture), &told["sources"][0]);
    assert_eq!(rows.len(), 1);
    let row = &rows[0];
    for (column, name) in [
        ("format", "format"),
        ("time_base", "time_base"),
        ("t", "first_t"),
        ("t_last", "last_t"),
        ("duration_ns", "duration_ns"),
        ("frames", "frames"),
        ("resolution_ns", "resolution_ns"),
    ] {
        assert_eq!(row[column], source[name], "{column}: {}", capture.display());
    }
    for kind in ["standard", "extended", "remote", "error", "fd", "xl"] {
        assert_eq!(row[kind], source["kinds"][kind], "{kind}: {}", capture.display());
    }
    for (column, kind) in [
        ("malformed", "malformed"),
        ("truncated", "truncated"),
        ("unsupported", "unsupported"),
        ("lost", "dropped"),
        ("unfinished", "unfinished"),
    ] {
        assert_eq!(row[column], source["damages"][kind], "{column}: {}", capture.display());
    }
    let steps = &source["clock_steps_back"]["count"];
    assert_eq!((&row["clock_steps_back"], &row["gaps"]), (steps, &source["gaps"]["count"]));
    let content = std::fs::read(capture).unwrap();
    let sha256: String =
        <sha2::Sha256 as sha2::Digest>::digest(&content).iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!((row["sha256"].as_str(), row["size"].as_u64()), (Some(&*sha256), Some(content.len() as u64)));
}
