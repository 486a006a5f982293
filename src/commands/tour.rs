//! `canvass tour`: the main commands, one after the other, on a simulated encoder with a fault.

use crate::output::{diagnostic, is_terminal, print};
use crate::status::{Failure, Status};
use anyhow::{Context, Result, bail};
use canvass_reports::escape::Printable;
use std::fs;
use std::io::{self, IsTerminal as _};
use std::path::PathBuf;
use std::process::Command;

/// Show the main commands in five minutes, on a simulated encoder with a fault
///
/// Nothing is installed and nothing is connected. The tour leaves a capture and a report in a folder.
#[derive(clap::Args)]
pub struct Args {
    /// The folder that the tour creates for the capture and the report
    #[arg(default_value = "canvass-tour", value_name = "FOLDER")]
    folder: PathBuf,
    /// Go on without waiting for Enter
    #[arg(long)]
    no_pause: bool,
}

/// The encoder of the tour: it sends its boot-up message twice.
const BUS: &str = "sim:kuebler-sendix-58x8+boot-up-twice";

/// A station: what is to be seen, and the command. `{}` is the folder.
const STATIONS: [(&str, &[&str]); 6] = [
    ("Who is on the bus? Nothing is changed by asking.", &["scan", BUS]),
    (
        "One object, by its name in the description of the device.",
        &["sdo", "read", BUS, "63", "Position value", "--device", "kuebler-sendix-58x8"],
    ),
    (
        "Does it conform? Some cases of CiA 301, with a report and a recording. This firmware has a fault.",
        &["test", BUS, "--select", "301/boot-up,301/nmt", "--report", "html={}/report.html", "--record", "{}/run.log"],
    ),
    ("What is behind a case: requirement, clause and steps.", &["explain", "301/boot-up/every-time"]),
    (
        "What does a capture show? Here the recording of the run; it could be one of a machine.",
        &["diagnose", "{}/run.log", "--fail-on", "never"],
    ),
    ("The beginning of that recording, frame by frame.", &["decode", "{}/run.log", "--to", "+2"]),
];

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let folder = self.folder.display().to_string();
        if self.folder.join("report.html").exists() {
            Err(anyhow::anyhow!("{folder}/report.html exists already: name another folder"))?;
        }
        fs::create_dir_all(&self.folder).with_context(|| format!("can't make the folder {folder}"))?;
        let waits = !self.no_pause && io::stdin().is_terminal() && is_terminal();
        for (number, (what, words)) in (1..).zip(STATIONS) {
            let words: Vec<String> = words.iter().map(|word| word.replace("{}", &folder)).collect();
            let text = format!("\n{number}/{}  {what}\n\n$ canvass {}\n", STATIONS.len(), shown(&words));
            print(&Printable::document(&text))?;
            if waits {
                pause()?;
            }
            carry_out(&words)?;
        }
        let end = format!(
            "\nThe report is {folder}/report.html. On a bus of your own: canvass scan can0, canvass test can0 --node 5.\n"
        );
        print(&Printable::document(&end))?;
        Ok(Status::Good)
    }
}

/// The words as they are typed in a shell.
fn shown(words: &[String]) -> String {
    let quoted = words.iter().map(|word| if word.contains(' ') { format!("\"{word}\"") } else { word.clone() });
    quoted.collect::<Vec<_>>().join(" ")
}

/// Runs this program with these words.
fn carry_out(words: &[String]) -> Result<()> {
    let program = std::env::current_exe().context("the system does not tell where this program is")?;
    let ended = Command::new(program).args(words).status().context("can't run the command")?;
    // Findings and failures are what the tour shows.
    match ended.code() {
        Some(0 | 1) => Ok(()),
        Some(status) => bail!("the command ended with status {status}"),
        None => bail!("the command was ended"),
    }
}

fn pause() -> Result<()> {
    diagnostic("(Enter goes on)");
    io::stdin().read_line(&mut String::new()).context("can't read from the terminal")?;
    Ok(())
}
