//! The mutated workspace: links to the crates, and a rewritten copy of the mutated crate.

use super::area::{self, Area};
use super::constants::called_in_constants;
use super::find::{Findings, find};
use super::rewrite::{Rewritten, rewrite};
use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Maximum number of builds after which mutants that can't be compiled are removed.
const ROUNDS: u32 = 12;
/// A profile that compiles quickly.
const PROFILE: &str =
    "[profile.mutants]\ninherits = \"release\"\nlto = false\ncodegen-units = 16\ndebug = false\nincremental = true\n";

/// A source file with its points.
pub struct Source {
    /// The path below the folder of the area's sources.
    pub path: String,
    pub service: &'static str,
    pub text: String,
    pub found: Findings,
    /// The number of the first mutant in the file.
    pub first: u32,
}

/// Reads all mutated files.
pub fn read(area: &Area) -> Result<Vec<Source>> {
    let mut texts = Vec::new();
    let mut constants = BTreeSet::new();
    for path in files(Path::new(area.folder))? {
        if path.extension().is_none_or(|extension| extension != "rs") {
            continue;
        }
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        constants.extend(called_in_constants(&text).with_context(|| path.display().to_string())?);
        if let Ok(below) = path.strip_prefix(area.sources) {
            texts.push((below.to_string_lossy().into_owned(), text));
        }
    }
    texts.sort();
    let mut sources = Vec::new();
    for (path, text) in texts {
        let Some(service) = area.service(&path) else { continue };
        let found = find(&text, &constants).with_context(|| path.clone())?;
        sources.push(Source { path, service, text, found, first: 0 });
    }
    Ok(sources)
}

/// Writes the workspace with all mutants of these files; mutants that can't be compiled are removed.
pub fn prepare(area: &Area, sources: &mut [Source]) -> Result<()> {
    lay_out(area)?;
    for _ in 0..ROUNDS {
        let rewritten = write(area, sources)?;
        let errors = check(area)?;
        if errors.is_empty() {
            return Ok(());
        }
        let taken_out = take_out(area, sources, &rewritten, &errors);
        eprintln!("{taken_out} places can't be changed so that it compiles");
        if taken_out == 0 {
            let shown: Vec<String> = errors.iter().take(5).map(|error| error.text.clone()).collect();
            bail!("the mutated crate does not compile:\n{}", shown.join("\n"));
        }
    }
    bail!("the mutated crate does not compile after {ROUNDS} rounds")
}

/// Creates links to all crates, and a copy of the mutated crate.
fn lay_out(area: &Area) -> Result<()> {
    let root = std::env::current_dir()?;
    let scratch = area.scratch();
    std::fs::create_dir_all(scratch.join("conformance"))?;
    for linked in area.linked() {
        let link = scratch.join(linked);
        if std::fs::symlink_metadata(&link).is_err() {
            std::os::unix::fs::symlink(root.join(linked), &link).with_context(|| link.display().to_string())?;
        }
    }
    for file in files(Path::new(area.folder))? {
        let is_mutated =
            file.strip_prefix(area.sources).is_ok_and(|path| area.service(&path.to_string_lossy()).is_some());
        let is_root = file == Path::new(area.folder).join("src/lib.rs");
        if is_root {
            let text = std::fs::read_to_string(&file)?;
            write_if_new(&scratch.join(&file), format!("{text}\n#[doc(hidden)]\npub mod mutant;\n").as_bytes())?;
        } else if !is_mutated {
            write_if_new(&scratch.join(&file), &std::fs::read(&file)?)?;
        }
    }
    write_if_new(&scratch.join(area.folder).join("src/mutant.rs"), include_bytes!("switch.rs"))?;
    write_if_new(&scratch.join("Cargo.toml"), manifest(area)?.as_bytes())?;
    if !scratch.join("Cargo.lock").exists() {
        std::fs::copy("Cargo.lock", scratch.join("Cargo.lock"))?;
    }
    Ok(())
}

/// The manifest of the workspace, without the program.
fn manifest(area: &Area) -> Result<String> {
    let manifest = std::fs::read_to_string("Cargo.toml")?;
    let (_, dependencies) =
        manifest.split_once("[workspace.package]").context("Cargo.toml has no [workspace.package]")?;
    let (dependencies, _) =
        dependencies.split_once("\n[package]").context("Cargo.toml has no [package] after [workspace.package]")?;
    let members: Vec<String> = area::CRATES.iter().map(|name| format!("\"{name}\"")).collect();
    let members = members.join(", ");
    // A crate whose own tests look for its mutants is not optimised: each change of a test compiles the crate again,
    // and optimising it would take longer than its quick tests.
    let optimised = match area.name {
        "device" => "opt-level = 2\n".to_owned(),
        _ => format!("opt-level = 1\n\n[profile.mutants.package.{}]\nopt-level = 0\n", area.package),
    };
    Ok(format!(
        "[workspace]\nmembers = [{members}]\nresolver = \"3\"\n\n[workspace.package]{dependencies}\n{PROFILE}{optimised}"
    ))
}

/// Numbers the mutants of all files, and writes the files.
fn write(area: &Area, sources: &mut [Source]) -> Result<Vec<Rewritten>> {
    let mut next = 1;
    let mut all = Vec::new();
    for source in sources.iter_mut() {
        source.first = next;
        next += source.found.points.iter().map(|point| point.variants.len() as u32).sum::<u32>();
        let rewritten = rewrite(&source.text, &source.found, source.first);
        write_if_new(&area.scratch().join(area.sources).join(&source.path), rewritten.text.as_bytes())?;
        all.push(rewritten);
    }
    Ok(all)
}

/// An error of the compiler.
struct Mistake {
    text: String,
    /// The places that the error names: file, first byte and end.
    places: Vec<(String, usize, usize)>,
}

/// A call of cargo in the mutated workspace.
pub fn cargo(area: &Area, arguments: &[&str]) -> Command {
    let mut command = Command::new("cargo");
    command.args(arguments).current_dir(area.scratch());
    // Warnings are off: it is normal that mutants leave code unused or unreachable.
    command.env("RUSTFLAGS", "--cap-lints=allow").env_remove("CARGO_TARGET_DIR");
    command
}

/// Builds the crate with its dependencies, which the tests of the crate then need not build. Returns the errors of the
/// compiler.
fn check(area: &Area) -> Result<Vec<Mistake>> {
    let arguments = ["build", "--profile", "mutants", "--package", area.package, "--message-format=json"];
    let output = cargo(area, &arguments).stderr(Stdio::null()).output().context("cargo build")?;
    let lines = String::from_utf8_lossy(&output.stdout).into_owned();
    let messages = lines.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let mistakes: Vec<Mistake> = messages.filter_map(|line| mistake(line.get("message")?)).collect();
    if mistakes.is_empty() && !output.status.success() {
        bail!("cargo build of the mutated crate ended with {}", output.status);
    }
    Ok(mistakes)
}

fn mistake(message: &Value) -> Option<Mistake> {
    if message.get("level")?.as_str()? != "error" {
        return None;
    }
    let spans = message.get("spans")?.as_array()?;
    let place = |span: &Value| {
        let file = span.get("file_name")?.as_str()?.to_owned();
        let at = |name: &str| span.get(name)?.as_u64().map(|byte| byte as usize);
        Some((file, at("byte_start")?, at("byte_end")?))
    };
    let (mut primary, other): (Vec<&Value>, Vec<&Value>) =
        spans.iter().partition(|span| span.get("is_primary").and_then(Value::as_bool) == Some(true));
    primary.extend(other);
    let places: Vec<_> = primary.into_iter().filter_map(place).collect();
    let text = message.get("rendered")?.as_str()?.to_owned();
    (!places.is_empty()).then_some(Mistake { text, places })
}

/// Removes the innermost point around each error, or the points inside it if no point is around it. Returns the number
/// of removed points.
fn take_out(area: &Area, sources: &mut [Source], rewritten: &[Rewritten], mistakes: &[Mistake]) -> usize {
    let mut taken_out: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    let named = |file: &str| sources.iter().position(|source| file == format!("{}/{}", area.sources, source.path));
    for mistake in mistakes {
        let around = mistake.places.iter().find_map(|(file, start, end)| {
            let source = named(file)?;
            let places = rewritten[source].places.iter().enumerate();
            let around = places.filter(|(_, place)| place.start <= *start && *end <= place.end);
            let (innermost, _) = around.min_by_key(|(_, place)| place.len())?;
            Some((source, innermost))
        });
        if let Some((source, point)) = around {
            taken_out.entry(source).or_default().insert(point);
            continue;
        }
        for (file, start, end) in &mistake.places {
            let Some(source) = named(file) else { continue };
            let places = rewritten[source].places.iter().enumerate();
            let inside = places.filter(|(_, place)| *start <= place.start && place.end <= *end);
            taken_out.entry(source).or_default().extend(inside.map(|(point, _)| point));
        }
    }
    for (source, points) in &taken_out {
        let mut position = 0;
        sources[*source].found.points.retain(|_| {
            position += 1;
            !points.contains(&(position - 1))
        });
    }
    taken_out.values().map(BTreeSet::len).sum()
}

/// All files below a folder.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() {
            found.extend(files(&path)?);
        } else {
            found.push(path);
        }
    }
    Ok(found)
}

/// Writes a file only if its content changes: an unchanged file keeps its time, so that cargo does not rebuild it.
fn write_if_new(path: &Path, text: &[u8]) -> Result<()> {
    if std::fs::read(path).is_ok_and(|before| before == text) {
        return Ok(());
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    std::fs::write(path, text).with_context(|| path.display().to_string())
}
