//! `canvass eds convert`: device descriptions from one format to another.

use super::found::Description;
use crate::destination::refuse_existing;
use crate::files::Files;
use crate::output::{Output, diagnostic, unless_closed};
use crate::status::{Failure, Status};
use crate::whole_file::WholeFile;
use anyhow::{Context, Result, bail};
use canvass_analyzer::dictionary::Loss;
use canvass_analyzer::dictionary::convert::{Form, convert};
use std::io::Write;
use std::path::{Path, PathBuf};

/// More losses are only counted, unless all are asked for.
const SHOWN: usize = 20;

/// Convert a device description to another format: EDS and XDD, DCF and XDC
///
/// The format written is told by the ending of OUT, or by --to. What the format has no place for, and what of IN is not
/// kept, is said on standard error, each thing with its place. A DCF becomes an EDS without what it configures.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  canvass eds convert encoder.eds encoder.xdd
  canvass eds convert line-3.xdc line-3.dcf --force
  canvass eds convert encoder.xdd - --to eds")]
pub struct Args {
    /// An EDS, DCF, XDD or XDC file; - is standard input
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// The file to write; - is standard output
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// The format to write
    #[arg(long, value_enum)]
    to: Option<To>,
    /// Overwrite OUT if it exists
    #[arg(long)]
    force: bool,
    /// Say everything that is lost, not only the first 20 things
    #[arg(long)]
    all_losses: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum To {
    /// CiA 306, for a type of device
    Eds,
    /// CiA 306, for a configured device
    Dcf,
    /// CiA 311, for a type of device
    Xdd,
    /// CiA 311, for a configured device
    Xdc,
}

impl From<To> for Form {
    fn from(to: To) -> Self {
        match to {
            To::Eds => Self::Eds,
            To::Dcf => Self::Dcf,
            To::Xdd => Self::Xdd,
            To::Xdc => Self::Xdc,
        }
    }
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let form = self.form()?;
        let is_stdout = self.output.as_os_str() == "-";
        if !is_stdout {
            Files::new().reads([&self.input]).writes([&self.output])?;
            if !self.force {
                refuse_existing(&self.output)?;
            }
        }
        let bytes = Description::read(&self.input)?.bytes;
        let name = self.output.file_name().filter(|_| !is_stdout).map(|name| name.to_string_lossy().into_owned());
        let converted = convert(&bytes, form, name.as_deref())
            .with_context(|| format!("can't convert {}", self.input.display()))?;
        if is_stdout {
            let mut output = Output::text(false);
            unless_closed(output.write_all(converted.text.as_bytes()).and_then(|()| Output::flush(&output)))?;
        } else {
            write(&self.output, &converted.text)?;
        }
        self.tell(form, &converted.losses);
        Ok(Status::Good)
    }

    fn form(&self) -> Result<Form> {
        let by_name = self.output.extension().and_then(|ending| Form::from_name(&ending.to_string_lossy()));
        match self.to.map(Form::from).or(by_name) {
            Some(form) => Ok(form),
            None => {
                let names = Form::ALL.map(Form::name).join(", ");
                bail!("{} does not tell the format to write: say --to with one of {names}", self.output.display())
            }
        }
    }

    fn tell(&self, form: Form, losses: &[Loss]) {
        let shown = if self.all_losses { losses.len() } else { SHOWN };
        let name = self.input.display();
        for loss in losses.iter().take(shown) {
            diagnostic(&format!("{name}: {loss}"));
        }
        if losses.len() > shown {
            let rest = losses.len() - shown;
            diagnostic(&format!("{name}: {rest} more things are not in the {form}: --all-losses says all"));
        }
    }
}

fn write(path: &Path, text: &str) -> Result<()> {
    let file = WholeFile::create(path)?;
    file.writer()?.write_all(text.as_bytes()).with_context(|| format!("can't write {}", path.display()))?;
    file.complete()
}
