//! Compares the frames of the server with the allowed answers.

use super::super::codes::{self, CodeSet};
use super::super::expected_values::ExpectedValues;
use super::super::{Served, Violation, violation};
use super::awaited::{Awaited, Reading, Writing};
use super::block::Upload;
use super::{LONGEST, Server, TransferState};
use crate::Knowledge;
use crate::coverage::{Answer, Coverage};
use crate::property::Property;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{Abort, AbortCode, BlockSegment, Payload, Response, Segment, crc16};
use canvass_traces::{Frame, Timestamp, hex};

/// The violation in an answer: the property, the expected value if it differs from the text of the awaited answer, and
/// the actual value.
struct Wrong {
    property: Property,
    expected: Option<String>,
    actual: String,
    /// The abort code, if only the code of the abort is wrong.
    abort: Option<AbortCode>,
}

type Judged = Result<(), Wrong>;

fn wrong(property: Property, actual: impl Into<String>) -> Wrong {
    Wrong { property, expected: None, actual: actual.into(), abort: None }
}

fn instead(property: Property, expected: impl Into<String>, actual: impl Into<String>) -> Wrong {
    Wrong { property, expected: Some(expected.into()), actual: actual.into(), abort: None }
}

/// The violation of an answer that does not fit the request.
fn illegal(frame: &Frame) -> Wrong {
    wrong(Property::LegalSdo, shown(frame))
}

/// Returns the abort in a response. Any other response is a violation here.
fn only_abort(response: Response, frame: &Frame) -> Result<Abort, Wrong> {
    match response {
        Response::Abort(abort) => Ok(abort),
        _ => Err(illegal(frame)),
    }
}

impl Server {
    /// Checks a frame of the server. `true`: the models can't follow its effect.
    ///
    /// # Errors
    /// [`Violation`] if the server must not send it now.
    pub fn answered(
        &mut self,
        now: Timestamp,
        frame: &Frame,
        served: Served,
        knowledge: &Knowledge,
        expected_values: &mut ExpectedValues,
        coverage: &mut Coverage,
    ) -> Result<bool, Violation> {
        if now < self.grace && self.awaited == Awaited::Nothing {
            return Ok(false);
        }
        let awaited = self.awaited;
        if served == Served::No {
            let expected = "no SDO response in an NMT state without SDO";
            return Err(violation(Property::Silent, "SDO in a state without SDO", expected, shown(frame), now));
        }
        self.last = now;
        let judged = self.judge(now, frame, knowledge, expected_values, coverage);
        judged.map(|()| expected_values.has_stored(knowledge)).map_err(|wrong| {
            let expected = wrong.expected.unwrap_or_else(|| awaited.text());
            self.reset();
            let violation = violation(wrong.property, awaited.rule(), expected, wrong.actual, now);
            Violation { abort: wrong.abort, ..violation }
        })
    }

    fn judge(
        &mut self,
        now: Timestamp,
        frame: &Frame,
        knowledge: &Knowledge,
        expected_values: &mut ExpectedValues,
        coverage: &mut Coverage,
    ) -> Judged {
        if frame.len() != 8 {
            return Err(instead(Property::LegalSdo, "an SDO response of eight bytes", shown(frame)));
        }
        if let Awaited::Block = self.awaited
            && frame.data().first() != Some(&0x80)
        {
            self.count(coverage, Answer::Block);
            return self.judge_block(frame);
        }
        let Ok(response) = Response::read(frame.data()) else {
            return Err(wrong(Property::LegalSdo, shown(frame)));
        };
        if self.is_of_ended(now, response, knowledge) {
            return Ok(());
        }
        let awaited = self.take_awaited();
        // A segment of a block can contain any bytes.
        if awaited != Awaited::Anything {
            check_reserved(frame, response)?;
        }
        self.count(coverage, Answer::of(&response));
        self.judge_response(awaited, response, frame, knowledge, expected_values)
    }

    /// Returns the allowed answers, and forgets them, as each request has only one answer. `Anything` is kept.
    fn take_awaited(&mut self) -> Awaited {
        let awaited = self.awaited;
        if awaited != Awaited::Anything {
            self.awaited = Awaited::Nothing;
        }
        self.due = Timestamp::MAX;
        awaited
    }

    fn judge_response(
        &mut self,
        awaited: Awaited,
        response: Response,
        frame: &Frame,
        knowledge: &Knowledge,
        expected_values: &mut ExpectedValues,
    ) -> Judged {
        if self.is_given_up(awaited, response) || self.is_unknown(awaited, response) {
            self.give_up(expected_values);
            return Ok(());
        }
        match awaited {
            Awaited::Nothing => Err(unsolicited(frame)),
            Awaited::Anything => self.anything_came(response, frame, expected_values),
            Awaited::Abort { codes, at, .. } => check_abort(only_abort(response, frame)?, codes, at),
            Awaited::AbortOrIgnored => self.given_up(response, codes::TOGGLE, frame, expected_values),
            Awaited::Read(reading) => match response {
                Response::InitiateUpload { multiplexer, payload } => {
                    self.upload_begins(multiplexer, payload, reading, knowledge, expected_values)
                }
                other => refused_read(only_abort(other, frame)?, reading),
            },
            Awaited::BlockRead { reading, block_size, threshold, crc } => match response {
                Response::InitiateUpload { multiplexer, payload } => {
                    check_threshold(&payload, threshold, frame)?;
                    self.upload_begins(multiplexer, payload, reading, knowledge, expected_values)
                }
                other => self.block_upload_begins(reading, (block_size, crc), other, frame, knowledge),
            },
            Awaited::Write { at, writing } => match response {
                Response::InitiateDownload { multiplexer } => {
                    check_multiplexer(multiplexer, at)?;
                    confirm(writing, frame, knowledge, expected_values)
                }
                other => refused_write(only_abort(other, frame)?, at, writing, expected_values),
            },
            Awaited::BeginDownload { at, writing, announced } => match response {
                // An object that can't be written has to be refused, at once or at the end.
                Response::InitiateDownload { multiplexer } => {
                    self.state = TransferState::Download { at, entry: writing.entry, toggle: false, announced };
                    check_multiplexer(multiplexer, at)
                }
                other => refused_write(only_abort(other, frame)?, at, writing, expected_values),
            },
            Awaited::BeginBlockDownload { at, writing, announced, crc } => {
                self.block_download_begins(at, writing, (announced, crc), response, frame, expected_values)
            }
            Awaited::ConfirmSegment { toggle, last } => {
                self.segment_answered(toggle, last, response, frame, knowledge, expected_values)
            }
            Awaited::Segment { toggle } => match response {
                Response::UploadSegment(segment) if segment.toggle == toggle => {
                    self.segment_came(segment, frame, knowledge, expected_values)
                }
                other => self.ended(other, codes::NO_DATA, frame),
            },
            Awaited::ConfirmBlock { sequence, last, .. } => match response {
                Response::ConfirmBlockDownload { sequence: confirmed, block_size } => {
                    self.block_confirmed(sequence, confirmed, block_size, last, frame)
                }
                other => self.given_up(other, codes::IN_BLOCK_DOWNLOAD, frame, expected_values),
            },
            Awaited::ConfirmEnd { at, mut writing } => match response {
                Response::EndBlockDownload => confirm(writing, frame, knowledge, expected_values),
                other => {
                    writing.may = writing.may.or(codes::TOO_LONG).or(codes::TOO_SHORT);
                    refused_late(only_abort(other, frame)?, at, writing, expected_values)
                }
            },
            Awaited::Block => self.ended(response, codes::NO_DATA.or(codes::COMMAND), frame),
            Awaited::EndOfBlocks { upload, odd_size } => match response {
                Response::EndBlockUpload { unused, crc } => {
                    self.blocks_end(upload, unused, crc, knowledge, expected_values)
                }
                other if odd_size => self.ended(other, codes::BLOCK_SIZE.or(codes::COMMAND), frame),
                _ => Err(illegal(frame)),
            },
        }
    }

    /// Whether the server reports a time-out where a time-out is allowed: a transfer is in progress, and no answer is
    /// due.
    fn is_given_up(&self, awaited: Awaited, response: Response) -> bool {
        let may_be_silent = matches!(
            awaited,
            Awaited::Nothing | Awaited::AbortOrIgnored | Awaited::ConfirmBlock { required: false, .. }
        );
        let is_time_out = matches!(response, Response::Abort(abort) if abort.code == AbortCode::TIMEOUT);
        is_time_out && may_be_silent && self.state != TransferState::Idle
    }

    /// Whether the server reports a time-out of a transfer that the client has just ended. The awaited answer then
    /// still has to come.
    fn is_of_ended(&self, now: Timestamp, response: Response, knowledge: &Knowledge) -> bool {
        let is_time_out = matches!(response, Response::Abort(abort) if abort.code == AbortCode::TIMEOUT);
        is_time_out && self.ended.is_some_and(|ended| now.since(ended) <= knowledge.patience.answer)
    }

    /// Whether the server reports an unknown command to a request with reserved bits set. Like any request of an
    /// unknown command, it names no object.
    fn is_unknown(&self, awaited: Awaited, response: Response) -> bool {
        let is_refused = matches!(response, Response::Abort(abort) if codes::COMMAND.has(abort.code));
        is_refused && self.odd && (awaited.is_required() || awaited == Awaited::AbortOrIgnored)
    }

    /// Checks an answer that has to be an abort with one of the codes. The state of the data sent before is unknown.
    fn given_up(
        &mut self,
        response: Response,
        codes: CodeSet,
        frame: &Frame,
        expected_values: &mut ExpectedValues,
    ) -> Judged {
        let abort = only_abort(response, frame)?;
        self.give_up(expected_values);
        check_abort(abort, codes, None)
    }

    /// Checks an answer that has to be an abort with one of the codes. The abort ends the transfer.
    fn ended(&mut self, response: Response, codes: CodeSet, frame: &Frame) -> Judged {
        let abort = only_abort(response, frame)?;
        self.state = TransferState::Idle;
        check_abort(abort, codes, None)
    }

    /// Checks the answer to "initiate block upload". `asked`: the block size, and whether the client supports the CRC.
    fn block_upload_begins(
        &mut self,
        reading: Reading,
        asked: (u8, bool),
        response: Response,
        frame: &Frame,
        knowledge: &Knowledge,
    ) -> Judged {
        let Response::InitiateBlockUpload { multiplexer, crc: server, size: announced } = response else {
            return refused_read(only_abort(response, frame)?, reading);
        };
        check_multiplexer(multiplexer, reading.at)?;
        check_readable(reading, frame)?;
        check_size(announced, reading, knowledge)?;
        let (size, crc) = (asked.0, asked.1 && server);
        self.state = TransferState::BlockUploadReady { at: reading.at, entry: reading.entry, announced, size, crc };
        Ok(())
    }

    /// Checks the answer to "initiate block download". `asked`: the announced size, and whether the client supports the
    /// CRC.
    fn block_download_begins(
        &mut self,
        at: Multiplexer,
        writing: Writing,
        asked: (Option<u32>, bool),
        response: Response,
        frame: &Frame,
        expected_values: &mut ExpectedValues,
    ) -> Judged {
        let Response::InitiateBlockDownload { multiplexer, crc: server, block_size: size } = response else {
            return refused_write(only_abort(response, frame)?, at, writing, expected_values);
        };
        check_multiplexer(multiplexer, at)?;
        check_block_size(size, frame)?;
        let ((announced, client), entry) = (asked, writing.entry);
        let crc = client && server;
        self.state = TransferState::BlockDownload { at, entry, announced, size, sequence: 0, crc, gap: false };
        Ok(())
    }

    /// Learns the state of the server from an answer that could not be predicted, unless it can be a segment of a
    /// block.
    fn anything_came(&mut self, response: Response, frame: &Frame, expected_values: &mut ExpectedValues) -> Judged {
        self.state = match response {
            Response::Abort(_) if frame.bytes()[0] == 0x80 => TransferState::Idle,
            Response::InitiateUpload { payload: Payload::Expedited(_), multiplexer }
                if self.named == Some(multiplexer) =>
            {
                TransferState::Idle
            }
            _ => TransferState::Unsure,
        };
        match response {
            Response::InitiateDownload { multiplexer } => expected_values.forget(Some(multiplexer)),
            Response::DownloadSegment { .. } | Response::EndBlockDownload => expected_values.forget(None),
            _ => {}
        }
        Ok(())
    }

    fn upload_begins(
        &mut self,
        multiplexer: Multiplexer,
        payload: Payload,
        reading: Reading,
        knowledge: &Knowledge,
        expected_values: &mut ExpectedValues,
    ) -> Judged {
        check_multiplexer(multiplexer, reading.at)?;
        if !reading.must.is_empty() {
            return Err(wrong(Property::Consistent, format!("a value: {payload:?}")));
        }
        let known = reading.entry.and_then(|entry| knowledge.entries().get(entry));
        match payload {
            Payload::Expedited(value) => {
                check_length(value.data().len(), reading, knowledge)?;
                check_value(value.data(), reading.entry, knowledge, expected_values)
            }
            Payload::ExpeditedUnsized(value) => {
                let size = known.and_then(|known| known.size).unwrap_or(4).min(4);
                check_value(&value[..size], reading.entry, knowledge, expected_values)
            }
            Payload::Segmented(size) => {
                check_size(Some(size), reading, knowledge)?;
                self.begin_segments(reading, Some(size));
                Ok(())
            }
            Payload::SegmentedUnsized => {
                self.begin_segments(reading, None);
                Ok(())
            }
        }
    }

    fn begin_segments(&mut self, reading: Reading, announced: Option<u32>) {
        self.data.clear();
        self.state = TransferState::Upload { at: reading.at, entry: reading.entry, toggle: false, announced };
    }

    fn segment_came(
        &mut self,
        segment: Segment,
        frame: &Frame,
        knowledge: &Knowledge,
        expected_values: &mut ExpectedValues,
    ) -> Judged {
        let TransferState::Upload { at, entry, toggle, announced } = self.state else { return Ok(()) };
        if self.data.len() < LONGEST {
            self.data.extend_from_slice(segment.data());
        }
        let received = self.data.len() as u32;
        if announced.is_some_and(|size| received > size) {
            let expected = format!("at most the {} announced bytes", announced.unwrap_or(0));
            return Err(instead(Property::LegalSdo, expected, format!("{received} bytes with {}", shown(frame))));
        }
        if !segment.last {
            if announced == Some(received) {
                let expected = format!("the last of {received} bytes marked as the last");
                return Err(instead(Property::LegalSdo, expected, shown(frame)));
            }
            self.state = TransferState::Upload { at, entry, toggle: !toggle, announced };
            return Ok(());
        }
        self.state = TransferState::Idle;
        if announced.is_some_and(|size| received < size) {
            let expected = format!("all {} announced bytes", announced.unwrap_or(0));
            return Err(instead(Property::LegalSdo, expected, format!("the end after {received}")));
        }
        let reading = Reading { at, entry, must: CodeSet::NONE, may: CodeSet::NONE };
        check_length(self.data.len(), reading, knowledge)?;
        check_value(&self.data, entry, knowledge, expected_values)
    }

    fn segment_answered(
        &mut self,
        toggle: bool,
        last: Option<(Multiplexer, Writing)>,
        response: Response,
        frame: &Frame,
        knowledge: &Knowledge,
        expected_values: &mut ExpectedValues,
    ) -> Judged {
        match (response, last) {
            (Response::DownloadSegment { toggle: confirmed }, _) if confirmed != toggle => {
                Err(wrong(Property::LegalSdo, shown(frame)))
            }
            (Response::DownloadSegment { .. }, None) => Ok(()),
            (Response::DownloadSegment { .. }, Some((_, writing))) => {
                confirm(writing, frame, knowledge, expected_values)
            }
            (Response::Abort(abort), None) => {
                // The server may refuse a wrong length, or an object that can't be written, before the end.
                self.give_up(expected_values);
                let early = codes::TOO_LONG.or(codes::TOO_SHORT).or(codes::REFUSED).or(codes::READ_ONLY);
                check_abort(abort, early.or(codes::NO_OBJECT).or(codes::NO_SUB_INDEX), None)
            }
            (Response::Abort(abort), Some((at, writing))) => refused_late(abort, at, writing, expected_values),
            _ => Err(wrong(Property::LegalSdo, shown(frame))),
        }
    }

    fn block_confirmed(&mut self, sequence: u8, confirmed: u8, block_size: u8, last: bool, frame: &Frame) -> Judged {
        if confirmed != sequence {
            return Err(wrong(Property::LegalSdo, shown(frame)));
        }
        if !last {
            check_block_size(block_size, frame)?;
        }
        if let TransferState::BlockDownload { at, entry, announced, crc, .. } = self.state {
            self.state =
                TransferState::BlockDownload { at, entry, announced, size: block_size, sequence: 0, crc, gap: false };
        }
        Ok(())
    }

    fn judge_block(&mut self, frame: &Frame) -> Judged {
        let TransferState::BlockUpload(mut upload) = self.state else { return Ok(()) };
        let Ok(segment) = BlockSegment::read(frame.data()) else { return Ok(()) };
        if segment.sequence != upload.sequence + 1 {
            let expected = format!("the segment with sequence number {}", upload.sequence + 1);
            return Err(instead(Property::LegalSdo, expected, shown(frame)));
        }
        upload.sequence = segment.sequence;
        upload.complete = segment.last;
        if self.data.len() < LONGEST {
            self.data.extend_from_slice(&segment.data);
        }
        let received = self.data.len() as u32;
        if upload.announced.is_some_and(|size| received >= size.max(1).saturating_add(7)) {
            let expected = format!("no more segments than {} bytes need", upload.announced.unwrap_or(0));
            return Err(instead(Property::LegalSdo, expected, shown(frame)));
        }
        self.state = TransferState::BlockUpload(upload);
        if upload.is_sent() {
            self.awaited = Awaited::Nothing;
            self.due = Timestamp::MAX;
        }
        Ok(())
    }

    fn blocks_end(
        &mut self,
        upload: Upload,
        unused: u8,
        crc: u16,
        knowledge: &Knowledge,
        expected_values: &mut ExpectedValues,
    ) -> Judged {
        let len = self.data.len().saturating_sub(usize::from(unused));
        self.data.truncate(len);
        if upload.announced.is_some_and(|size| size as usize != len) {
            let expected = format!("{} bytes, as announced", upload.announced.unwrap_or(0));
            return Err(instead(Property::LegalSdo, expected, format!("{len} bytes")));
        }
        // Without CRC the field is 0 (CiA 301, 7.2.4.3.15).
        let right = if upload.crc { crc16(0, &self.data) } else { 0 };
        if crc != right {
            return Err(instead(Property::LegalSdo, format!("the checksum {right:04X}h"), format!("{crc:04X}h")));
        }
        let reading = Reading { at: upload.at, entry: upload.entry, must: CodeSet::NONE, may: CodeSet::NONE };
        check_length(len, reading, knowledge)?;
        check_value(&self.data, upload.entry, knowledge, expected_values)
    }
}

/// The frame as text: `43 00 10 00 96 01 01 00`, or an abort in words.
fn shown(frame: &Frame) -> String {
    let bytes = hex::spaced(frame.data());
    match Response::read(frame.data()) {
        Ok(Response::Abort(abort)) => {
            format!("{bytes} (abort {} of {})", abort.code.digits(), abort.multiplexer)
        }
        _ => bytes.to_string(),
    }
}

fn unsolicited(frame: &Frame) -> Wrong {
    instead(Property::OneAnswer, "no response: none is outstanding", shown(frame))
}

/// Checks that reserved bytes and bits are 0. Unused bytes of a value may hold anything.
fn check_reserved(frame: &Frame, response: Response) -> Judged {
    let mut expected = [0; 8];
    response.emit(&mut expected);
    let mut actual = frame.bytes();
    let free = match response {
        Response::InitiateUpload { payload: Payload::Expedited(value), .. } => 4 + value.data().len()..8,
        Response::UploadSegment(segment) => 1 + segment.data().len()..8,
        _ => 8..8,
    };
    actual[free.clone()].copy_from_slice(&expected[free]);
    if actual == expected {
        return Ok(());
    }
    Err(instead(Property::LegalSdo, format!("reserved bits and bytes 0: {expected:02X?}"), shown(frame)))
}

fn check_multiplexer(actual: Multiplexer, expected: Multiplexer) -> Judged {
    if actual == expected {
        return Ok(());
    }
    Err(instead(
        Property::LegalSdo,
        format!("an answer that names {expected}"),
        format!("an answer that names {actual}"),
    ))
}

fn check_abort(abort: Abort, codes: CodeSet, at: Option<Multiplexer>) -> Judged {
    if let Some(at) = at {
        check_multiplexer(abort.multiplexer, at)?;
    }
    if codes.has(abort.code) {
        return Ok(());
    }
    let wrong = instead(Property::LegalSdo, format!("abort {}", codes.text()), coded(abort.code));
    Err(Wrong { abort: Some(abort.code), ..wrong })
}

/// The code as text: `abort 0602 0000h`.
fn coded(code: AbortCode) -> String {
    format!("abort {:04X} {:04X}h", code.0 >> 16, code.0 & 0xFFFF)
}

fn check_readable(reading: Reading, frame: &Frame) -> Judged {
    if reading.must.is_empty() { Ok(()) } else { Err(wrong(Property::Consistent, shown(frame))) }
}

fn refused_read(abort: Abort, reading: Reading) -> Judged {
    check_multiplexer(abort.multiplexer, reading.at)?;
    let codes = reading.must.or(reading.may);
    if codes.has(abort.code) {
        return Ok(());
    }
    Err(Wrong { abort: Some(abort.code), ..wrong(Property::Consistent, coded(abort.code)) })
}

fn refused_write(abort: Abort, at: Multiplexer, writing: Writing, expected_values: &mut ExpectedValues) -> Judged {
    check_multiplexer(abort.multiplexer, at)?;
    refused_late(abort, at, writing, expected_values)
}

/// Checks an abort at the end of a transfer, which has to name the object, too.
fn refused_late(abort: Abort, at: Multiplexer, writing: Writing, expected_values: &mut ExpectedValues) -> Judged {
    expected_values.aborted = writing.entry;
    check_abort(abort, if writing.must.is_empty() { writing.may } else { writing.must }, Some(at))
}

fn confirm(writing: Writing, frame: &Frame, knowledge: &Knowledge, expected_values: &mut ExpectedValues) -> Judged {
    if !writing.must.is_empty() {
        let property = if writing.pdo_rule { Property::Pdo } else { Property::LegalSdo };
        return Err(wrong(property, format!("{}: it is confirmed", shown(frame))));
    }
    if let Some(entry) = writing.entry {
        expected_values.written(knowledge, entry, writing.raw);
    }
    Ok(())
}

fn check_length(len: usize, reading: Reading, knowledge: &Knowledge) -> Judged {
    let size = reading.entry.and_then(|entry| knowledge.entries().get(entry)).and_then(|known| known.size);
    match size {
        Some(size) if size != len => {
            let expected = format!("a value of {size} bytes, as the description says of {}", reading.at);
            Err(instead(Property::Consistent, expected, format!("{len} bytes")))
        }
        _ => Ok(()),
    }
}

fn check_size(size: Option<u32>, reading: Reading, knowledge: &Knowledge) -> Judged {
    size.map_or(Ok(()), |size| check_length(size as usize, reading, knowledge))
}

/// Checks that a normal upload is not longer than the threshold (CiA 301). A threshold of 0 forbids it.
fn check_threshold(payload: &Payload, threshold: u8, frame: &Frame) -> Judged {
    let size = match payload {
        Payload::Expedited(value) => Some(value.data().len() as u32),
        Payload::ExpeditedUnsized(_) => Some(1),
        Payload::Segmented(size) => Some(*size),
        Payload::SegmentedUnsized => None,
    };
    if threshold > 0 && size.is_none_or(|size| size <= u32::from(threshold)) {
        return Ok(());
    }
    Err(wrong(Property::LegalSdo, format!("{}: a normal upload", shown(frame))))
}

fn check_block_size(block_size: u8, frame: &Frame) -> Judged {
    if (1..=127).contains(&block_size) {
        return Ok(());
    }
    Err(instead(Property::LegalSdo, "a block size from 1 to 127", shown(frame)))
}

/// Checks a value by the device's profile.
fn check_profile(value: &[u8], entry: usize, knowledge: &Knowledge, expected_values: &ExpectedValues) -> Judged {
    let Some(at) = knowledge.entries().get(entry).map(|known| known.at).filter(|at| at.index.0 >= 0x6000) else {
        return Ok(());
    };
    let expected = |at: Multiplexer| expected_values.number(knowledge, at.index.0, at.sub.0);
    let broken = knowledge.profiles().iter().find_map(|profile| profile.judge(at, value, knowledge, &expected));
    match broken {
        Some(broken) => Err(instead(Property::OfProfile(broken.property), broken.expected, broken.actual)),
        None => Ok(()),
    }
}

fn check_value(
    value: &[u8],
    entry: Option<usize>,
    knowledge: &Knowledge,
    expected_values: &mut ExpectedValues,
) -> Judged {
    let Some(entry) = entry else { return Ok(()) };
    check_profile(value, entry, knowledge, expected_values)?;
    let Some(known) = knowledge.entries().get(entry).filter(|known| known.stable && known.size.is_some()) else {
        return Ok(());
    };
    if value.len() > 8 {
        return Ok(());
    }
    let raw = value.iter().rev().fold(0, |raw, &byte| raw << 8 | u64::from(byte));
    let expected = expected_values.certain(entry);
    let judged = match expected {
        Some(expected) if expected != raw => {
            let property = match expected_values.aborted {
                Some(aborted) if aborted == entry => Property::AbortedUnchanged,
                _ if known.constant => Property::Consistent,
                _ if expected_values.is_by_reset(entry) => Property::Restored,
                _ => Property::ReadBack,
            };
            Err(instead(property, format!("{} holds {expected:X}h", known.at), format!("{raw:X}h")))
        }
        _ => Ok(()),
    };
    expected_values.read(knowledge, entry, raw);
    judged
}
