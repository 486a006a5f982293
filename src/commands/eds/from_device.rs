//! `canvass eds from-device`: makes a description from a device.

use super::device::DeviceArgs;
use crate::commands::sdo::object::hexadecimal;
use crate::destination::refuse_existing;
use crate::output::{diagnostic, write_bytes};
use crate::provenance::date_of_file;
use crate::status::{Failure, Status};
use crate::whole_file::write_whole;
use anyhow::{Result, anyhow};
use canvass_analyzer::dictionary::FileInfo;
use canvass_analyzer::dictionary::survey::describe::{Scan, Scanned};
use canvass_analyzer::{Index, Multiplexer, NodeId};
use canvass_bus::client::SurveyError;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Create a first description from a device; nothing is written to the device
///
/// canvass reads every index by SDO. Objects that CiA 301, 302, 304, 402 or 406 define get their names, types and
/// access from the standard; those of other objects are guessed from the values read, and comments in the file say so.
/// Defaults are the values read. Reading all indexes takes some minutes on a live bus: --range reads fewer. If the
/// bus or the device is lost, or on Ctrl-C, the objects read until then are written; the file says which are missing,
/// and the exit status is not 0.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  canvass eds from-device can0 --node 5 -o motor.eds
  canvass eds from-device can0 --node 5 --range 1000-1FFF --range 6000-67FF > motor.eds")]
pub struct Args {
    #[command(flatten)]
    device: DeviceArgs,
    /// The EDS to write (default: standard output)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Overwrite FILE if it exists
    #[arg(long)]
    force: bool,
    /// The indexes to read, in hexadecimal, such as 1000-1FFF; may be given several times
    ///
    /// By default 1000 to BFFF, and samples of C000 to FFFF, which CiA 301 reserves; if a sample exists, all of them.
    #[arg(long, value_name = "FIRST-LAST")]
    range: Vec<IndexRange>,
}

/// The indexes that CiA 301 gives a use (7.4.1), and those that it reserves.
const USED: RangeInclusive<u16> = 0x1000..=0xBFFF;
const RESERVED: RangeInclusive<u16> = 0xC000..=0xFFFF;

/// Indexes as typed: `1000-1FFF`, or `1018`.
#[derive(Clone, Debug, PartialEq, Eq)]
struct IndexRange(RangeInclusive<u16>);

impl FromStr for IndexRange {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = || anyhow!("expected indexes from 1000 to FFFF, such as 1000-1FFF, found \"{text}\"");
        let index = |text: &str| hexadecimal(text).filter(|&index| index >= 0x1000);
        let (first, last) = text.split_once('-').unwrap_or((text, text));
        let (first, last) = (index(first).ok_or_else(wrong)?, index(last).ok_or_else(wrong)?);
        if first > last {
            return Err(wrong());
        }
        Ok(Self(first..=last))
    }
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let ending = self.output.as_deref().and_then(Path::extension);
        if ending.is_some_and(|ending| ending.eq_ignore_ascii_case("dcf") || ending.eq_ignore_ascii_case("xdc")) {
            return Err(anyhow!(
                "this writes an EDS, without the values of one device: `canvass dcf read` writes a DCF"
            )
            .into());
        }
        if let Some(path) = self.output.as_deref().filter(|_| !self.force) {
            refuse_existing(path)?;
        }
        let (scanned, missing) = self.scan()?;
        let text = scanned.eds();
        match &self.output {
            Some(path) => write_whole(path, text.as_bytes())?,
            None => {
                write_bytes(text.as_bytes())?;
            }
        }
        tell(&scanned);
        let Some(Missing { what, status }) = missing else { return Ok(Status::Good) };
        diagnostic(&format!("canvass: {what}: the description holds the objects read until then"));
        Ok(status)
    }

    /// Reads the device; the second value names the part that was not read.
    fn scan(&self) -> Result<(Scanned, Option<Missing>), Failure> {
        let mut opened = self.device.open(None)?;
        let surveyed = opened.survey(|surveyor| {
            for at in canvass_analyzer::dictionary::survey::compare::IDENTITY {
                surveyor.read(at)?;
            }
            if self.range.is_empty() {
                let stopped = surveyor.area(USED)?;
                return if stopped.is_some() { Ok(stopped) } else { surveyor.reserved(RESERVED) };
            }
            for range in &self.range {
                if let Some(index) = surveyor.area(range.0.clone())? {
                    return Ok(Some(index));
                }
            }
            Ok(None)
        })?;
        let (node, bit_rate) = (opened.node, opened.bit_rate());
        let is_empty = surveyed.survey.counts().1 == 0;
        let missing = match surveyed.done {
            Ok(None) => None,
            Ok(Some(index)) => Some(Missing::area(node, index)),
            // Without a single object there is nothing to describe.
            Err(error) if is_empty => return Err(Failure::unreachable(error)),
            Err(error) => Some(Missing::since(&error, surveyed.unread)),
        };
        let file = self.file(missing.as_ref())?;
        Ok((Scan { survey: &surveyed.survey, node, bit_rate, file }.describe(), missing))
    }

    /// The description's section on the file itself.
    fn file(&self, missing: Option<&Missing>) -> Result<FileInfo> {
        let description = missing.map_or_else(
            || "Read from a device".to_owned(),
            |missing| format!("Read from a device, in part: {}", missing.what),
        );
        file_info(self.output.as_deref(), "device.eds", description)
    }
}

/// The section on the file itself of a description that is written now; `usual` is the name of a file without one.
pub fn file_info(output: Option<&Path>, usual: &str, description: String) -> Result<FileInfo> {
    let name = output.and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
    let at = date_of_file()?;
    let moment = (at.strftime("%m-%d-%Y").to_string(), at.strftime("%I:%M%p").to_string());
    Ok(FileInfo {
        name: name.unwrap_or_else(|| usual.to_owned()),
        version: "1".to_owned(),
        revision: "1".to_owned(),
        description,
        created: moment.clone(),
        created_by: format!("canvass {}", env!("CARGO_PKG_VERSION")),
        modified: moment,
        modified_by: format!("canvass {}", env!("CARGO_PKG_VERSION")),
        ..FileInfo::default()
    })
}

/// The part of a device that was not read.
struct Missing {
    what: String,
    status: Status,
}

impl Missing {
    /// The missing part if the device stays silent for absent objects: all objects from `index` on, because reading
    /// each of them would cost a timeout.
    fn area(node: NodeId, index: Index) -> Self {
        let what = format!(
            "node {node} does not answer requests for absent objects (expected: abort 0602 0000h): nothing was read \
             from {index} on; name the indexes with --range"
        );
        Self { what, status: Status::Unreachable }
    }

    /// The missing part if an error ended the reading: all objects from `unread` on.
    fn since(error: &SurveyError, unread: Option<Multiplexer>) -> Self {
        let from = unread.map(|at| format!(", from {at} on")).unwrap_or_default();
        match error {
            SurveyError::Ended => Self { what: format!("{error}{from}"), status: Status::Findings },
            SurveyError::Bus(_) => {
                Self { what: format!("{error}{from} nothing was read"), status: Status::Unreachable }
            }
            _ => Self { what: error.to_string(), status: Status::Unreachable },
        }
    }
}

fn tell(scanned: &Scanned) {
    let dictionary = &scanned.description.dictionary;
    let (objects, entries) = (dictionary.objects().len(), dictionary.entries().count());
    let guessed = scanned.guesses.len();
    diagnostic(&format!("canvass: {objects} objects with {entries} entries, {guessed} of them partly guessed"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_as_typed() {
        let range = |text: &str| text.parse::<IndexRange>().map(|range| range.0);
        assert_eq!(range("1000-1FFF").unwrap(), 0x1000..=0x1FFF);
        assert_eq!(range("1018").unwrap(), 0x1018..=0x1018);
        assert_eq!(range("1000h-2FFFh").unwrap(), 0x1000..=0x2FFF);
        assert_eq!(range("0x1000-0x2fff").unwrap(), 0x1000..=0x2FFF);
        for wrong in ["", "0-1FFF", "1FFF-1000", "1000-", "10000", "1000-1FFF-2000", "x"] {
            assert!(range(wrong).is_err(), "{wrong}");
        }
    }
}
