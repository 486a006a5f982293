//! Downloads of strings in combinations of length, kind of download, kind of upload, and what came before (CiA 301,
//! 7.2.4.2.1).

use super::by_hand::segment;
use super::transfers::Form;
use crate::bench::Bench;
use crate::bench::sdo::Attempt;
use crate::case;
use crate::covering;
use crate::dice::Dice;
use crate::verdict::{Breach, Judged, Stop, demand, tried};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{AbortCode, Payload, Request, Response};
use canvass_bus::client::Outcome;
use canvass_bus::client::block_download::DownloadManner;
use canvass_bus::client::block_upload::UploadManner;
use canvass_bus::observation::Observation;
use canvass_traces::Duration;

/// Time for the combinations on a live bus; further ones are left out, unless the user wants all.
const LIVE: Duration = Duration::from_millis(2_500);

/// Lengths of a value in bytes: all short ones, and those around whole segments.
const LENGTHS: [usize; 16] = [1, 2, 3, 4, 5, 6, 7, 8, 13, 14, 15, 20, 21, 22, 63, 64];

/// The order in which combinations are tried, so that the first ones differ in everything.
const ORDER: u64 = 1;

/// The kind of upload that reads the value back.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Reading {
    /// Expedited or in segments, as the server decides.
    Normal,
    Block {
        crc: bool,
        block_size: u8,
    },
}

/// What the client does before the download.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Before {
    Nothing,
    /// It aborts a segmented download to the same object after one segment.
    AbortedDownload,
    /// It reads the object in segments.
    Upload,
}

const BEFORE: [Before; 3] = [Before::Nothing, Before::AbortedDownload, Before::Upload];

/// A download that is confirmed can be read back byte for byte, and a download that is refused changes nothing: of each
/// length, with and without stated size, and after other transfers.
#[case(id = "301/sdo/transfer/combinations", clause = "CiA 301 7.2.4.2.1", confidence = Cited, level = Must,
       needs = [LongScratch, SegmentedDownload], catches = [SdoUnsizedSevenTruncated])]
fn combinations(bench: &mut Bench<'_>) -> Judged {
    let downloads = [Form::ExpeditedDownload { sized: true }, segmented(true), segmented(false)];
    every(bench, &downloads, &[Reading::Normal])
}

/// A block download that is confirmed can be read back byte for byte by every kind of upload, and one that is refused
/// changes nothing: of each length, with and without CRC and stated size, and after other transfers. The same holds for
/// other downloads that block uploads read back.
#[case(id = "301/sdo/transfer/block-combinations", clause = "CiA 301 7.2.4.2.1", confidence = Cited, level = Must,
       needs = [LongScratch, BlockDownload, BlockUpload], catches = [SdoBlockSevenWithoutCrcTruncated])]
fn block_combinations(bench: &mut Bench<'_>) -> Judged {
    let block = |crc, sized| Form::BlockDownload { crc, sized };
    let downloads = [block(true, true), block(true, false), block(false, true), block(false, false), segmented(true)];
    let read = |crc, block_size| Reading::Block { crc, block_size };
    every(bench, &downloads, &[Reading::Normal, read(true, 127), read(false, 127), read(true, 1), read(false, 2)])
}

const fn segmented(sized: bool) -> Form {
    Form::SegmentedDownload { sized }
}

fn every(bench: &mut Bench<'_>, downloads: &[Form], readings: &[Reading]) -> Judged {
    let at = bench.long_scratch()?;
    let mut held = bench.read(at)?;
    let rows = shuffled(covering::rows(&[LENGTHS.len(), downloads.len(), readings.len(), BEFORE.len()]));
    let (begun, mut count, mut confirmed) = (bench.now(), 0_usize, 0_usize);
    for row in &rows {
        let [length, download, reading, before] = row[..] else { continue };
        let is_late = bench.is_live() && !bench.options().exhaustive && bench.now().since(begun) > LIVE;
        if is_late {
            break;
        }
        count += 1;
        let value = text(LENGTHS[length], count);
        let trial =
            Trial { at, value, download: downloads[download], reading: readings[reading], before: BEFORE[before] };
        match trial.judge(bench, &mut held) {
            Ok(is_confirmed) => confirmed += usize::from(is_confirmed),
            Err(Stop::Breach(breach)) => {
                bench.check(Err(breach))?;
                // The next combination must not begin with the rest of this one.
                bench.make_server_idle();
                held = bench.read(at)?;
            }
            Err(stop) => return Err(stop),
        }
    }
    bench.note(format!("{count} of {} combinations, {confirmed} of them confirmed", rows.len()));
    tried(confirmed, "a length that the object can have")
}

/// The rows in an order of chance that is always the same.
fn shuffled(mut rows: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    let mut dice = Dice::new(ORDER);
    rows.sort_by_cached_key(|_| dice.next());
    rows
}

/// Letters that differ from one combination to the next.
fn text(length: usize, number: usize) -> Vec<u8> {
    (0..length).map(|n| b'a' + ((n + number) % 26) as u8).collect()
}

/// A download, and the upload that reads its value back.
struct Trial {
    at: Multiplexer,
    value: Vec<u8>,
    download: Form,
    reading: Reading,
    before: Before,
}

impl Trial {
    /// Writes and reads back; `held` is the value of the object. Returns whether the download was confirmed.
    fn judge(&self, bench: &mut Bench<'_>, held: &mut Vec<u8>) -> Result<bool, Stop> {
        self.prepare(bench)?;
        let attempt = self.write(bench)?;
        let is_confirmed = attempt.abort().is_none();
        if is_confirmed {
            attempt.expect_confirmation()?;
            held.clone_from(&self.value);
        }
        let found = self.read(bench)?.value()?;
        demand(found == *held, || {
            let what = if is_confirmed { "confirmed" } else { "refused" };
            let length = self.value.len();
            let duty = format!(
                "{} has the right value after {} of {length} bytes was {what}, read by {}",
                self.at, self.download, self.reading
            );
            Breach::new(self.at, duty).expected(Observation::Value(held.clone())).found(Observation::Value(found))
        })?;
        Ok(is_confirmed)
    }

    fn prepare(&self, bench: &mut Bench<'_>) -> Judged {
        match self.before {
            Before::Nothing => Ok(()),
            Before::Upload => bench.upload(self.at)?.value().map(|_| ()).map_err(Into::into),
            Before::AbortedDownload => {
                let request = Request::InitiateDownload { multiplexer: self.at, payload: Payload::Segmented(14) };
                let reply = bench.exchange(&request, format!("segmented download to {}", self.at))?;
                if reply.abort().is_some() {
                    // A string of fixed length.
                    return Ok(());
                }
                bench.exchange(&segment(false, &[b'-'; 7], false)?, "download segment")?;
                bench.send_request(&Request::abort(self.at, AbortCode::GENERAL))
            }
        }
    }

    fn write(&self, bench: &mut Bench<'_>) -> Result<Attempt, Stop> {
        match self.download {
            Form::BlockDownload { crc, sized } => {
                let right = DownloadManner::right(&self.value);
                let announce = right.announce.filter(|_| sized);
                Ok(bench.block_download(self.at, &self.value, DownloadManner { crc, announce, ..right })?.0)
            }
            Form::SegmentedDownload { sized: false } => self.write_unsized(bench),
            Form::SegmentedDownload { sized: true } => bench.download_segmented(self.at, &self.value),
            _ => bench.download(self.at, &self.value),
        }
    }

    /// Writes the value in segments without telling its size before.
    fn write_unsized(&self, bench: &mut Bench<'_>) -> Result<Attempt, Stop> {
        let what = format!("segmented download of {} bytes without stated size to {}", self.value.len(), self.at);
        let request = Request::InitiateDownload { multiplexer: self.at, payload: Payload::SegmentedUnsized };
        let mut reply = bench.exchange(&request, what.clone())?;
        let begun = Response::InitiateDownload { multiplexer: self.at };
        let mut is_right = reply.response == Some(begun);
        let mut toggle = false;
        let segments = self.value.chunks(7);
        let last = segments.len();
        for (number, data) in (1..).zip(segments) {
            if !is_right {
                break;
            }
            reply = bench.exchange(&segment(toggle, data, number == last)?, what.clone())?;
            is_right = reply.response == Some(Response::DownloadSegment { toggle });
            toggle = !toggle;
        }
        let outcome = match (&reply.response, is_right) {
            (_, true) => Outcome::Downloaded,
            (Some(Response::Abort(abort)), _) => Outcome::Aborted(*abort),
            _ => {
                reply.expect("its confirmation", |_| false)?;
                Outcome::Silent
            }
        };
        Ok(Attempt { multiplexer: self.at, what, outcome, responses: reply.frame.into_iter().collect() })
    }

    fn read(&self, bench: &mut Bench<'_>) -> Result<Attempt, Stop> {
        match self.reading {
            Reading::Normal => bench.upload(self.at),
            Reading::Block { crc, block_size } => {
                let manner = UploadManner { crc, block_sizes: vec![block_size], ..UploadManner::default() };
                Ok(bench.block_upload(self.at, manner)?.0)
            }
        }
    }
}

impl std::fmt::Display for Reading {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Normal => f.write_str("an upload"),
            Self::Block { crc, block_size } => {
                write!(f, "a block upload{} in blocks of {block_size}", if *crc { "" } else { " without CRC" })
            }
        }
    }
}
