//! Which objects of this device serve a case.

use super::Bench;
use crate::client::Outcome;
use crate::verdict::{Reason, Verdict};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DataType;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{Payload, Response};

/// COB-ID of TPDO 1.
pub const TPDO_COB_ID: Multiplexer = Multiplexer::new(0x1800, 1);
/// Transmission type of TPDO 1.
pub const TRANSMISSION_TYPE: Multiplexer = Multiplexer::new(0x1800, 2);
/// Inhibit time of TPDO 1, in 100 µs.
pub const INHIBIT_TIME: Multiplexer = Multiplexer::new(0x1800, 3);
/// How many objects TPDO 1 carries.
pub const TPDO_MAPPED: Multiplexer = Multiplexer::new(0x1A00, 0);
/// The first object that TPDO 1 carries.
pub const TPDO_FIRST_ENTRY: Multiplexer = Multiplexer::new(0x1A00, 1);
/// Event timer of TPDO 1, in ms.
pub const EVENT_TIMER: Multiplexer = Multiplexer::new(0x1800, 5);

/// An object that can be written and read back without consequence.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Scratch {
    /// The object.
    pub multiplexer: Multiplexer,
    /// Its value now.
    pub value: Vec<u8>,
    /// A legal value that differs from it.
    pub other: Vec<u8>,
}

/// An object that may serve as scratch, with two values that are legal wherever it exists.
struct Candidate {
    multiplexer: Multiplexer,
    data_type: DataType,
    values: [u32; 2],
}

const fn candidate(index: u16, sub: u8, data_type: DataType, values: [u32; 2]) -> Candidate {
    Candidate { multiplexer: Multiplexer::new(index, sub), data_type, values }
}

/// The best first: what takes effect only with something else that no case switches on, then what merely changes a
/// period.
const CANDIDATES: [Candidate; 9] = [
    candidate(0x1017, 0, DataType::UNSIGNED16, [1_000, 2_000]),
    // Without life time factor (100Dh = 0) the guard time does nothing.
    candidate(0x100C, 0, DataType::UNSIGNED16, [1_000, 2_000]),
    candidate(0x1015, 0, DataType::UNSIGNED16, [0, 100]),
    candidate(0x1800, 5, DataType::UNSIGNED16, [100, 200]),
    // Error behaviour on communication errors: none is provoked.
    candidate(0x1029, 1, DataType::UNSIGNED8, [0, 1]),
    // Only a SYNC producer uses the period, only synchronous PDOs the window.
    candidate(0x1006, 0, DataType::UNSIGNED32, [100_000, 200_000]),
    candidate(0x1007, 0, DataType::UNSIGNED32, [0, 100_000]),
    candidate(0x6401, 0, DataType::INTEGER32, [16, 32]),
    candidate(0x6200, 0, DataType::UNSIGNED16, [100, 200]),
];

impl Bench<'_> {
    /// The scratch objects that the device has, best first, with their values of now.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub fn scratch_objects(&mut self) -> Result<Vec<Scratch>, Verdict> {
        let mut found = Vec::new();
        for candidate in &CANDIDATES {
            if !self.is_described_as_writable(candidate.multiplexer) {
                continue;
            }
            let Outcome::Uploaded(value) = self.upload(candidate.multiplexer)?.outcome else { continue };
            if candidate.data_type.bytes() != Some(value.len()) {
                continue;
            }
            let bytes = |number: u32| number.to_le_bytes().into_iter().take(value.len()).collect::<Vec<u8>>();
            let [first, second] = candidate.values;
            let other = if bytes(first) == value { bytes(second) } else { bytes(first) };
            found.push(Scratch { multiplexer: candidate.multiplexer, value, other });
        }
        Ok(found)
    }

    /// The best scratch object of that many bytes.
    ///
    /// # Errors
    /// [`Verdict::NotApplicable`] if the device has none.
    pub fn scratch(&mut self, lengths: &[usize]) -> Result<Scratch, Verdict> {
        let found = self.scratch_objects()?.into_iter().find(|scratch| lengths.contains(&scratch.value.len()));
        found.ok_or_else(|| {
            let lengths: Vec<String> = lengths.iter().map(ToString::to_string).collect();
            let duty = format!("an object of {} bytes can be written without consequence", lengths.join(" or "));
            Verdict::NotApplicable(Reason::new(duty, "one of the objects that the tester knows", "none"))
        })
    }

    /// Without a description every object may be writable.
    pub(super) fn is_described_as_writable(&self, multiplexer: Multiplexer) -> bool {
        self.target.description.as_ref().is_none_or(|description| {
            description.dictionary.entry(multiplexer).is_ok_and(|entry| entry.access.is_writable())
        })
    }

    /// A readable object of at least that many bytes: a name or version, else one that the description calls long.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub fn long_object(&mut self, at_least: usize) -> Result<Option<Multiplexer>, Verdict> {
        for multiplexer in self.long_candidates() {
            let attempt = self.upload(multiplexer)?;
            // What the server announces decides, not what it then delivers: that is what cases judge.
            let announced = attempt.responses.first().and_then(|frame| Response::read(frame.data()).ok());
            let is_long = match announced {
                Some(Response::InitiateUpload { payload: Payload::Segmented(size), .. }) => size as usize >= at_least,
                Some(Response::InitiateUpload { payload: Payload::SegmentedUnsized, .. }) => {
                    matches!(&attempt.outcome, Outcome::Uploaded(value) if value.len() >= at_least)
                }
                _ => false,
            };
            if is_long {
                return Ok(Some(multiplexer));
            }
        }
        Ok(None)
    }

    fn long_candidates(&self) -> Vec<Multiplexer> {
        const ENOUGH: usize = 16;
        let mut candidates: Vec<Multiplexer> = NAMES.to_vec();
        if let Some(description) = &self.target.description {
            let is_long = |data_type: DataType| data_type.bytes().is_none_or(|bytes| bytes > 4);
            let described = description.dictionary.entries().filter(|(_, entry)| {
                entry.access.is_readable() && !entry.flags.refuses_read_on_scan() && is_long(entry.data_type)
            });
            candidates.extend(described.map(|(multiplexer, _)| multiplexer).take(ENOUGH));
        }
        candidates
    }

    /// The device's name and versions, as far as it has them. They come from the device: they may hold anything.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub fn names(&mut self) -> Result<Vec<(Multiplexer, Vec<u8>)>, Verdict> {
        let mut found = Vec::new();
        for multiplexer in NAMES {
            if let Outcome::Uploaded(value) = self.upload(multiplexer)?.outcome {
                found.push((multiplexer, value));
            }
        }
        Ok(found)
    }
}

/// Manufacturer device name, hardware version, software version.
pub const NAMES: [Multiplexer; 3] =
    [Multiplexer::new(0x1008, 0), Multiplexer::new(0x1009, 0), Multiplexer::new(0x100A, 0)];
