//! `canvass examples`: files to try the program with.

use crate::output::print;
use crate::status::{Failure, Status};
use crate::whole_file::write_whole;
use anyhow::{Context, Result, bail};
use canvass_device::models::Model;
use canvass_reports::escape::Printable;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Put a capture and a device description into a folder, to try the commands with
///
/// The capture shows how an encoder is commissioned by LSS and SDO, and an error that it reports. Nothing is overwritten.
#[derive(clap::Args)]
pub struct Args {
    /// The folder that the command creates
    #[arg(default_value = "canvass-examples", value_name = "FOLDER")]
    folder: PathBuf,
}

/// The capture of an encoder's commissioning.
pub const CAPTURE: &str = include_str!("../../docs/examples/commissioning.log");
/// The model whose description is an example.
const MODEL: &str = "kuebler-sendix-58x8";

/// Commands to try; `{}` stands for the folder.
const COMMANDS: [(&str, &str); 5] = [
    ("canvass decode {}/commissioning.log --device 63={}/encoder.eds", "every frame with its meaning"),
    ("canvass diagnose {}/commissioning.log", "what is wrong in it"),
    ("canvass signals {}/commissioning.log --device 63={}/encoder.eds", "the values of PDOs"),
    ("canvass eds check {}/encoder.eds", "what is wrong in the description"),
    ("canvass test sim:{}/encoder.eds", "a simulated device made of the description, under test"),
];

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        write(&self.folder)?;
        let folder = self.folder.display().to_string();
        let mut text = String::from("Try:\n");
        for (command, what) in COMMANDS {
            // Writing to a string can't fail.
            let _ = writeln!(text, "  {}\n      {what}", command.replace("{}", &folder));
        }
        print(&Printable::document(&text))?;
        Ok(Status::Good)
    }
}

/// Writes the files into a folder.
pub fn write(folder: &Path) -> Result<()> {
    let description = Model::by_id(MODEL).and_then(Model::eds_text).context("the model has a description")?;
    fs::create_dir_all(folder).with_context(|| format!("can't make the folder {}", folder.display()))?;
    for (name, content) in [("commissioning.log", CAPTURE), ("encoder.eds", description)] {
        let path = folder.join(name);
        if path.exists() {
            bail!("{} exists already: name another folder", path.display());
        }
        write_whole(&path, content.as_bytes())?;
    }
    Ok(())
}
