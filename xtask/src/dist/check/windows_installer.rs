//! The installer for Windows: installed and removed by Wine.

use super::{SAMPLE, exercise, output};
use crate::dist::file;
use crate::dist::windows_installer::{self, MENUS};
use crate::packages;
use crate::windows::{self, wine::Prefix};
use anyhow::{Result, ensure};

/// Where Windows keeps the variables of all users.
const ENVIRONMENT: &str = r"HKLM\SYSTEM\CurrentControlSet\Control\Session Manager\Environment";
/// The place of the program.
const PROGRAM: &str = "drive_c/Program Files/canvass/canvass.exe";

/// Installs, looks for what must be there, runs the program by its name alone, and removes it.
pub fn install() -> Result<String> {
    packages::install(&[windows::WINE])?;
    let prefix = Prefix::make()?;
    let package = file(windows_installer::ID, ".msi")?.to_string_lossy().into_owned();
    output(&mut prefix.wine(&["msiexec", "/i", &package, "/qn"]))?;
    ensure!(prefix.path(PROGRAM).exists(), "{PROGRAM} is missing after the installation");
    let path = output(&mut prefix.wine(&["reg", "query", ENVIRONMENT, "/v", "PATH"]))?;
    ensure!(path.contains(r"\canvass"), "the PATH lacks the folder of canvass: {path}");
    for (ending, verb) in verbs() {
        let key = format!(r"HKLM\{}\command", windows_installer::key(ending, verb));
        let command = output(&mut prefix.wine(&["reg", "query", &key, "/ve"]))?;
        ensure!(command.contains("canvass.exe"), "the verb {verb} of .{ending} starts something else: {command}");
    }
    // The program as the console finds it, by the PATH.
    exercise(&|words| prefix.wine(&[&["cmd", "/c", "canvass"], words].concat()), SAMPLE)?;
    output(&mut prefix.wine(&["msiexec", "/x", &package, "/qn"]))?;
    ensure!(!prefix.path(PROGRAM).exists(), "{PROGRAM} is still there after the removal");
    for (ending, verb) in verbs() {
        let key = format!(r"HKLM\{}", windows_installer::key(ending, verb));
        let left = prefix.wine(&["reg", "query", &key]).output()?;
        ensure!(!left.status.success(), "the verb {verb} of .{ending} is still there after the removal");
    }
    Ok("installed by Wine: program, PATH, menus; run, removed".to_owned())
}

fn verbs() -> impl Iterator<Item = (&'static str, &'static str)> {
    MENUS.iter().flat_map(|(endings, verbs)| {
        endings.iter().flat_map(move |ending| verbs.iter().map(move |(verb, _)| (*ending, *verb)))
    })
}
