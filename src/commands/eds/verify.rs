//! `canvass eds verify`: compares a device with its description.

use super::device::DeviceArgs;
use super::found::{Description, description};
use crate::output::{Color, TextJsonOrMarkdown, terminal_width};
use crate::status::{Failure, Status};
use canvass_analyzer::dictionary::survey::compare::{IDENTITY, compare};
use canvass_reports::descriptions::verification::Verification;
use canvass_reports::document::Style;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// Compare a device with its description: read everything, write nothing
///
/// canvass reads every described entry by SDO and checks its existence, length, value (against limits and default),
/// COB-IDs and PDO mapping. It looks for undescribed objects in the communication profile area or, with --all, at all
/// indexes. A writable value may have been configured: a difference from its default is shown, but makes the exit
/// status 1 only with --as-delivered. Checks that need writing are left out.
#[derive(clap::Args)]
pub struct Args {
    /// An EDS, DCF, XDD or XDC file; - is standard input
    file: PathBuf,
    #[command(flatten)]
    device: DeviceArgs,
    /// Look for undescribed objects at every index from 1000h to FFFFh: a minute or more on a live bus
    #[arg(long)]
    all: bool,
    /// Count every difference from a default, because the device was never configured
    #[arg(long)]
    as_delivered: bool,
    /// How to print the differences
    #[arg(long, value_enum, default_value_t)]
    format: TextJsonOrMarkdown,
}

/// The default range for undescribed objects.
const COMMUNICATION_PROFILE: RangeInclusive<u16> = 0x1000..=0x1FFF;
const ALL: RangeInclusive<u16> = 0x1000..=0xFFFF;

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        let verification = self.verify()?;
        let style = Style { color: color.on_stdout(), width: terminal_width() };
        self.format.print(&verification, style)?;
        let differs = verification.differences().next().is_some();
        Ok(if differs { Status::Findings } else { Status::Good })
    }

    fn verify(&self) -> Result<Verification, Failure> {
        let description = description(&Description::read(&self.file)?.bytes, &self.file)?;
        let configured = description.commissioning.as_ref().and_then(|commissioning| commissioning.node_id);
        let mut opened = self.device.open(configured)?;
        let surveyed = opened.survey(|surveyor| {
            for at in IDENTITY {
                surveyor.read(at)?;
            }
            surveyor.described(&description)?;
            surveyor.area(if self.all { ALL } else { COMMUNICATION_PROFILE })
        })?;
        let (survey, given_up) = (surveyed.survey, surveyed.done.map_err(Failure::unreachable)?);
        let (read, existing) = survey.counts();
        Ok(Verification {
            file: self.file.display().to_string(),
            bus: self.device.bus.clone(),
            node: opened.node,
            as_delivered: self.as_delivered,
            read,
            existing,
            given_up,
            mismatches: compare(&description, &survey, opened.node),
        })
    }
}
