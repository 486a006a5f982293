//! The mutated workspace: the crates as they are, by links, and the one of the simulated devices rewritten.

use super::covered;
use super::find::{Findings, called_in_constants, find};
use super::honest::Hooks;
use super::rewrite::{Rewritten, rewrite};
use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where the mutated workspace is built.
pub const FOLDER: &str = "target/mutants";
/// The crate that is mutated, and its files that are.
const DEVICE: &str = "conformance/device";
const SOURCES: &str = "conformance/device/src/device";
/// What its tests are made with; the others need no more than a link.
const LINKED: [&str; 7] =
    ["traces", "analyzer", "conformance/bus", "conformance/suite", "conformance/fuzz", "conformance/macros", "docs"];
/// So often mutants that can't be compiled are taken out.
const ROUNDS: u32 = 12;
/// Optimised enough to run, and soon built.
const PROFILE: &str = "[profile.mutants]\ninherits = \"release\"\nlto = false\ncodegen-units = 16\nopt-level = 2\ndebug = false\nincremental = true\n";

/// A file with what can be changed in it.
pub struct Source {
    /// Below [`SOURCES`].
    pub path: String,
    pub service: &'static str,
    pub text: String,
    pub found: Findings,
    /// The number of its first mutant.
    pub first: u32,
}

/// Reads all files that are mutated.
pub fn read() -> Result<Vec<Source>> {
    let mut texts = Vec::new();
    let mut constants = BTreeSet::new();
    let mut hooks = Hooks::default();
    for path in files(Path::new(DEVICE).join("src").as_path())? {
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        constants.extend(called_in_constants(&text)?);
        hooks.add(&text);
        if let Ok(below) = path.strip_prefix(SOURCES) {
            texts.push((below.to_string_lossy().into_owned(), text));
        }
    }
    texts.sort();
    let mut sources = Vec::new();
    for (path, text) in texts {
        let Some(service) = covered::service(&path) else { continue };
        let found = find(&text, &constants, &hooks).with_context(|| path.clone())?;
        sources.push(Source { path, service, text, found, first: 0 });
    }
    Ok(sources)
}

/// Builds the program with all mutants of these files that can be compiled; the others are taken out.
pub fn build(sources: &mut [Source]) -> Result<PathBuf> {
    lay_out()?;
    for _ in 0..ROUNDS {
        let rewritten = write(sources)?;
        let errors = check()?;
        if errors.is_empty() {
            return compile();
        }
        let taken_out = take_out(sources, &rewritten, &errors);
        eprintln!("{taken_out} places can't be changed so that it compiles");
        if taken_out == 0 {
            let shown: Vec<String> = errors.iter().take(5).map(|error| error.text.clone()).collect();
            bail!("the mutated crate does not compile:\n{}", shown.join("\n"));
        }
    }
    bail!("the mutated crate does not compile after {ROUNDS} rounds")
}

/// Links to all crates, and a copy of the one that is mutated.
fn lay_out() -> Result<()> {
    let root = std::env::current_dir()?;
    let scratch = Path::new(FOLDER);
    std::fs::create_dir_all(scratch.join("conformance"))?;
    for linked in LINKED {
        let link = scratch.join(linked);
        if std::fs::symlink_metadata(&link).is_err() {
            std::os::unix::fs::symlink(root.join(linked), &link).with_context(|| link.display().to_string())?;
        }
    }
    let device = scratch.join(DEVICE);
    for file in files(Path::new(DEVICE))? {
        let copy = device.join(file.strip_prefix(DEVICE)?);
        let is_mutated =
            file.strip_prefix(SOURCES).is_ok_and(|path| covered::service(&path.to_string_lossy()).is_some());
        if !is_mutated && !file.ends_with("src/lib.rs") {
            write_if_new(&copy, &std::fs::read(&file)?)?;
        }
    }
    let library = std::fs::read_to_string(Path::new(DEVICE).join("src/lib.rs"))?;
    write_if_new(
        &device.join("src/lib.rs"),
        library.replacen("mod damage;", "pub mod mutant;\nmod damage;", 1).as_bytes(),
    )?;
    write_if_new(&device.join("src/mutant.rs"), include_bytes!("switch.rs"))?;
    let manifest = std::fs::read_to_string("Cargo.toml")?;
    let (_, dependencies) = manifest.split_once("[workspace.package]").context("[workspace.package] in Cargo.toml")?;
    let (dependencies, _) = dependencies.split_once("\n[package]").context("[package] in Cargo.toml")?;
    let members = "[workspace]\nmembers = [\"traces\", \"analyzer\", \"conformance/bus\", \"conformance/device\", \"conformance/suite\", \"conformance/fuzz\", \"conformance/macros\"]\nresolver = \"3\"\n\n";
    write_if_new(
        &scratch.join("Cargo.toml"),
        format!("{members}[workspace.package]{dependencies}\n{PROFILE}").as_bytes(),
    )?;
    if !scratch.join("Cargo.lock").exists() {
        std::fs::copy("Cargo.lock", scratch.join("Cargo.lock"))?;
    }
    Ok(())
}

/// Numbers the mutants of all files and writes them.
fn write(sources: &mut [Source]) -> Result<Vec<Rewritten>> {
    let mut next = 1;
    let mut all = Vec::new();
    for source in sources.iter_mut() {
        source.first = next;
        next += source.found.points.iter().map(|point| point.variants.len() as u32).sum::<u32>();
        let rewritten = rewrite(&source.text, &source.found, source.first);
        write_if_new(&Path::new(FOLDER).join(SOURCES).join(&source.path), rewritten.text.as_bytes())?;
        all.push(rewritten);
    }
    Ok(all)
}

/// Where the compiler was not content.
struct Mistake {
    text: String,
    /// The file and the bytes of it, by each place that the message names.
    places: Vec<(String, usize, usize)>,
}

fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new("cargo");
    command.args(arguments).current_dir(FOLDER);
    // What a mutant leaves unused or makes unreachable is its nature.
    command.env("RUSTFLAGS", "--cap-lints=allow").env_remove("CARGO_TARGET_DIR");
    command
}

fn check() -> Result<Vec<Mistake>> {
    let arguments = ["check", "--profile", "mutants", "--package", "canvass-device", "--message-format=json"];
    let output = cargo(&arguments).stderr(Stdio::null()).output().context("cargo check")?;
    let lines = String::from_utf8_lossy(&output.stdout).into_owned();
    let messages = lines.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let mistakes: Vec<Mistake> = messages.filter_map(|line| mistake(line.get("message")?)).collect();
    if mistakes.is_empty() && !output.status.success() {
        bail!("cargo check of the mutated crate ended with {}", output.status);
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

/// Takes out the innermost point at each mistake. How many were taken out.
fn take_out(sources: &mut [Source], rewritten: &[Rewritten], mistakes: &[Mistake]) -> usize {
    let mut taken_out: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for mistake in mistakes {
        let guilty = mistake.places.iter().find_map(|(file, start, end)| {
            let source = sources.iter().position(|source| file.ends_with(&format!("src/device/{}", source.path)))?;
            let places = rewritten[source].places.iter().enumerate();
            let around = places.filter(|(_, place)| place.start <= *start && *end <= place.end);
            let (innermost, _) = around.min_by_key(|(_, place)| place.len())?;
            Some((source, innermost))
        });
        if let Some((source, point)) = guilty {
            taken_out.entry(source).or_default().insert(point);
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

fn compile() -> Result<PathBuf> {
    eprintln!("building the program with all mutants");
    let arguments = ["build", "--profile", "mutants", "--package", "canvass-fuzzer", "--example", "mutant"];
    let status = cargo(&arguments).status().context("cargo build")?;
    if !status.success() {
        bail!("the mutated workspace does not build: {status}");
    }
    Ok(std::env::current_dir()?.join(FOLDER).join("target/mutants/examples/mutant"))
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

/// A file that has not changed keeps its time, so that it is not built anew.
fn write_if_new(path: &Path, text: &[u8]) -> Result<()> {
    if std::fs::read(path).is_ok_and(|before| before == text) {
        return Ok(());
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    std::fs::write(path, text).with_context(|| path.display().to_string())
}
