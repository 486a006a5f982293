//! `--format` and `--report`: where a result goes, and in which formats.

use anyhow::{Context, Result, anyhow};
use clap::ValueEnum;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// A format of a command's result.
pub trait Format: ValueEnum + Copy + Default + PartialEq + Send + Sync + 'static {
    /// The name of the variant that `default()` returns. clap's `default_value_t` stores the default of the first command in
    /// a static, and all other commands would get that one.
    const DEFAULT: &'static str;
}

/// A value of `--report`: `FORMAT=FILE`.
#[derive(Clone, Debug)]
pub struct ReportArg<F> {
    format: F,
    file: PathBuf,
}

impl<F: Format> ReportArg<F> {
    /// The format.
    pub fn format(&self) -> F {
        self.format
    }

    /// The file, or `-` for standard output.
    pub fn file(&self) -> &Path {
        &self.file
    }

    fn is_of_stdout(&self) -> bool {
        self.file.as_os_str() == "-"
    }
}

impl<F: Format> FromStr for ReportArg<F> {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let (format, file) = text.split_once('=').context("expected FORMAT=FILE, such as html=report.html")?;
        let format =
            F::from_str(format, false).map_err(|_| anyhow!("expected {}, found \"{format}\"", names::<F>()))?;
        Ok(Self { format, file: file.into() })
    }
}

/// The names of all formats: `table, json or html`.
fn names<F: Format>() -> String {
    let names: Vec<String> = F::value_variants()
        .iter()
        .filter_map(|format| Some(format.to_possible_value()?.get_name().to_owned()))
        .collect();
    match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => names.concat(),
    }
}

/// Options for the output of a result.
#[derive(clap::Args)]
pub struct Shown<F: Format> {
    /// How to print the result
    #[arg(long, value_enum, default_value = F::DEFAULT)]
    pub format: F,
    /// Write a report into a file too; can be given several times. FORMAT=- writes to standard output, in place of
    /// --format
    #[arg(long, value_name = "FORMAT=FILE")]
    pub report: Vec<ReportArg<F>>,
}

impl<F: Format> Shown<F> {
    /// The paths of all report files.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.in_files().map(ReportArg::file)
    }

    /// The reports that are written into files.
    pub fn in_files(&self) -> impl Iterator<Item = &ReportArg<F>> {
        self.report.iter().filter(|report| !report.is_of_stdout())
    }

    /// The format for standard output, from `--format` or `--report FORMAT=-`.
    ///
    /// # Errors
    /// If several options name standard output.
    pub fn of_stdout(&self) -> Result<F> {
        let said = (self.format != F::default()).then_some(self.format);
        let mut wanted =
            self.report.iter().filter(|report| report.is_of_stdout()).map(|report| report.format).chain(said);
        let first = wanted.next().unwrap_or_default();
        match wanted.next() {
            Some(_) => Err(anyhow!("standard output takes one report: give --format FORMAT or --report FORMAT=- once")),
            None => Ok(first),
        }
    }

    /// All requested formats.
    pub fn formats(&self) -> impl Iterator<Item = F> {
        self.report.iter().map(|report| report.format).chain([self.format])
    }
}

/// Requires that [`Format::DEFAULT`] names the variant that `F::default()` returns.
#[cfg(test)]
pub fn expect_default<F: Format>() {
    assert!(F::from_str(F::DEFAULT, false).is_ok_and(|named| named == F::default()), "{}", F::DEFAULT);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Copy, Default, PartialEq, ValueEnum)]
    enum Colour {
        #[default]
        Red,
        Green,
        Blue,
    }

    impl Format for Colour {
        const DEFAULT: &'static str = "red";
    }

    #[test]
    fn a_report_is_a_format_and_a_file() {
        let report: ReportArg<Colour> = "green=a=b.txt".parse().unwrap();
        assert!(report.format() == Colour::Green && report.file() == Path::new("a=b.txt"));
        let error = |text: &str| text.parse::<ReportArg<Colour>>().err().unwrap().to_string();
        assert_eq!(error("pink=a"), "expected red, green or blue, found \"pink\"");
        assert!(error("green").starts_with("expected FORMAT=FILE"));
    }
}
