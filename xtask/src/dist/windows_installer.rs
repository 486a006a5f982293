//! The installer for Windows: the program in the PATH, and verbs in the context menus of captures and descriptions.

use super::{FOLDER, VERSION, archives, filled, scratch, system};
use crate::packages::{self, Package};
use crate::windows;
use anyhow::{Context, Result, ensure};
use std::fs;
use std::path::Path;
use std::process::Command;

/// The name of this part of the release.
pub const ID: &str = "msi";
const WIXL: Package = Package { program: "wixl", probe: &["--version"], package: "wixl" };
const MSITOOLS: Package = Package { program: "msiinfo", probe: &["--version"], package: "msitools" };
/// The installer's table of environment variables. It appends the folder of the program to the PATH. wixl can't write this
/// table, so msibuild adds it.
const ENVIRONMENT: &str = "packaging/Environment.idt";
/// The actions by which an installer writes and removes environment variables, and their sequence numbers in Microsoft's
/// table of standard actions.
const ACTIONS: [(&str, u16); 2] = [("RemoveEnvironmentStrings", 3300), ("WriteEnvironmentStrings", 5200)];

/// The endings of files, and what their context menu offers: verbs with the arguments of canvass.
pub type Menu = (&'static [&'static str], &'static [(&'static str, &'static str)]);

/// What the context menus offer.
pub const MENUS: [Menu; 2] = [
    (&["trc", "asc", "blf", "log", "pcap", "pcapng", "mcap", "mf4"], &[("decode", "decode"), ("diagnose", "diagnose")]),
    (&["eds", "dcf", "xdd", "xdc"], &[("check", "eds check"), ("show", "eds show")]),
];

/// Fetches what makes the installer.
pub fn prepare() -> Result<()> {
    ensure!(system::program_for_windows().exists(), "it holds the program for Windows: cargo xtask dist windows");
    packages::install(&[WIXL, MSITOOLS])
}

/// The installer.
pub fn make() -> Result<Vec<String>> {
    let work = scratch("msi")?;
    archives::lay_out_windows(&work)?;
    let source = work.join("canvass.wxs");
    let text = filled("packaging/canvass.wxs", &[("FOLDER", &work.to_string_lossy()), ("MENUS", &menus())])?;
    fs::write(&source, text)?;
    let file = format!("canvass-{VERSION}-{}.msi", windows::TARGET);
    let output = Path::new(FOLDER).join(&file);
    let status = Command::new(WIXL.program).args(["--arch", "x64", "--output"]).arg(&output).arg(source).status();
    let status = status.context("wixl")?;
    ensure!(status.success(), "wixl ended with {status}");
    add_environment(&output)?;
    Ok(vec![file])
}

fn add_environment(installer: &Path) -> Result<()> {
    let mut msibuild = Command::new("msibuild");
    msibuild.arg(installer).args(["-i", ENVIRONMENT]);
    for (action, sequence) in ACTIONS {
        let columns = "`Action`, `Condition`, `Sequence`";
        let row = format!("INSERT INTO `InstallExecuteSequence` ({columns}) VALUES ('{action}', '', {sequence})");
        msibuild.args(["-q", &row]);
    }
    let status = msibuild.status().context("msibuild")?;
    ensure!(status.success(), "msibuild ended with {status}");
    Ok(())
}

/// The registry key of a verb.
pub fn key(ending: &str, verb: &str) -> String {
    format!(r"SOFTWARE\Classes\SystemFileAssociations\.{ending}\shell\canvass.{verb}")
}

/// The entries of the registry for all verbs. The console stays open, so that the answer can be read.
fn menus() -> String {
    let mut text = String::new();
    for (endings, verbs) in MENUS {
        for (ending, (verb, arguments)) in
            endings.iter().flat_map(|ending| verbs.iter().map(move |verb| (ending, verb)))
        {
            let key = key(ending, verb);
            let command =
                format!("cmd.exe /k &quot;&quot;[INSTALLDIR]canvass.exe&quot; {arguments} &quot;%1&quot;&quot;");
            text += &format!(
                "            <RegistryValue Root=\"HKLM\" Key=\"{key}\" Type=\"string\" Value=\"canvass: {verb}\"/>\n\
                 \u{20}           <RegistryValue Root=\"HKLM\" Key=\"{key}\\command\" Type=\"string\" Value=\"{command}\"/>\n"
            );
        }
    }
    text
}
