//! `cargo xtask docs`: the book, in `target/book`: the hand-written chapters and the reference pages that the program
//! prints. It first writes the JSON Schemas in `docs/schemas`, which other programs take from the repository, and
//! checks all links.

mod links;

use crate::consent;
use crate::run::{run, target_folder};
use anyhow::{Context, Result, bail, ensure};
use std::fs;
use std::path::Path;
use std::process::Command;

/// The source of the book, laid out as the repository: so a link works here, in a checkout and on GitHub.
const SOURCE: &str = "target/book-source";
/// The output folder, as in `docs/book.toml`.
const BOOK: &str = "target/book";
/// Chapters outside `docs`.
const PAGES: [&str; 4] = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md"];
/// The lists that `canvass list` prints as Markdown: one page each, in the folder `reference`.
const REFERENCE: [&str; 4] = ["cases", "rules", "eds-rules", "faults"];

const MDBOOK: &str = "target/tools/bin/mdbook";
const VERSION: &str = "0.5.4";

/// Writes the schemas, builds the book and checks its links.
///
/// # Errors
/// If mdBook is missing, a chapter can't be made, or a link leads nowhere.
pub fn docs() -> Result<()> {
    run("cargo", &["run", "--quiet", "--locked", "--package", "canvass-reports", "--example", "schemas"])?;
    run("cargo", &["build", "--locked", "--bin", "canvass"])?;
    book(&target_folder().join("debug/canvass"))
}

/// Builds the book with the pages that this program prints.
///
/// # Errors
/// As [`docs`].
pub fn book(program: &Path) -> Result<()> {
    install()?;
    chapters(Path::new(SOURCE), program)?;
    run(MDBOOK, &["build", SOURCE])?;
    let broken = links::broken(Path::new(BOOK))?;
    ensure!(broken.is_empty(), "{} links of the book lead nowhere:\n{}", broken.len(), broken.join("\n"));
    eprintln!("{BOOK}/index.html");
    Ok(())
}

/// Installs mdBook without optimisation: an optimised build takes longer, and the book takes a second in either case.
fn install() -> Result<()> {
    let installed = Command::new(MDBOOK).arg("--version").output().ok();
    if installed.is_some_and(|output| String::from_utf8_lossy(&output.stdout).trim().ends_with(VERSION)) {
        return Ok(());
    }
    let of_cargo = ["install", "mdbook", "--version", VERSION, "--locked", "--root", "target/tools", "--debug"];
    let features = ["--no-default-features", "--features", "search", "--quiet"];
    let words = [&of_cargo[..], &features].concat();
    consent::ask("mdBook", &format!("cargo {}", words.join(" ")))?;
    run("cargo", &words)
}

/// Copies the hand-written chapters, and lets the program print the others.
fn chapters(source: &Path, program: &Path) -> Result<()> {
    if source.exists() {
        fs::remove_dir_all(source)?;
    }
    let pages = source.join("src");
    fs::create_dir_all(pages.join("reference"))?;
    copy(Path::new("docs"), &pages.join("docs"))?;
    fs::rename(pages.join("docs/book.toml"), source.join("book.toml"))?;
    fs::rename(pages.join("docs/SUMMARY.md"), pages.join("SUMMARY.md"))?;
    for page in PAGES {
        fs::copy(page, pages.join(page)).with_context(|| format!("can't copy {page}"))?;
    }
    for what in REFERENCE {
        fs::write(pages.join(format!("reference/{what}.md")), printed(program, what)?)?;
    }
    unlisted(&pages)
}

/// The page of a list that the program prints.
fn printed(program: &Path, what: &str) -> Result<Vec<u8>> {
    let output = Command::new(program).args(["list", what, "--format", "markdown"]).output();
    let output = output.with_context(|| format!("can't run {}", program.display()))?;
    if !output.status.success() {
        bail!("canvass list {what} ended with {}: {}", output.status, String::from_utf8_lossy(&output.stderr));
    }
    Ok(output.stdout)
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let to = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &to)?;
        } else {
            fs::copy(entry.path(), to)?;
        }
    }
    Ok(())
}

/// mdBook ignores pages that its summary does not name, so they are reported here.
fn unlisted(pages: &Path) -> Result<()> {
    let summary = fs::read_to_string(pages.join("SUMMARY.md"))?;
    for entry in fs::read_dir(pages.join("docs"))? {
        let name = format!("docs/{}", entry?.file_name().to_string_lossy());
        let is_chapter = !name.ends_with(".md") || summary.contains(&format!("({name})"));
        ensure!(is_chapter, "{name} is no chapter of the book: add it to docs/SUMMARY.md");
    }
    Ok(())
}
