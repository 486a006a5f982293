//! Measures checks of device descriptions, and response times in an editor.

mod editor;

use crate::measure::{best, release};
use crate::run::run;
use anyhow::{Context, Result};
use editor::Editor;
use std::fs;

const FOLDER: &str = "target/bench/descriptions";
/// Number of files, and of objects in each.
const CHECKED: (u32, u32) = (1_000, 500);
/// Number of objects in the file that the editor opens.
const LARGE: u32 = 10_000;

/// Checks many files, and edits a large file twice: without findings, and with thousands of findings.
///
/// # Errors
/// If a program can't be run or the language server sends an unexpected message.
pub fn describing() -> Result<()> {
    println!("\ndevice descriptions");
    run("cargo", &["build", "--release", "--locked", "--package", "canvass-analyzer", "--example", "descriptions"])?;
    let (files, objects) = CHECKED;
    let bytes = write("many", files, objects, "")?;
    let many = format!("{FOLDER}/many");
    let cost = best(&[&release("canvass"), "eds", "check", "--fail-on", "never", &many], None)?;
    println!(
        "canvass eds check: {files} files of {objects} objects, {:.0} MB: {:.2} s of processor time, {:.1} MiB",
        bytes as f64 / 1e6,
        cost.cpu,
        cost.memory as f64 / 1024.0
    );
    for (name, more) in [("large", ""), ("findings", "findings")] {
        write(name, 1, LARGE, more)?;
        let path = format!("{FOLDER}/{name}/0000.eds");
        edit(&path).with_context(|| format!("canvass lsp with {path}"))?;
    }
    Ok(())
}

/// Makes the files anew; returns their total size.
fn write(name: &str, files: u32, objects: u32, more: &str) -> Result<u64> {
    let folder = format!("{FOLDER}/{name}");
    fs::remove_dir_all(&folder).or_else(|error| match error.kind() {
        std::io::ErrorKind::NotFound => Ok(()),
        _ => Err(error),
    })?;
    fs::create_dir_all(&folder)?;
    let (files, objects) = (files.to_string(), objects.to_string());
    let words = [&*folder, &*files, &*objects, more];
    let words: Vec<&str> = words.into_iter().filter(|word| !word.is_empty()).collect();
    run(&release("examples/descriptions"), &words)?;
    let sizes = fs::read_dir(&folder)?.map(|entry| Ok(entry?.metadata()?.len()));
    sizes.sum::<Result<u64>>()
}

/// Prints response times, from the request to the last byte of the answer.
fn edit(path: &str) -> Result<()> {
    let text = fs::read_to_string(path)?;
    let line_of = |text: &str, wanted: &str| text.lines().position(|line| line == wanted).unwrap_or(0);
    let middle = line_of(&text, "[30D5]");
    let mut editor = Editor::start(&release("canvass"), &text)?;
    println!(
        "canvass lsp: a file of {LARGE} objects, {:.1} MB, with {} findings; the answer takes at best (and in the middle)",
        text.len() as f64 / 1e6,
        editor.findings
    );
    editor.measured("findings after a change", |editor| editor.change(middle + 1, "ParameterName=Another"))?;
    editor.measured("hover", |editor| editor.ask_at("textDocument/hover", (middle, 2)))?;
    editor.measured("completion of a value", |editor| editor.ask_at("textDocument/completion", (middle + 3, 9)))?;
    editor.measured("go to an object", |editor| editor.ask_at("textDocument/definition", (middle, 2)))?;
    editor.measured("all places of an object", |editor| editor.ask_references((middle, 2)))?;
    editor.measured("edits of a place", |editor| editor.ask_actions(middle))?;
    editor.measured("outline", Editor::ask_outline)?;
    // A section that is being typed.
    editor.write(middle, "[10")?;
    editor.measured("completion of an object", |editor| editor.ask_at("textDocument/completion", (middle, 3)))?;
    editor.end()
}
