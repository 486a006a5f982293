//! Requests that begin a transfer. They end the transfer before.

use super::super::codes::{self, CodeSet};
use super::super::expected_values::ExpectedValues;
use super::super::pdo_rules;
use super::awaited::{Awaited, Reading, Writing};
use super::{Server, TransferState};
use crate::{Knowledge, Known};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::Payload;
use canvass_traces::Frame;

impl Server {
    pub(super) fn begin_upload(&mut self, at: Multiplexer, knowledge: &Knowledge) -> Awaited {
        self.state = TransferState::Idle;
        Awaited::Read(reading(at, knowledge))
    }

    pub(super) fn begin_block_upload(
        &mut self,
        at: Multiplexer,
        block_size: u8,
        threshold: u8,
        crc: bool,
        knowledge: &Knowledge,
    ) -> Awaited {
        self.state = TransferState::Idle;
        let mut reading = reading(at, knowledge);
        match knowledge.services.block_transfer {
            Some(false) => return refused(at, codes::COMMAND, "block transfers are not supported"),
            Some(true) => {}
            None => {
                reading.may = reading.may.or(codes::COMMAND);
                reading.must = with_command(reading.must);
            }
        }
        if !(1..=127).contains(&block_size) && threshold > 0 {
            // A server that uses the normal upload for a short value ignores the block size.
            self.state = TransferState::Unsure;
            return Awaited::Anything;
        }
        if !(1..=127).contains(&block_size) {
            // The server decides which of two errors it reports.
            let codes = codes::BLOCK_SIZE.or(reading.must).or(reading.may).or(not_supported(knowledge));
            return refused(at, codes, "a block size outside 1 to 127");
        }
        Awaited::BlockRead { reading, block_size, threshold, crc }
    }

    pub(super) fn begin_download(
        &mut self,
        at: Multiplexer,
        payload: Payload,
        frame: &Frame,
        knowledge: &Knowledge,
        expected_values: &ExpectedValues,
    ) -> Awaited {
        self.state = TransferState::Idle;
        self.data.clear();
        match payload {
            Payload::Expedited(value) => {
                Awaited::Write { at, writing: writing(at, value.data(), knowledge, expected_values) }
            }
            Payload::ExpeditedUnsized(value) => {
                let size = knowledge.entry(at).and_then(|known| known.size).unwrap_or(4).min(4);
                let mut writing = writing(at, &value[..size], knowledge, expected_values);
                writing.may = writing.may.or(codes::TOO_LONG).or(codes::TOO_SHORT);
                Awaited::Write { at, writing }
            }
            Payload::Segmented(size) => {
                let writing = in_segments(announced(at, Some(size), knowledge), knowledge);
                Awaited::BeginDownload { at, writing, announced: Some(size) }
            }
            Payload::SegmentedUnsized => {
                // A server may refuse a request whose four reserved bytes are not 0.
                let mut writing = in_segments(announced(at, None, knowledge), knowledge);
                if frame.bytes()[4..] != [0; 4] {
                    writing.may = writing.may.or(codes::COMMAND);
                }
                Awaited::BeginDownload { at, writing, announced: None }
            }
        }
    }

    pub(super) fn begin_block_download(
        &mut self,
        at: Multiplexer,
        size: Option<u32>,
        crc: bool,
        knowledge: &Knowledge,
    ) -> Awaited {
        self.state = TransferState::Idle;
        self.data.clear();
        if knowledge.services.block_transfer == Some(false) {
            return refused(at, codes::COMMAND, "block transfers are not supported");
        }
        let mut writing = announced(at, size, knowledge);
        writing.may = writing.may.or(not_supported(knowledge));
        if knowledge.services.block_transfer.is_none() {
            writing.must = with_command(writing.must);
        }
        Awaited::BeginBlockDownload { at, writing, announced: size, crc }
    }
}

fn refused(at: Multiplexer, codes: CodeSet, why: &'static str) -> Awaited {
    Awaited::Abort { codes, at: Some(at), why }
}

/// A server need not support segments if all its objects have four bytes or fewer.
fn in_segments(mut writing: Writing, knowledge: &Knowledge) -> Writing {
    if knowledge.entries().iter().all(|known| known.size.is_some_and(|size| size <= 4)) {
        writing.may = writing.may.or(codes::COMMAND);
        writing.must = with_command(writing.must);
    }
    writing
}

/// The abort code of a server without block transfers, if it is not known whether this server supports them.
fn not_supported(knowledge: &Knowledge) -> CodeSet {
    if knowledge.services.block_transfer.is_none() { codes::COMMAND } else { CodeSet::NONE }
}

/// A server without block transfers may report this lack before it looks for the object.
fn with_command(must: CodeSet) -> CodeSet {
    if must.is_empty() { must } else { must.or(codes::COMMAND) }
}

/// The allowed answers to a request to read the object.
fn reading(at: Multiplexer, knowledge: &Knowledge) -> Reading {
    let entry = knowledge.position(at);
    let known = entry.and_then(|entry| knowledge.entries().get(entry));
    let (must, may) = match known {
        Some(known) if !known.readable => (codes::WRITE_ONLY, CodeSet::NONE),
        // The error history has no value after its last error.
        Some(known) if known.at.index.0 == object::PREDEFINED_ERROR_FIELD => {
            (CodeSet::NONE, codes::NO_DATA.or(codes::NO_SUB_INDEX))
        }
        // A value of variable length, such as a DOMAIN, can be missing.
        Some(known) if known.size.is_none() => (CodeSet::NONE, codes::NO_DATA),
        Some(_) => (CodeSet::NONE, CodeSet::NONE),
        // Sub-index FFh is the structure of an object, which no description names.
        None if at.sub.0 == 0xFF && knowledge.has_index(at) => (CodeSet::NONE, codes::NO_SUB_INDEX),
        None => (missing(at, knowledge), anything_if_unknown(knowledge)),
    };
    Reading { at, entry, must, may }
}

fn missing(at: Multiplexer, knowledge: &Knowledge) -> CodeSet {
    match (knowledge.is_described(), knowledge.has_index(at)) {
        (false, _) => CodeSet::NONE,
        (true, true) => codes::NO_SUB_INDEX,
        (true, false) => codes::NO_OBJECT,
    }
}

/// The abort codes for reading an object of a device without description: the object may be missing or not readable.
fn anything_if_unknown(knowledge: &Knowledge) -> CodeSet {
    if knowledge.is_described() {
        return CodeSet::NONE;
    }
    codes::NO_OBJECT.or(codes::NO_SUB_INDEX).or(codes::READ_ONLY).or(codes::WRITE_ONLY).or(codes::NO_DATA)
}

/// The allowed answers to a transfer that announces `size` bytes.
fn announced(at: Multiplexer, size: Option<u32>, knowledge: &Knowledge) -> Writing {
    let entry = knowledge.position(at);
    let mut writing = Writing { entry, raw: None, must: CodeSet::NONE, may: CodeSet::NONE, why: "", pdo_rule: false };
    let Some(known) = entry.and_then(|entry| knowledge.entries().get(entry)) else {
        writing.must = missing(at, knowledge);
        writing.why = "the object does not exist";
        writing.may = anything_if_unknown(knowledge).or(codes::REFUSED).or(codes::TOO_LONG).or(codes::TOO_SHORT);
        return writing;
    };
    writing.may = codes::REFUSED.or(codes::TOO_LONG);
    if !known.writable {
        writing.must = codes::READ_ONLY;
        writing.why = "the object is read-only";
    }
    match (known.size, size) {
        // The server may refuse a wrong length at once or when the data has come.
        (Some(fixed), Some(size)) if size as usize > fixed => writing.may = writing.may.or(codes::TOO_LONG),
        (Some(fixed), Some(size)) if (size as usize) < fixed => writing.may = writing.may.or(codes::TOO_SHORT),
        // The application decides which lengths of a string or DOMAIN are right; no description contains them.
        (None, _) => writing.may = writing.may.or(codes::TOO_SHORT),
        _ => {}
    }
    if !writing.must.is_empty() {
        writing.must = writing.must.or(length_codes(known, size.map(|size| size as usize)));
    }
    writing
}

/// The codes for a wrong length. The server decides which of several errors it reports.
fn length_codes(known: &Known, size: Option<usize>) -> CodeSet {
    match (known.size, size) {
        (Some(fixed), Some(size)) if size > fixed => codes::TOO_LONG,
        (Some(fixed), Some(size)) if size < fixed => codes::TOO_SHORT,
        _ => CodeSet::NONE,
    }
}

/// The codes at the end of a transfer whose length is neither the object's length nor the announced length. The right
/// lengths of a string or DOMAIN are in no description.
pub(super) fn all_length_codes(known: Option<&Known>, announced: Option<usize>) -> CodeSet {
    match known {
        Some(known) if known.size.is_none() => codes::TOO_LONG.or(codes::TOO_SHORT),
        Some(known) => length_codes(known, announced),
        None => CodeSet::NONE,
    }
}

/// The allowed answers to writing the value.
pub(super) fn writing(
    at: Multiplexer,
    value: &[u8],
    knowledge: &Knowledge,
    expected_values: &ExpectedValues,
) -> Writing {
    let entry = knowledge.position(at);
    let raw = (value.len() <= 8).then(|| value.iter().rev().fold(0, |raw, &byte| raw << 8 | u64::from(byte)));
    let mut writing = Writing { entry, raw, must: CodeSet::NONE, may: codes::REFUSED, why: "", pdo_rule: false };
    let Some(known) = entry.and_then(|entry| knowledge.entries().get(entry)) else {
        writing.must = missing(at, knowledge);
        writing.why = "the object does not exist";
        writing.may = anything_if_unknown(knowledge).or(codes::REFUSED).or(codes::TOO_LONG).or(codes::TOO_SHORT);
        return writing;
    };
    let length = length_codes(known, Some(value.len()));
    if !known.writable {
        (writing.must, writing.why) = (codes::READ_ONLY.or(length), "the object is read-only");
        return writing;
    }
    if !length.is_empty() {
        (writing.must, writing.why) = (length.or(codes::REFUSED), "the value has not the length of the object's type");
        return writing;
    }
    writing.may = writing.may.or(pdo_rules::mapping_codes(at));
    if known.size.is_none() {
        writing.may = writing.may.or(codes::TOO_LONG).or(codes::TOO_SHORT);
    }
    let Some(raw) = raw.filter(|_| known.size.is_some()) else { return writing };
    if knowledge.services.acts_when_stored.contains(&at) {
        return writing;
    }
    if !known.in_limits(raw) {
        let limit = codes::TOO_HIGH.or(codes::TOO_LOW).or(codes::REFUSED);
        (writing.must, writing.why) = (limit, "the value lies outside the limits of the description");
    } else if let Some((codes, why)) = pdo_rules::refusal(at, raw, knowledge, expected_values) {
        (writing.must, writing.why, writing.pdo_rule) = (codes, why, true);
    }
    writing
}
