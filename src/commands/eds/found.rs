//! The device descriptions that a command reads: files, folders and standard input.

use anyhow::{Context, Result, anyhow, bail};
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_analyzer::dictionary::check::Folder;
use canvass_traces::small_file::{self, OF_HAND};
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Extensions of device descriptions.
const ENDINGS: [&str; 4] = ["eds", "dcf", "xdd", "xdc"];

/// Depth limit for folders: a symbolic link could lead back to a parent.
const DEEPEST: usize = 32;

/// All files that the arguments name; folders are searched, in alphabetical order.
pub fn descriptions(named: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut all = Vec::new();
    for path in named {
        if path.is_dir() {
            let before = all.len();
            collect(path, DEEPEST, &mut all)?;
            if all.len() == before {
                bail!("{} has no EDS, DCF, XDD or XDC file", path.display());
            }
        } else {
            all.push(path.clone());
        }
    }
    Ok(all)
}

fn collect(folder: &Path, depth: usize, all: &mut Vec<PathBuf>) -> Result<()> {
    let failed = || format!("can't read {}", folder.display());
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).with_context(failed)? {
        paths.push(entry.with_context(failed)?.path());
    }
    paths.sort();
    for path in paths {
        let is_description = || {
            let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
            ending.is_some_and(|ending| ENDINGS.contains(&ending.as_str()))
        };
        if path.is_dir() {
            if depth > 0 && !path.is_symlink() {
                collect(&path, depth - 1, all)?;
            }
        } else if is_description() {
            all.push(path);
        }
    }
    Ok(())
}

/// A device description: its file's name and content.
pub struct Description {
    /// The path as the user typed it.
    pub name: String,
    pub path: PathBuf,
    /// The file's name without folders; `None` for standard input.
    pub file_name: Option<String>,
    pub bytes: Vec<u8>,
}

impl Description {
    /// Reads a file, or standard input.
    pub fn read(path: &Path) -> Result<Self> {
        let failed = || format!("can't read {}", path.display());
        let is_input = path == Path::new("-");
        let bytes = if is_input {
            let mut bytes = Vec::new();
            std::io::stdin().lock().take(OF_HAND + 1).read_to_end(&mut bytes).context("can't read standard input")?;
            bytes
        } else {
            small_file::read(path, OF_HAND).with_context(failed)?
        };
        let file_name = path.file_name().filter(|_| !is_input).map(|name| name.to_string_lossy().into_owned());
        Ok(Self { name: path.display().to_string(), path: path.to_owned(), file_name, bytes })
    }

    /// The folder of the file; `None` for standard input.
    pub fn folder(&self) -> Option<Beside> {
        let parent = self.path.parent().filter(|_| !self.is_input())?;
        let here = parent.as_os_str().is_empty();
        Some(Beside(if here { PathBuf::from(".") } else { parent.to_owned() }))
    }

    /// Whether the description came from standard input.
    pub fn is_input(&self) -> bool {
        self.file_name.is_none()
    }
}

/// The files of a folder.
pub struct Beside(pub PathBuf);

impl Folder for Beside {
    fn has(&self, name: &str) -> bool {
        self.0.join(name).is_file()
    }

    fn read(&self, name: &str) -> Option<Vec<u8>> {
        small_file::read(&self.0.join(name), OF_HAND).ok()
    }
}

/// Reads the description in a file. A description with unreadable parts is refused: it would describe another device.
pub fn description(bytes: &[u8], path: &Path) -> Result<DeviceDescription> {
    let read = DeviceDescription::read(bytes);
    let description = read.with_context(|| format!("{} is no device description", path.display()))?;
    description.usable().map_err(|unusable| anyhow!("{}: {unusable}", path.display()))?;
    Ok(description)
}
