//! `canvass eds diff`: what a release changed between two device descriptions.

use super::found::{Description, description};
use crate::output::{Color, TextJsonOrMarkdown};
use crate::status::{Failure, Status};
use anyhow::{Result, bail};
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_analyzer::dictionary::difference::{Class, compare};
use canvass_reports::descriptions::difference::Compared;
use canvass_reports::document::Style;
use std::path::{Path, PathBuf};

/// Compare two device descriptions: the changes of a release, and which of them are breaking
///
/// EDS, DCF, XDD and XDC files, also of different formats. A change is breaking if a configuration tool, a DCF or
/// another device that relies on the old description fails: an object that is gone, another type, narrower limits,
/// another PDO layout. It is notable if the device behaves or a tool shows something differently. Other changes are
/// harmless.
#[derive(clap::Args)]
pub struct Args {
    /// The description of the release before; - is standard input
    old: PathBuf,
    /// The description of the new release; - is standard input
    new: PathBuf,
    /// How to print the differences
    #[arg(long, value_enum, default_value_t)]
    format: TextJsonOrMarkdown,
    /// The least serious class of changes that makes the exit status 1
    #[arg(long, value_enum, value_name = "CLASS", default_value_t)]
    fail_on_change: FailOn,
}

#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum FailOn {
    /// Exit status 1 with breaking changes
    #[default]
    Breaking,
    /// Exit status 1 with breaking or notable changes
    Notable,
    /// Exit status 1 with any change
    Harmless,
    /// Never exit status 1 for changes; the status tells only whether the files could be read
    Never,
}

impl FailOn {
    const fn least(self) -> Option<Class> {
        match self {
            Self::Breaking => Some(Class::Breaking),
            Self::Notable => Some(Class::Notable),
            Self::Harmless => Some(Class::Harmless),
            Self::Never => None,
        }
    }
}

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        let compared = self.compare()?;
        let style = Style { color: color.on_stdout(), width: None };
        self.format.print(&compared, style)?;
        let fails = self.fail_on_change.least().is_some_and(|least| compared.has(least));
        Ok(if fails { Status::Findings } else { Status::Good })
    }

    fn compare(&self) -> Result<Compared> {
        if [&self.old, &self.new].iter().all(|path| path.as_os_str() == "-") {
            bail!("standard input can be only one of the two descriptions");
        }
        let (old, new) = (read(&self.old)?, read(&self.new)?);
        let name = |path: &Path| path.display().to_string();
        Ok(Compared { old: name(&self.old), new: name(&self.new), differences: compare(&old, &new) })
    }
}

fn read(path: &Path) -> Result<DeviceDescription> {
    description(&Description::read(path)?.bytes, path)
}
