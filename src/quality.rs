//! `--quality`: the quality of the captures.

use crate::output::{diagnostics, print};
use crate::whole_file::WholeFile;
use anyhow::{Context, Result};
use canvass_reports::escape::Printable;
use canvass_reports::quality::{self, CaptureQuality};
use canvass_traces::Channels;
use serde_json::json;
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Options for the quality of the captures.
#[derive(clap::Args, Default)]
pub struct QualityOptions {
    /// Report frames, damage, clock steps, time resolution and gaps of the captures at the end
    #[arg(long, value_enum, value_name = "FORMAT", num_args = 0..=1, default_missing_value = "text")]
    quality: Option<QualityFormat>,
    /// The file for the quality report (default: standard error); - is standard output
    #[arg(long, value_name = "FILE", requires = "quality")]
    quality_out: Option<PathBuf>,
}

/// Replaces a `--quality` without format by `--quality=text`: otherwise clap would take the name of a following file
/// for the format.
pub fn with_format(arguments: impl Iterator<Item = OsString>) -> impl Iterator<Item = OsString> {
    let mut arguments = arguments.peekable();
    std::iter::from_fn(move || {
        let argument = arguments.next()?;
        let is_format = |next: &OsString| next == "text" || next == "json";
        let alone = argument == "--quality" && !arguments.peek().is_some_and(is_format);
        Some(if alone { "--quality=text".into() } else { argument })
    })
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum QualityFormat {
    /// Aligned text
    Text,
    /// A JSON object
    Json,
}

impl QualityOptions {
    /// The output file, if one is given.
    pub fn file(&self) -> Option<&Path> {
        self.quality_out.as_deref()
    }

    /// Prints the quality, if the user asked for it.
    pub fn report(&self, captures: &[CaptureQuality<'_>], channels: &Channels) -> Result<()> {
        let shown = match self.quality {
            None => return Ok(()),
            Some(QualityFormat::Text) => Printable::document(&quality::text(captures, channels)),
            Some(QualityFormat::Json) => Printable::pretty_json(&json!(quality::json(captures, channels))),
        };
        match &self.quality_out {
            None => diagnostics(shown.as_str().trim_end()),
            Some(path) if path.as_os_str() == "-" => print(&shown)?,
            Some(path) => {
                let file = WholeFile::create(path)?;
                file.writer()?
                    .write_all(shown.as_str().as_bytes())
                    .with_context(|| format!("can't write {}", path.display()))?;
                file.complete()?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_no_format() {
        let through = |line: &str| {
            let arguments = with_format(line.split(' ').map(OsString::from));
            arguments.map(|word| word.into_string().unwrap()).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(through("decode --quality a.log"), "decode --quality=text a.log");
        assert_eq!(through("decode a.log --quality"), "decode a.log --quality=text");
        for kept in ["decode --quality json a.log", "decode --quality=json a.log", "decode --quality-out x"] {
            assert_eq!(through(kept), kept);
        }
    }
}
