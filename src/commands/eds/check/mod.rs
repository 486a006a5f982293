//! `canvass eds check`: what is wrong in device descriptions, and fixing it.

mod fixing;
mod selection;

use super::found::{Description, descriptions};
use crate::files::Files;
use crate::output::{Color, Output, diagnostic, terminal_width, unless_closed};
use crate::shown::{Format, ReportArg, Shown};
use crate::status::{Failure, Status};
use crate::whole_file::WholeFile;
use anyhow::{Context, anyhow};
use canvass_analyzer::dictionary::Severity;
use canvass_analyzer::dictionary::check::{Checked, Folder, check_in};
use canvass_reports::descriptions::text::{self, Hints, Style};
use canvass_reports::descriptions::{Baseline, CheckedFile, CheckedFiles, Counts, github, sarif};
use canvass_reports::document::{Form, Report as _};
use canvass_reports::escape::Printable;
use canvass_traces::small_file::{self, OF_PROGRAM};
use selection::Selection;
use std::io::Write;
use std::path::PathBuf;

/// Check device descriptions against CiA 306 and the standards, and fix what can be fixed
///
/// An error makes a configuration tool or the device fail. A warning contradicts the text of a standard, though the
/// meaning is clear. A hint is advice. `canvass list eds-rules` lists the rules, `canvass explain RULE` explains one.
/// A comment `; canvass: allow RULE reason` in a file waives a rule: before the first section for the whole file, in
/// a section for that section.
#[derive(clap::Args)]
pub struct Args {
    /// EDS, DCF, XDD and XDC files, and folders of them; - is standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    shown: Shown<CheckFormat>,
    /// The lowest severity of findings that makes the exit status 1
    #[arg(long, value_enum, value_name = "SEVERITY", default_value_t)]
    fail_on: FailOn,
    /// Apply every fix that needs no guessing, and write the files
    #[arg(long, conflicts_with = "diff")]
    fix: bool,
    /// Print the changes that --fix would make; the exit status is 1 if there are any
    #[arg(long, conflicts_with_all = ["format", "report"])]
    diff: bool,
    /// Known findings: the SARIF of an earlier check. They count as waived, so that only new findings fail
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// Show each hint with its line; otherwise they are counted by rule, unless --select names their rule
    #[arg(long)]
    hints: bool,
    #[command(flatten)]
    selection: Selection,
}

#[derive(Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
enum CheckFormat {
    /// For people: each finding with its line
    #[default]
    Text,
    /// One JSON object
    Json,
    /// SARIF 2.1.0, for code hosts and editors
    Sarif,
    /// JUnit XML: each file is a suite, each rule a case
    Junit,
    /// For tickets and wikis
    Markdown,
    /// Commands of GitHub's workflows
    Github,
}

impl Format for CheckFormat {
    const DEFAULT: &'static str = "text";
}

#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum FailOn {
    /// Exit status 1 with errors
    #[default]
    Error,
    /// Exit status 1 with warnings and errors
    Warning,
    /// Exit status 1 with any finding
    Hint,
    /// Never exit status 1 for findings; the status tells only whether the files could be read
    Never,
}

impl FailOn {
    const fn least(self) -> Option<Severity> {
        match self {
            Self::Error => Some(Severity::Error),
            Self::Warning => Some(Severity::Warning),
            Self::Hint => Some(Severity::Hint),
            Self::Never => None,
        }
    }
}

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        self.selection.check()?;
        let style = Style { colors: color.on_stdout(), width: terminal_width().map_or(140, usize::from) };
        let output = Output::text(style.colors);
        let mut baseline = self.baseline()?;
        let format = self.shown.of_stdout()?;
        let reports = self.open_reports()?;
        let (mut files, mut drawn) = (Vec::new(), String::new());
        let mut status = Status::Good;
        for path in descriptions(&self.files)? {
            match self.one(&path, format, style, &output, baseline.as_mut()) {
                Ok(Some((file, text))) => {
                    files.push(file);
                    drawn += &text;
                }
                Ok(None) => {}
                Err(error) if self.files.len() == 1 && !self.files.iter().any(|path| path.is_dir()) => {
                    return Err(error.into());
                }
                // An unreadable file must not keep the others from being checked.
                Err(error) => {
                    diagnostic(&format!("canvass: {error:#}"));
                    status = Status::Usage;
                }
            }
        }
        if self.diff {
            unless_closed(output.flush())?;
            return Ok(if status == Status::Good && !files.is_empty() { Status::Findings } else { status });
        }
        self.print(&files, format, &output)?;
        for (format, file) in reports {
            file.document()?.write_all(self.render(&files, format, &drawn)?.as_bytes())?;
            file.complete()?;
        }
        if let Some(gone) = baseline.map(|baseline| baseline.gone()).filter(|gone| *gone > 0) {
            diagnostic(&format!("canvass: {gone} findings of the baseline are gone: --format sarif writes a new one"));
        }
        let least = self.fail_on.least();
        let counts = |severity| least.is_some_and(|least| severity >= least);
        let fails = files.iter().flat_map(CheckedFile::open).any(|located| counts(located.finding.severity()));
        Ok(if status == Status::Good && fails { Status::Findings } else { status })
    }

    fn baseline(&self) -> anyhow::Result<Option<Baseline>> {
        let Some(path) = &self.baseline else { return Ok(None) };
        let text = small_file::read_text(path, OF_PROGRAM).with_context(|| format!("can't read {}", path.display()))?;
        Ok(Some(Baseline::read(&text).with_context(|| format!("{}", path.display()))?))
    }

    /// Checks one file, and fixes it with `--fix`. Findings are printed at once as text; other formats, and files, get
    /// them at the end. Returns what was found, and its text if a file takes it.
    fn one(
        &self,
        path: &std::path::Path,
        format: CheckFormat,
        style: Style,
        output: &Output,
        baseline: Option<&mut Baseline>,
    ) -> anyhow::Result<Option<(CheckedFile, String)>> {
        let mut description = Description::read(path)?;
        let wanted = |finding: &_| self.selection.wants(finding);
        if self.fix {
            fixing::fix_file(&mut description, wanted)?;
        }
        let folder = description.folder();
        let beside = folder.as_ref().map(|folder| folder as &dyn Folder);
        let checked = check_in(&description.bytes, description.file_name.as_deref(), beside);
        let checked: Checked<'_> = checked.with_context(|| format!("can't check {}", path.display()))?;
        if let Err(error) = &checked.description {
            return Err(anyhow!("{} is no device description: {error}", path.display()));
        }
        let mut file = CheckedFile::new(&description.name, &checked, wanted);
        baseline.into_iter().for_each(|baseline| baseline.mark(&mut file));
        if self.diff {
            let diff = fixing::difference(&description, &checked.source.text, wanted)?;
            unless_closed(output.append(|buffer| buffer.extend_from_slice(diff.as_bytes())))?;
            if diff.is_empty() {
                return Ok(None);
            }
        } else if format == CheckFormat::Text {
            let text = text::render(&file, &checked.source, style, self.hints());
            unless_closed(output.append(|buffer| buffer.extend_from_slice(text.as_bytes())))?;
        }
        let is_kept = self.shown.in_files().any(|report| report.format() == CheckFormat::Text);
        let plain = Style { colors: false, ..style };
        let text = if is_kept { text::render(&file, &checked.source, plain, self.hints()) } else { String::new() };
        Ok(Some((file, text)))
    }

    /// Hints are shown where they are asked for, and where they make the check fail.
    fn hints(&self) -> Hints {
        let is_wanted = self.hints || self.fail_on.least() == Some(Severity::Hint) || self.selection.is_narrowed();
        if is_wanted { Hints::Each } else { Hints::Counted }
    }

    /// The files of all reports, created before anything is checked, so that an unwritable path is reported at once.
    fn open_reports(&self) -> anyhow::Result<Vec<(CheckFormat, WholeFile)>> {
        let read = self.files.iter().filter(|path| !path.is_dir());
        Files::new().reads(read).writes(self.shown.files())?;
        let open = |report: &ReportArg<CheckFormat>| Ok((report.format(), WholeFile::create(report.file())?));
        self.shown.in_files().map(open).collect()
    }

    /// Prints what was not printed with each file.
    fn print(&self, files: &[CheckedFile], format: CheckFormat, output: &Output) -> Result<(), Failure> {
        let text = match format {
            CheckFormat::Text => summary(files, self.hints()),
            other => self.render(files, other, "")?,
        };
        let mut output = output.clone();
        unless_closed(output.write_all(text.as_bytes()).and_then(|()| Output::flush(&output)))?;
        Ok(())
    }

    /// The findings in a format. `drawn` are the findings as text.
    fn render(&self, files: &[CheckedFile], format: CheckFormat, drawn: &str) -> std::io::Result<String> {
        Ok(match format {
            CheckFormat::Text => drawn.to_owned() + &summary(files, self.hints()),
            CheckFormat::Sarif => Printable::pretty_json(&sarif::document(files)).into_string(),
            CheckFormat::Github => files.iter().map(github::render).collect(),
            CheckFormat::Json => self.report(files, Form::Json)?,
            CheckFormat::Markdown => self.report(files, Form::Markdown)?,
            CheckFormat::Junit => self.report(files, Form::Junit)?,
        })
    }

    fn report(&self, files: &[CheckedFile], form: Form) -> std::io::Result<String> {
        let mut bytes = Vec::new();
        CheckedFiles { files, fail_on: self.fail_on.least() }.write(form, &mut bytes)?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }
}

/// The number of findings, and what `--hints` and `--fix` would do.
fn summary(files: &[CheckedFile], hints: Hints) -> String {
    let counts = Counts::of(files);
    let mut text = text::summary(files.len(), &counts);
    if hints == Hints::Counted && counts.hints > 0 {
        text += "--hints shows each hint with its line\n";
    }
    match counts.fixable {
        0 => text,
        number => format!("{text}{number} can be fixed with --fix; --diff shows what would change\n"),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_default_format_has_its_name() {
        crate::shown::expect_default::<super::CheckFormat>();
    }
}
