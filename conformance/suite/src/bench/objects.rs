//! The objects of this device that can serve a case.

use super::Bench;
use super::dictionary;
use super::profile::{self, Profile};
use crate::comparison::Nature;
use crate::verdict::{Reason, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DataType;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{AbortCode, Payload, Response};
use canvass_bus::client::Outcome;
use canvass_bus::client::sdo::Mode;
use canvass_traces::Duration;

/// COB-ID of TPDO 1.
pub(crate) const TPDO_COB_ID: Multiplexer = Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 1);
/// Transmission type of TPDO 1.
pub const TRANSMISSION_TYPE: Multiplexer = Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 2);
/// Inhibit time of TPDO 1, in 100 µs.
pub(crate) const INHIBIT_TIME: Multiplexer = Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 3);
/// Number of objects that TPDO 1 carries.
pub(crate) const TPDO_MAPPED: Multiplexer = Multiplexer::new(object::TPDO_MAPPING_PARAMETER, 0);
/// The first object that TPDO 1 carries.
pub(crate) const TPDO_FIRST_ENTRY: Multiplexer = Multiplexer::new(object::TPDO_MAPPING_PARAMETER, 1);
/// Event timer of TPDO 1, in ms.
pub const EVENT_TIMER: Multiplexer = Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 5);

/// An object that can be written and read back without side effects.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Scratch {
    /// The object.
    pub multiplexer: Multiplexer,
    /// The current value of the object.
    pub value: Vec<u8>,
    /// A legal value other than `value`.
    pub other: Vec<u8>,
}

/// An object that may serve as scratch, with two values that are legal on every device that has the object.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// The object.
    pub multiplexer: Multiplexer,
    /// The data type that the object must have.
    pub data_type: DataType,
    /// The two legal values.
    pub values: [u32; 2],
}

/// A candidate with its type and values.
pub const fn candidate(index: u16, sub: u8, data_type: DataType, values: [u32; 2]) -> Candidate {
    Candidate { multiplexer: Multiplexer::new(index, sub), data_type, values }
}

/// Candidates, best first: objects that take effect only together with another object that no case enables, then
/// objects that only change a period.
const CANDIDATES: [Candidate; 7] = [
    candidate(object::PRODUCER_HEARTBEAT_TIME, 0, DataType::UNSIGNED16, [1_000, 2_000]),
    // Without life time factor (100Dh = 0) the guard time does nothing.
    candidate(object::GUARD_TIME, 0, DataType::UNSIGNED16, [1_000, 2_000]),
    candidate(object::INHIBIT_TIME_EMCY, 0, DataType::UNSIGNED16, [0, 100]),
    candidate(object::TPDO_COMMUNICATION_PARAMETER, 5, DataType::UNSIGNED16, [100, 200]),
    // Error behaviour on communication errors: no case provokes one.
    candidate(object::ERROR_BEHAVIOR, 1, DataType::UNSIGNED8, [0, 1]),
    // Only a SYNC producer uses the period, and only synchronous PDOs use the window.
    candidate(object::COMMUNICATION_CYCLE_PERIOD, 0, DataType::UNSIGNED32, [100_000, 200_000]),
    candidate(object::SYNCHRONOUS_WINDOW_LENGTH, 0, DataType::UNSIGNED32, [0, 100_000]),
];

/// The data types of texts.
const TEXTS: [DataType; 3] = [DataType::VISIBLE_STRING, DataType::OCTET_STRING, DataType::UNICODE_STRING];

/// Candidates if the device has none of the others. They have no effect, because no PDO is sent before the device is
/// operational.
const LAST_CANDIDATES: [Candidate; 2] = [
    candidate(object::TPDO_COMMUNICATION_PARAMETER, 2, DataType::UNSIGNED8, [1, 2]),
    candidate(object::TPDO_COMMUNICATION_PARAMETER, 3, DataType::UNSIGNED16, [0, 100]),
];

impl Bench<'_> {
    /// The scratch objects that the device has, best first, with their current values.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub fn scratch_objects(&mut self) -> Result<Vec<Scratch>, Stop> {
        let mut found = Vec::new();
        for candidate in CANDIDATES.iter().chain(profile::all().flat_map(Profile::scratch)) {
            found.extend(self.scratch_of(candidate)?);
        }
        if found.is_empty() {
            found.extend(self.received_objects()?);
            for candidate in &LAST_CANDIDATES {
                if found.is_empty() {
                    found.extend(self.scratch_of(candidate)?);
                }
            }
        }
        // An object that the device refuses to write despite its description must not decide a case about something
        // else. If the device refuses all objects, the cases judge the refusals.
        let mut willing = Vec::new();
        for scratch in &found {
            if self.takes_its_own(scratch)? {
                willing.push(scratch.clone());
            }
        }
        Ok(if willing.is_empty() { found } else { willing })
    }

    /// Whether the device accepts a write of an object's current value. The bench finds this out once per object.
    fn takes_its_own(&mut self, scratch: &Scratch) -> Result<bool, Stop> {
        if let Some(known) = self.knowledge.willing.get(&scratch.multiplexer) {
            return Ok(*known);
        }
        let attempt = self.unjudged(|bench| bench.download_as(scratch.multiplexer, &scratch.value, Mode::Shortest))?;
        let takes = attempt.abort().is_none();
        self.knowledge.willing.insert(scratch.multiplexer, takes);
        Ok(takes)
    }

    /// Objects that RPDOs carry, one of each length: such objects are made to be written.
    fn received_objects(&mut self) -> Result<Vec<Scratch>, Stop> {
        let mut found: Vec<Scratch> = Vec::new();
        for mapped in self.rpdo_objects() {
            let bytes = usize::from(mapped.bits / 8);
            let is_known = found.iter().any(|scratch| scratch.value.len() == bytes);
            if bytes <= 4 && !is_known && self.is_described_as_writable(mapped.at) {
                found.extend(self.flipped(mapped.at)?);
            }
        }
        Ok(found)
    }

    /// An object with its current value, and a value that differs in the lowest bit.
    fn flipped(&mut self, at: Multiplexer) -> Result<Option<Scratch>, Stop> {
        let Outcome::Uploaded(value) = self.upload(at)?.outcome else { return Ok(None) };
        let other = value.iter().enumerate().map(|(n, byte)| byte ^ u8::from(n == 0)).collect();
        Ok(Some(Scratch { multiplexer: at, value, other }))
    }

    fn scratch_of(&mut self, candidate: &Candidate) -> Result<Option<Scratch>, Stop> {
        if !self.may_write(candidate.multiplexer) || !self.can_write(candidate.multiplexer)? {
            return Ok(None);
        }
        let Outcome::Uploaded(value) = self.upload(candidate.multiplexer)?.outcome else { return Ok(None) };
        if candidate.data_type.bytes() != Some(value.len()) || self.is_locked(candidate.multiplexer, &value)? {
            return Ok(None);
        }
        let bytes = |number: u32| number.to_le_bytes().into_iter().take(value.len()).collect::<Vec<u8>>();
        let [first, second] = candidate.values;
        let other = if bytes(first) == value { bytes(second) } else { bytes(first) };
        Ok(Some(Scratch { multiplexer: candidate.multiplexer, value, other }))
    }

    /// Whether a device refuses to write a parameter of a valid PDO, even with its current value.
    fn is_locked(&mut self, at: Multiplexer, value: &[u8]) -> Result<bool, Stop> {
        let is_of_pdo = matches!(at.index.0, 0x1400..=0x1BFF);
        Ok(is_of_pdo && self.download_as(at, value, Mode::Shortest)?.outcome != Outcome::Downloaded)
    }

    /// The best scratch object with one of these lengths.
    ///
    /// # Errors
    /// [`Stop::NotApplicable`] if the device has none.
    pub fn scratch(&mut self, lengths: &[usize]) -> Result<Scratch, Stop> {
        let found = self.scratch_objects()?.into_iter().find(|scratch| lengths.contains(&scratch.value.len()));
        if let Some(scratch) = &found {
            self.uses(scratch.multiplexer, "written and read back");
        }
        found.ok_or_else(|| {
            let lengths: Vec<String> = lengths.iter().map(ToString::to_string).collect();
            let duty = format!("an object of {} bytes can be written without consequence", lengths.join(" or "));
            Stop::NotApplicable(Reason::new(duty, "one of the objects that the tester knows", "none"))
        })
    }

    /// Whether the description allows writing an object. Without a description every object may be writable.
    pub(super) fn is_described_as_writable(&self, multiplexer: Multiplexer) -> bool {
        self.target.description.as_ref().is_none_or(|description| {
            description.dictionary.entry(multiplexer).is_ok_and(|entry| entry.access.is_writable())
        })
    }

    /// A readable object of at least `at_least` bytes: a name or version, otherwise an object that is long according to
    /// the description.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub(crate) fn long_object(&mut self, at_least: usize) -> Result<Option<Multiplexer>, Stop> {
        for multiplexer in self.long_candidates() {
            if self.is_long(multiplexer, at_least)? {
                self.uses(multiplexer, "read in segments or blocks");
                return Ok(Some(multiplexer));
            }
        }
        Ok(None)
    }

    /// Names, versions and strings of at least `at_least` bytes that don't change by themselves; at most `most` of
    /// them.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub(crate) fn long_objects(&mut self, at_least: usize, most: usize) -> Result<Vec<Multiplexer>, Stop> {
        let mut found = Vec::new();
        for multiplexer in self.long_candidates() {
            let is_new = self.is_text(multiplexer) && !found.contains(&multiplexer);
            if found.len() < most && is_new && self.is_long(multiplexer, at_least)? {
                found.push(multiplexer);
            }
        }
        Ok(found)
    }

    /// Whether the description shows that an object is a number that the device sets, such as a measured value, a counter
    /// or a time. Texts that the device sets stay the same.
    pub(crate) fn changes_by_itself(&self, at: Multiplexer) -> bool {
        let is_described = dictionary::described(self, at).is_some();
        is_described && dictionary::nature(self, at) == Nature::Own && !self.is_text(at)
    }

    /// Whether the value of an object changes in these 100 ms without a write.
    pub(crate) fn moves(&mut self, at: Multiplexer) -> Result<bool, Stop> {
        if !self.changes_by_itself(at) {
            return Ok(false);
        }
        let before = self.read(at)?;
        self.listen(Duration::from_millis(100))?;
        Ok(self.read(at)? != before)
    }

    fn is_text(&self, multiplexer: Multiplexer) -> bool {
        let description = self.target.description.as_ref();
        let described = description.and_then(|description| description.dictionary.entry(multiplexer).ok());
        described.map_or(NAMES.contains(&multiplexer), |entry| TEXTS.contains(&entry.data_type))
    }

    fn is_long(&mut self, multiplexer: Multiplexer, at_least: usize) -> Result<bool, Stop> {
        let attempt = self.upload(multiplexer)?;
        // The size that the server announces decides; the cases judge the bytes that it then sends.
        let announced = attempt.responses.first().and_then(|frame| Response::read(frame.data()).ok());
        Ok(match announced {
            Some(Response::InitiateUpload { payload: Payload::Segmented(size), .. }) => size as usize >= at_least,
            Some(Response::InitiateUpload { payload: Payload::SegmentedUnsized, .. }) => {
                matches!(&attempt.outcome, Outcome::Uploaded(value) if value.len() >= at_least)
            }
            _ => false,
        })
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

    /// An object of the application (2000h and above) that can be written and read back without side effects: an object
    /// that the tester knows, or an object in the manufacturer's area that stores a value for the user.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub fn application_scratch(&mut self) -> Result<Option<Scratch>, Stop> {
        /// Known scratch objects in the manufacturer's area.
        const KNOWN: [Candidate; 1] = [candidate(0x2140, 1, DataType::UNSIGNED32, [1, 2])];
        for candidate in profile::all().flat_map(Profile::application_scratch).chain(&KNOWN) {
            if let Some(scratch) = self.scratch_of(candidate)? {
                self.uses(scratch.multiplexer, "written and read back");
                return Ok(Some(scratch));
            }
        }
        // Objects that RPDOs carry are made to be written.
        let (profile, own): (Vec<_>, Vec<_>) =
            self.rpdo_objects().into_iter().partition(|mapped| mapped.at.index.0 >= 0x6000);
        for mapped in profile.into_iter().chain(own) {
            if self.is_described_as_writable(mapped.at) && self.may_write(mapped.at) && mapped.bits <= 32 {
                self.uses(mapped.at, "written and read back");
                return self.flipped(mapped.at);
            }
        }
        Ok(None)
    }

    /// A string that is writable and readable according to the description, and long enough for a segmented transfer.
    ///
    /// # Errors
    /// [`Stop::NotApplicable`] if there is none.
    pub(crate) fn long_scratch(&mut self) -> Result<Multiplexer, Stop> {
        let found = self.long_writable();
        if let Some(multiplexer) = found {
            self.uses(multiplexer, "written and read back");
        }
        found.ok_or_else(|| {
            let duty = "a string can be written without consequence";
            Stop::NotApplicable(Reason::new(duty, "one that the description names", "none"))
        })
    }

    pub(crate) fn long_writable(&self) -> Option<Multiplexer> {
        let description = self.target.description.as_ref()?;
        // No DOMAIN object: it may be a program, or a block of fixed length.
        let strings = [DataType::VISIBLE_STRING, DataType::OCTET_STRING];
        let mut entries = description.dictionary.entries().filter(|(multiplexer, entry)| {
            // Objects such as 1F50h load programs.
            let is_own = matches!(multiplexer.index.0, 0x2000..=0x9FFF);
            let is_free = !entry.flags.refuses_write_on_download() && !entry.flags.refuses_read_on_scan();
            let is_restorable = entry.access.is_writable() && entry.access.is_readable();
            is_own && is_free && is_restorable && strings.contains(&entry.data_type)
        });
        entries.next().map(|(multiplexer, _)| multiplexer)
    }

    /// An object with an empty text according to the description, if the device confirms this or does not answer.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub(crate) fn empty_object(&mut self) -> Result<Option<Multiplexer>, Stop> {
        let Some(description) = &self.target.description else { return Ok(None) };
        let node = self.node();
        let mut entries = description.dictionary.entries().filter(|(_, entry)| {
            let is_text = TEXTS.contains(&entry.data_type) && entry.access.is_readable();
            let value = entry.start_value(node).and_then(|value| value.encode(entry.data_type).ok());
            is_text && !entry.flags.refuses_read_on_scan() && value.is_none_or(|value| value.is_empty())
        });
        let candidates: Vec<Multiplexer> = entries.by_ref().map(|(multiplexer, _)| multiplexer).take(8).collect();
        for multiplexer in candidates {
            match self.upload(multiplexer)?.outcome {
                Outcome::Uploaded(value) if !value.is_empty() => {}
                Outcome::Aborted(abort) if abort.code != AbortCode::NO_DATA => {}
                // Also if the device is silent: the case judges how the device answers for this object.
                _ => return Ok(Some(multiplexer)),
            }
        }
        Ok(None)
    }

    /// The device's name and versions, if it has them. The texts come from the device: they may hold anything.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub fn names(&mut self) -> Result<Vec<(Multiplexer, Vec<u8>)>, Stop> {
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
pub const NAMES: [Multiplexer; 3] = [
    Multiplexer::new(object::MANUFACTURER_DEVICE_NAME, 0),
    Multiplexer::new(object::MANUFACTURER_HARDWARE_VERSION, 0),
    Multiplexer::new(object::MANUFACTURER_SOFTWARE_VERSION, 0),
];
