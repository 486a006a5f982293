//! The page in a browser gives the same bytes as the program.

use crate::opened::Opened;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Formats of `canvass diagnose`, and the names of the files that the page saves in these formats.
const DIAGNOSES: [(&str, &str); 5] = [
    ("html", "diagnosis.html"),
    ("json", "diagnosis.json"),
    ("markdown", "diagnosis.md"),
    ("junit", "diagnosis.xml"),
    ("table", "diagnosis.txt"),
];
const EXPORTS: [&[&str]; 8] = [
    &["decode", "--format", "text"],
    &["decode", "--format", "table"],
    &["decode", "--format", "csv"],
    &["decode", "--format", "json"],
    &["decode", "--events", "--format", "text"],
    &["decode", "--events", "--format", "json"],
    &["signals", "--format", "csv"],
    &["signals", "--format", "json"],
];

/// A script that keeps the bytes of a saved file instead of saving them.
const KEEP: &str = "
    const blobs = new Map();
    const make = URL.createObjectURL;
    URL.createObjectURL = (blob) => { const url = make(blob); blobs.set(url, blob); return url; };
    window.saved = {};
    HTMLAnchorElement.prototype.click = function () {
        const { download } = this;
        blobs.get(this.href).arrayBuffer().then((bytes) => {
            window.saved[download] = [...new Uint8Array(bytes)].map((byte) => String.fromCharCode(byte)).join('');
        });
    };";

fn samples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("traces/samples")
}

/// The output of the program about a sample, with one character for each byte.
fn printed(args: &[&str], name: &str) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_canvass"));
    command.args(args).arg(name).current_dir(samples());
    let ended = command.env("SOURCE_DATE_EPOCH", "1750000000").env("NO_COLOR", "1").output().unwrap();
    ended.stdout.into_iter().map(char::from).collect()
}

/// A page that believes it runs on this computer on a given day.
fn here() -> Opened {
    let told: Value = serde_json::from_str(&printed(&["diagnose", "--format", "json"], "python-can.log")).unwrap();
    let host = &told["provenance"]["host"];
    let surroundings = json!({
        "host": host["name"], "system": host["system"], "date": "2025-06-15T15:06:40+00:00", "zone": "UTC",
    });
    let script = format!(
        "const post = Worker.prototype.postMessage;
         Worker.prototype.postMessage = function (message, ...more) {{
             if (message.call === 'start') message.args.surroundings = {surroundings};
             return post.call(this, message, ...more);
         }};"
    );
    Opened::prepared(|browser| {
        browser.command("Page.addScriptToEvaluateOnNewDocument", &json!({ "source": script }));
    })
}

#[test]
fn every_sample_gives_the_same_bytes_as_the_program() {
    let opened = here();
    opened.browser.run(KEEP);
    let names = std::fs::read_dir(samples()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let is_capture = |name: &String| ![".frames", ".py", ".md"].iter().any(|ending| name.ends_with(ending));
    let names: Vec<_> = names.filter(is_capture).collect();
    assert!(names.len() > 20, "{names:?}");
    for name in names {
        opened.view("diagnosis");
        opened.take(&[samples().join(&name)]);
        opened.browser.wait(&format!(
            "document.getElementById('names').textContent === '{name}' && document.querySelector('#view-diagnosis iframe')"
        ));
        opened.browser.run("window.saved = {}; document.querySelectorAll('#view-diagnosis .bar > button').forEach((one) => one.click())");
        for (format, file) in DIAGNOSES {
            same(&opened, file, &["diagnose", "--format", format], &name);
        }
        opened.view("export");
        for (at, args) in EXPORTS.iter().enumerate() {
            opened.browser.run(&format!(
                "window.saved = {{}}; document.querySelectorAll('#view-export .buttons button')[{at}].click()"
            ));
            opened.browser.wait("Object.keys(window.saved).length === 1");
            let file = opened.browser.text("return Object.keys(window.saved)[0]");
            same(&opened, &file, args, &name);
        }
    }
    opened.browser.is_quiet();
}

#[track_caller]
fn same(opened: &Opened, file: &str, args: &[&str], name: &str) {
    opened.browser.wait(&format!("'{file}' in window.saved"));
    let ours = opened.browser.text(&format!("return window.saved['{file}']"));
    assert!(ours == printed(args, name), "canvass {} {name} gives other bytes than {file}", args.join(" "));
}
