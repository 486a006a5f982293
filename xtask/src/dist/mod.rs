//! `cargo xtask dist`: the release files, in `target/dist`: archives and packages of a static program for Linux on two
//! processors, the program for Windows with its installer, the page, the wheels, the extension of an editor, and the
//! checksums and components of all. `--check` installs each one in a clean place, runs and removes it.

mod archives;
mod check;
mod components;
mod container;
mod debian;
mod editor;
mod manifests;
mod npm;
mod pipelines;
mod rpm;
mod system;
mod tools;
mod windows_installer;

use crate::python;
use anyhow::{Context, Result, bail, ensure};
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The folder of the release files.
pub const FOLDER: &str = "target/dist";
/// The version of the release. Only `Cargo.toml` sets it.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Names the address at which the release files can be fetched, for the files that name it.
const ADDRESS: &str = "CANVASS_ADDRESS";

/// The option that checks instead of making.
pub const CHECK: &str = "--check";

/// A part of the release.
struct Part {
    /// Its name on the command line.
    id: &'static str,
    /// Its name in messages.
    name: &'static str,
    /// Fetches its tools; fails if they are not available here.
    prepare: fn() -> Result<()>,
    /// Makes the part; returns the names of its files.
    make: fn() -> Result<Vec<String>>,
    /// Installs the part in a clean place, runs it and removes it.
    check: fn() -> Result<String>,
}

/// The parts in the order in which one stands on another: all packages hold the programs of the first two.
const PARTS: [Part; 14] = [
    Part {
        id: "linux",
        name: "the programs for Linux",
        prepare: archives::prepare_linux,
        make: archives::linux,
        check: check::archives::linux,
    },
    Part {
        id: "windows",
        name: "the program for Windows",
        prepare: archives::prepare_windows,
        make: archives::windows,
        check: check::archives::windows,
    },
    Part {
        id: "deb",
        name: "the Debian packages",
        prepare: debian::prepare,
        make: debian::make,
        check: check::debian::install,
    },
    Part { id: "rpm", name: "the RPM packages", prepare: rpm::prepare, make: rpm::make, check: check::rpm::install },
    Part {
        id: windows_installer::ID,
        name: "the installer for Windows",
        prepare: windows_installer::prepare,
        make: windows_installer::make,
        check: check::windows_installer::install,
    },
    Part {
        id: "manifests",
        name: "the manifests of scoop and winget",
        prepare: || Ok(()),
        make: manifests::make,
        check: check::manifests::validate,
    },
    Part {
        id: pipelines::ID,
        name: "the scripts for pipelines",
        prepare: || Ok(()),
        make: pipelines::make,
        check: check::pipelines::run,
    },
    Part {
        id: "container",
        name: "the container images",
        prepare: container::prepare,
        make: container::make,
        check: check::container::run,
    },
    Part { id: "npm", name: "the npm packages", prepare: npm::prepare, make: npm::make, check: check::npm::install },
    Part {
        id: "vsix",
        name: "the extension of Visual Studio Code",
        prepare: editor::prepare,
        make: editor::make,
        check: check::editor::unpack,
    },
    Part {
        id: "wheel",
        name: "the Python wheels",
        prepare: python::install,
        make: wheels,
        check: check::registries::wheel,
    },
    Part {
        id: "page",
        name: "the page",
        prepare: archives::prepare_page,
        make: archives::page,
        check: check::archives::page,
    },
    Part {
        id: "components",
        name: "the list of components",
        prepare: components::prepare,
        make: components::make,
        check: check::components::validate,
    },
    Part {
        id: "crates",
        name: "the libraries for crates.io",
        prepare: || Ok(()),
        make: || Ok(Vec::new()),
        check: check::registries::publish,
    },
];

fn part(id: &str) -> Result<&'static Part> {
    let ids = || PARTS.iter().map(|part| part.id).collect::<Vec<_>>().join(", ");
    PARTS.iter().find(|part| part.id == id).with_context(|| format!("expected one of {}, found {id}", ids()))
}

/// Makes the parts that are named, all of them if none is; with `--check`, checks those that were made. A part with a
/// missing tool is left out with a message; the others are made.
///
/// # Errors
/// If a part can't be made, does not work or was left out.
pub fn dist(words: &[String]) -> Result<()> {
    let named: Vec<&str> = words.iter().map(String::as_str).filter(|word| *word != CHECK).collect();
    let parts: Vec<&Part> = match named[..] {
        [] => PARTS.iter().collect(),
        _ => named.iter().map(|id| part(id)).collect::<Result<_>>()?,
    };
    if words.iter().any(|word| word == CHECK) {
        return check::all(&parts);
    }
    std::fs::create_dir_all(FOLDER)?;
    let mut left_out = Vec::new();
    for Part { id, name, prepare, make, .. } in parts {
        match prepare() {
            Ok(()) => note(id, &make().with_context(|| (*name).to_owned())?)?,
            Err(missing) => left_out.push(format!("{name} was left out: {missing:#}")),
        }
    }
    sum()?;
    ensure!(left_out.is_empty(), "parts are missing: {}", left_out.join("; "));
    Ok(())
}

/// The address of the release files, if it is known.
fn address() -> Option<String> {
    std::env::var(ADDRESS).ok().map(|address| address.trim_end_matches('/').to_owned())
}

/// The wheels of the Python module.
fn wheels() -> Result<Vec<String>> {
    let names =
        python::wheels()?.into_iter().map(|path| Ok(path.file_name().context("a wheel")?.display().to_string()));
    names.collect()
}

/// Keeps the names of a part's files, so that the checksums are complete when one part is made again; what an earlier
/// version of the part left is removed.
fn note(id: &str, files: &[String]) -> Result<()> {
    let list = parts_folder().join(id);
    std::fs::create_dir_all(parts_folder())?;
    for old in std::fs::read_to_string(&list).unwrap_or_default().lines() {
        let path = Path::new(FOLDER).join(old);
        if !files.iter().any(|file| file == old) && path.is_file() {
            std::fs::remove_file(path)?;
        }
    }
    std::fs::write(list, files.iter().map(|file| format!("{file}\n")).collect::<String>())?;
    Ok(())
}

fn parts_folder() -> PathBuf {
    Path::new(FOLDER).join("parts")
}

/// The files of a part.
///
/// # Errors
/// If the part was not made.
fn files(id: &str) -> Result<Vec<PathBuf>> {
    let list = std::fs::read_to_string(parts_folder().join(id))
        .with_context(|| format!("it was not made: cargo xtask --install dist {id}"))?;
    Ok(list.lines().map(|name| Path::new(FOLDER).join(name)).collect())
}

/// The only file of a part whose name has this in it.
fn file(id: &str, part: &str) -> Result<PathBuf> {
    let files = files(id)?;
    let found = files.into_iter().find(|file| file.to_string_lossy().contains(part));
    found.with_context(|| format!("no file of {id} has {part:?} in its name"))
}

/// Writes the checksums of all files, which sha256sum checks.
fn sum() -> Result<()> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(parts_folder())? {
        let list = std::fs::read_to_string(entry?.path())?;
        names.extend(list.lines().map(str::to_owned));
    }
    names.sort();
    if names.is_empty() {
        bail!("no part was made");
    }
    let sums = Command::new("sha256sum").args(&names).current_dir(FOLDER).output().context("sha256sum")?;
    ensure!(sums.status.success(), "sha256sum: {}", String::from_utf8_lossy(&sums.stderr));
    std::fs::write(Path::new(FOLDER).join("SHA256SUMS"), &sums.stdout)?;
    print!("{}", String::from_utf8_lossy(&sums.stdout));
    Ok(())
}

/// The file name of an archive for this target, without its extension: `canvass-0.1.0-x86_64-unknown-linux-musl`.
fn name(target: &str) -> String {
    format!("canvass-{VERSION}-{target}")
}

/// The text of a file in `packaging`, with each `@WORD@` replaced.
fn filled(template: &str, words: &[(&str, &str)]) -> Result<String> {
    let mut text = std::fs::read_to_string(template).with_context(|| template.to_owned())?;
    for (word, value) in words.iter().chain([&("VERSION", VERSION)]) {
        text = text.replace(&format!("@{word}@"), value);
    }
    Ok(text)
}

/// An empty folder for making a part.
fn scratch(name: &str) -> Result<PathBuf> {
    let folder = Path::new(FOLDER).join("scratch").join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}

/// The SHA-256 of bytes in lower-case hexadecimal digits.
fn hash(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(64);
    for byte in Sha256::digest(bytes) {
        // Writing into a text does not fail.
        let _ = write!(text, "{byte:02x}");
    }
    text
}
