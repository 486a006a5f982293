//! The manifests of the package managers of Windows, which name where a release can be fetched: scoop and winget.

use super::{ADDRESS, FOLDER, VERSION, address, file, filled, name, windows_installer};
use crate::windows;
use anyhow::{Context, Result, ensure};
use std::fs;
use std::path::Path;

/// The three manifests that winget takes. A manifest and its schema have the same name.
pub const WINGET: [&str; 3] = ["version", "installer", "defaultLocale"];

/// The manifests, if the address of the release is known.
pub fn make() -> Result<Vec<String>> {
    match address() {
        Some(address) => at(&address),
        None => {
            eprintln!("{ADDRESS} names no address of the release: its manifests for scoop and winget were left out");
            Ok(Vec::new())
        }
    }
}

/// Writes the manifests of the release whose files are at this address.
///
/// # Errors
/// If the files for Windows were not made, or the address is none.
pub fn at(address: &str) -> Result<Vec<String>> {
    ensure!(address.starts_with("https://"), "expected an address that begins with https://, found {address}");
    let hashed = |path: &Path| Ok::<_, anyhow::Error>(super::hash(&fs::read(path)?));
    let zip = file("windows", ".zip")?;
    let msi = file(windows_installer::ID, ".msi")?;
    let plain = |path: &Path| path.file_name().context("a file").map(|name| name.to_string_lossy().into_owned());
    let words = [
        ("ADDRESS", address.to_owned()),
        ("ZIP_FOLDER", name(windows::TARGET)),
        ("ZIP_HASH", hashed(&zip)?),
        ("ZIP", plain(&zip)?),
        ("MSI_HASH", hashed(&msi)?.to_uppercase()),
        ("MSI", plain(&msi)?),
    ];
    let words: Vec<(&str, &str)> = words.iter().map(|(word, value)| (*word, value.as_str())).collect();
    let scoop = format!("canvass-{VERSION}-scoop.json");
    fs::write(Path::new(FOLDER).join(&scoop), filled("packaging/scoop.json", &words)?)?;
    let mut made = vec![scoop];
    for part in WINGET {
        let file = format!("canvass-{VERSION}-winget-{part}.yaml");
        fs::write(Path::new(FOLDER).join(&file), filled(&format!("packaging/winget/{part}.yaml"), &words)?)?;
        made.push(file);
    }
    Ok(made)
}
