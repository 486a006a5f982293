//! The kinds of SDO transfers and the ways in which they end, on two objects.

use super::by_hand::{MISSING, begin_upload, segment};
use crate::bench::Bench;
use crate::bench::objects::Scratch;
use crate::bench::sdo::DEVICE_TYPE;
use crate::verdict::{Judged, Precondition, Reason, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{AbortCode, BlockSegment, Payload, Request, Response};
use canvass_bus::client::block_download::DownloadManner;
use canvass_bus::client::block_upload::UploadManner;
use std::fmt;

/// A kind of transfer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Form {
    ExpeditedUpload,
    SegmentedUpload,
    BlockUpload { crc: bool },
    ExpeditedDownload { sized: bool },
    SegmentedDownload { sized: bool },
    BlockDownload { crc: bool, sized: bool },
}

/// The end of a transfer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum End {
    Complete,
    AbortedByClient,
    AbortedByServer,
    Abandoned,
}

impl Form {
    /// The kinds without block transfers.
    pub const PLAIN: [Self; 6] = [
        Self::ExpeditedUpload,
        Self::SegmentedUpload,
        Self::ExpeditedDownload { sized: true },
        Self::ExpeditedDownload { sized: false },
        Self::SegmentedDownload { sized: true },
        Self::SegmentedDownload { sized: false },
    ];

    /// All kinds.
    pub const ALL: [Self; 12] = [
        Self::ExpeditedUpload,
        Self::SegmentedUpload,
        Self::BlockUpload { crc: true },
        Self::BlockUpload { crc: false },
        Self::ExpeditedDownload { sized: true },
        Self::ExpeditedDownload { sized: false },
        Self::SegmentedDownload { sized: true },
        Self::SegmentedDownload { sized: false },
        Self::BlockDownload { crc: true, sized: true },
        Self::BlockDownload { crc: true, sized: false },
        Self::BlockDownload { crc: false, sized: true },
        Self::BlockDownload { crc: false, sized: false },
    ];

    pub const fn is_block(self) -> bool {
        matches!(self, Self::BlockUpload { .. } | Self::BlockDownload { .. })
    }

    pub const fn is_download(self) -> bool {
        matches!(self, Self::ExpeditedDownload { .. } | Self::SegmentedDownload { .. } | Self::BlockDownload { .. })
    }

    /// Whether the transfer lacks a CRC or a stated size.
    pub const fn is_variant(self) -> bool {
        match self {
            Self::ExpeditedUpload | Self::SegmentedUpload => false,
            Self::BlockUpload { crc } => !crc,
            Self::ExpeditedDownload { sized } | Self::SegmentedDownload { sized } => !sized,
            Self::BlockDownload { crc, sized } => !crc || !sized,
        }
    }

    /// The ways in which the transfer can end. An expedited transfer is over with its first answer.
    pub const fn ends(self) -> &'static [End] {
        match self {
            Self::ExpeditedUpload | Self::ExpeditedDownload { .. } => &[End::Complete, End::AbortedByServer],
            _ => &[End::Complete, End::AbortedByClient, End::AbortedByServer, End::Abandoned],
        }
    }
}

/// The kind in words: "a block download without CRC, of unstated size".
impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (kind, crc, sized) = match *self {
            Self::ExpeditedUpload => ("an expedited upload", true, true),
            Self::SegmentedUpload => ("a segmented upload", true, true),
            Self::BlockUpload { crc } => ("a block upload", crc, true),
            Self::ExpeditedDownload { sized } => ("an expedited download", true, sized),
            Self::SegmentedDownload { sized } => ("a segmented download", true, sized),
            Self::BlockDownload { crc, sized } => ("a block download", crc, sized),
        };
        write!(f, "{kind}{}{}", if crc { "" } else { " without CRC" }, if sized { "" } else { " without stated size" })
    }
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Complete => "that was complete",
            Self::AbortedByClient => "that the client aborted",
            Self::AbortedByServer => "that the server aborted",
            Self::Abandoned => "that the client abandoned",
        })
    }
}

/// The objects of the transfers, with their present values.
pub(super) struct Subjects {
    scratch: [Scratch; 2],
    held: [Vec<u8>; 2],
    /// An object that is uploaded in segments, with its value.
    long: Option<(Multiplexer, Vec<u8>)>,
}

impl Subjects {
    /// Two objects that can be written, if possible of different lengths, and an object of several segments. If the
    /// device has only one object that can be written, both transfers use it.
    pub fn find(bench: &mut Bench<'_>) -> Result<Self, Stop> {
        let found = bench.scratch_objects()?;
        let Some(one) = found.first().cloned() else {
            let reason = Reason::new("an object can be written and read back without consequence", "one", "none");
            return Err(Stop::NotApplicable(reason));
        };
        let others = || found.iter().skip(1);
        let other = others().find(|other| other.value.len() != one.value.len()).or_else(|| others().next());
        let scratch = [one.clone(), other.cloned().unwrap_or(one)];
        for one in &scratch {
            bench.write_confirmed(one.multiplexer, &one.value)?;
        }
        let long = match bench.long_object(8)? {
            // A value that changes by itself can't be compared after each of many transfers.
            Some(multiplexer) if !bench.moves(multiplexer)? => Some((multiplexer, bench.read(multiplexer)?)),
            _ => None,
        };
        let held = scratch.each_ref().map(|scratch| scratch.value.clone());
        Ok(Self { scratch, held, long })
    }

    /// Whether the device has an object for a transfer.
    pub const fn allow(&self, form: Form) -> bool {
        !matches!(form, Form::SegmentedUpload | Form::BlockUpload { .. }) || self.long.is_some()
    }

    /// Carries out a whole transfer and requires its effect. Returns whether the device has an object for it.
    ///
    /// # Errors
    /// A breach if the transfer fails, or reads or writes another value.
    pub fn complete(&mut self, bench: &mut Bench<'_>, form: Form, object: usize) -> Result<bool, Stop> {
        match form {
            Form::ExpeditedUpload => {
                let (at, right) = (self.scratch[object].multiplexer, self.held[object].clone());
                let value = bench.upload(at)?.value()?;
                gives(bench, at, &right, form, value)?;
            }
            Form::SegmentedUpload | Form::BlockUpload { .. } => {
                let Some((at, right)) = self.long.clone() else { return Ok(false) };
                let attempt = match form {
                    Form::BlockUpload { crc } => {
                        bench.block_upload(at, UploadManner { crc, ..UploadManner::default() })?.0
                    }
                    _ => bench.upload(at)?,
                };
                gives(bench, at, &right, form, attempt.value()?)?;
            }
            _ => self.download(bench, form, object)?,
        }
        Ok(true)
    }

    /// Writes the other of the two values of an object, which the object does not hold now, and reads the object back.
    fn download(&mut self, bench: &mut Bench<'_>, form: Form, object: usize) -> Judged {
        let Scratch { multiplexer: at, value, other } = &self.scratch[object];
        let new = if self.held[object] == *value { other.clone() } else { value.clone() };
        let at = *at;
        match form {
            Form::ExpeditedDownload { sized: false } => {
                let mut bytes = [0; 4];
                bytes.iter_mut().zip(&new).for_each(|(to, from)| *to = *from);
                initiated(bench, at, Payload::ExpeditedUnsized(bytes), form)?;
            }
            Form::SegmentedDownload { sized: true } => bench.download_segmented(at, &new)?.expect_confirmation()?,
            Form::SegmentedDownload { sized: false } => {
                initiated(bench, at, Payload::SegmentedUnsized, form)?;
                let reply = bench.exchange(&segment(false, &new, true)?, "the only download segment")?;
                reply.expect("its confirmation", |r| *r == Response::DownloadSegment { toggle: false })?;
            }
            Form::BlockDownload { crc, sized } => {
                let right = DownloadManner::right(&new);
                let announce = right.announce.filter(|_| sized);
                bench.block_download(at, &new, DownloadManner { crc, announce, ..right })?.0.expect_confirmation()?;
            }
            _ => bench.download(at, &new)?.expect_confirmation()?,
        }
        // The device may hold the value even if it can't be read back now.
        self.hold(at, &new);
        let value = bench.upload(at)?.value()?;
        gives(bench, at, &new, form, value)
    }

    fn hold(&mut self, at: Multiplexer, value: &[u8]) {
        for (scratch, held) in self.scratch.iter().zip(&mut self.held) {
            if scratch.multiplexer == at {
                *held = value.to_vec();
            }
        }
    }

    /// Brings a transfer to this end.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the transfer does not begin.
    pub fn end(&mut self, bench: &mut Bench<'_>, form: Form, end: End, object: usize) -> Judged {
        if end == End::Complete {
            return match self.complete(bench, form, object) {
                Err(Stop::Breach(_)) => self.settle(bench),
                done => done.map(|_| ()),
            };
        }
        let at = self.begin(bench, form, end, object)?;
        match end {
            End::AbortedByClient => abort(bench, at),
            End::AbortedByServer => self.provoke(bench, form, at),
            End::Complete | End::Abandoned => Ok(()),
        }
    }

    /// Begins a transfer, and returns its object. The client sends the first data, too, if that does not end the
    /// transfer.
    fn begin(&self, bench: &mut Bench<'_>, form: Form, end: End, object: usize) -> Result<Multiplexer, Stop> {
        let scratch = &self.scratch[object];
        let at = scratch.multiplexer;
        match form {
            Form::ExpeditedUpload | Form::ExpeditedDownload { .. } => Ok(at),
            Form::SegmentedUpload => {
                let Some((at, _)) = self.long else { return Ok(at) };
                begin_upload(bench, at)?;
                Ok(at)
            }
            Form::BlockUpload { crc } => {
                let Some((at, _)) = self.long else { return Ok(at) };
                let request = Request::InitiateBlockUpload { multiplexer: at, crc, block_size: 1, threshold: 0 };
                begun(bench, &request, form)?;
                bench.exchange(&Request::StartBlockUpload, "start of the segments")?;
                Ok(at)
            }
            Form::SegmentedDownload { sized } => {
                let size = u32::try_from(scratch.value.len()).unwrap_or(u32::MAX);
                let payload = if sized { Payload::Segmented(size) } else { Payload::SegmentedUnsized };
                begun(bench, &Request::InitiateDownload { multiplexer: at, payload }, form)?;
                if scratch.other.len() > 1 && end != End::AbortedByServer {
                    let first = scratch.other.get(..1).unwrap_or_default();
                    bench.exchange(&segment(false, first, false)?, "download segment")?;
                }
                Ok(at)
            }
            Form::BlockDownload { crc, sized } => {
                let size = u32::try_from(scratch.value.len()).ok().filter(|_| sized);
                begun(bench, &Request::InitiateBlockDownload { multiplexer: at, crc, size }, form)?;
                // Inside a block every message is a segment, so the client leaves only after the block.
                if end == End::Abandoned {
                    send_only_segment(bench, &scratch.other)?;
                }
                Ok(at)
            }
        }
    }

    /// Makes the server abort the transfer. If it does not, the client's abort ends the transfer.
    fn provoke(&self, bench: &mut Bench<'_>, form: Form, at: Multiplexer) -> Judged {
        let wrong = match form {
            Form::ExpeditedUpload => Request::upload(MISSING[0].0),
            Form::ExpeditedDownload { .. } => Request::download(DEVICE_TYPE, &[0; 4]),
            Form::SegmentedUpload => Request::UploadSegment { toggle: true },
            Form::SegmentedDownload { .. } => segment(true, &[0], false)?,
            Form::BlockUpload { .. } => Request::ConfirmBlockUpload { sequence: 127, block_size: 0 },
            Form::BlockDownload { .. } => {
                // No segment has the number 0.
                let mut message = [0; 8];
                BlockSegment { sequence: 0, last: false, data: [0; 7] }.emit(&mut message);
                bench.send_message(message)?;
                return match bench.wait_for_late_response()? {
                    Some(frame) if matches!(Response::read(frame.data()), Ok(Response::Abort(_))) => Ok(()),
                    _ => abort(bench, at),
                };
            }
        };
        match bench.exchange(&wrong, format!("a wrong request in {form}"))?.abort() {
            Some(_) => Ok(()),
            None => abort(bench, at),
        }
    }

    /// Ends whatever transfer may be open, and reads the values again.
    pub fn settle(&mut self, bench: &mut Bench<'_>) -> Judged {
        bench.make_server_idle();
        for at in self.scratch.each_ref().map(|scratch| scratch.multiplexer) {
            let now = bench.read(at)?;
            self.hold(at, &now);
        }
        Ok(())
    }
}

fn abort(bench: &mut Bench<'_>, at: Multiplexer) -> Judged {
    bench.send_request(&Request::abort(at, AbortCode::GENERAL))
}

/// Sends the first message of a transfer and requires that the server begins it.
fn begun(bench: &mut Bench<'_>, request: &Request, form: Form) -> Judged {
    let reply = bench.exchange(request, form.to_string())?;
    reply.expect("its start", |response| !matches!(response, Response::Abort(_))).or_inconclusive()
}

fn initiated(bench: &mut Bench<'_>, multiplexer: Multiplexer, payload: Payload, form: Form) -> Judged {
    let reply =
        bench.exchange(&Request::InitiateDownload { multiplexer, payload }, format!("{form} to {multiplexer}"))?;
    reply.expect("its confirmation", |response| *response == Response::InitiateDownload { multiplexer })?;
    Ok(())
}

/// Sends the only segment of a block download, and waits for the confirmation of the block.
fn send_only_segment(bench: &mut Bench<'_>, value: &[u8]) -> Judged {
    let (mut data, mut message) = ([0; 7], [0; 8]);
    data.iter_mut().zip(value).for_each(|(to, from)| *to = *from);
    BlockSegment { sequence: 1, last: true, data }.emit(&mut message);
    bench.send_message(message)?;
    bench.wait_for_late_response().map(|_| ())
}

fn gives(bench: &mut Bench<'_>, at: Multiplexer, right: &[u8], form: Form, value: Vec<u8>) -> Judged {
    bench.expect_same(at, right, value, format!("{at} has its value with {form}"))
}
