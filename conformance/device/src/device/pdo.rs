//! The common part of RPDOs and TPDOs: communication parameters (1400h.., 1800h..), mapping (1600h.., 1A00h..), and
//! their checks.

use super::objects::Objects;
use super::parameters::Parameters;
use crate::models::Rule;
use crate::{Fault, Liberty};
use canvass_analyzer::object;
use canvass_analyzer::wire::pdo::MappingEntry;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{CobId, Multiplexer};

/// Maximum number of entries of a PDO: each has at least one bit.
const MOST_ENTRIES: u64 = 64;
/// Maximum number of PDOs of each direction.
const PDOS: u16 = 0x200;

/// The direction of a PDO, as seen from the device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Direction {
    Receive,
    Transmit,
}

impl Direction {
    /// The index of the communication parameters of the first PDO.
    pub const fn communication(self) -> u16 {
        match self {
            Self::Receive => object::RPDO_COMMUNICATION_PARAMETER,
            Self::Transmit => object::TPDO_COMMUNICATION_PARAMETER,
        }
    }

    /// The index of the mapping of the first PDO.
    pub const fn mapping(self) -> u16 {
        self.communication() + PDOS
    }

    /// The direction and the number, from 0, of the PDO that an object configures.
    pub const fn of(index: u16) -> Option<(Self, u16)> {
        match index {
            object::RPDO_COMMUNICATION_PARAMETER..object::TPDO_COMMUNICATION_PARAMETER => {
                Some((Self::Receive, (index - object::RPDO_COMMUNICATION_PARAMETER) % PDOS))
            }
            object::TPDO_COMMUNICATION_PARAMETER..object::AFTER_PDO_PARAMETERS => {
                Some((Self::Transmit, (index - object::TPDO_COMMUNICATION_PARAMETER) % PDOS))
            }
            _ => None,
        }
    }
}

/// The numbers, from 0, of the PDOs in the object dictionary.
pub(super) fn numbers(direction: Direction, parameters: &Parameters) -> impl Iterator<Item = u16> + use<'_> {
    let indexes = parameters.entries().filter(|entry| entry.at.sub.0 == 0).map(|entry| entry.at.index.0);
    indexes.filter_map(move |index| index.checked_sub(direction.communication())).filter(|&number| number < PDOS)
}

/// The mapping entries in use: as many as sub-index 0 says.
pub(super) fn mapping(
    direction: Direction,
    parameters: &Parameters,
    number: u16,
) -> impl Iterator<Item = MappingEntry> + use<'_> {
    let index = direction.mapping() + number;
    let count = parameters.number_or_zero(index, 0).min(MOST_ENTRIES) as u8;
    (1..=count).filter_map(move |sub| parameters.number(index, sub)).map(|raw| MappingEntry(raw as u32))
}

/// The mapping entry after the last used entry, if it is not 0.
pub(super) fn entry_beyond(direction: Direction, parameters: &Parameters, number: u16) -> Option<MappingEntry> {
    let index = direction.mapping() + number;
    let next = u8::try_from(parameters.number_or_zero(index, 0)).ok()?.checked_add(1)?;
    parameters.number(index, next).filter(|&raw| raw != 0).map(|raw| MappingEntry(raw as u32))
}

/// Checks a write to the communication parameters of a PDO (1400h.., 1800h..).
///
/// # Errors
/// The abort code for a value that is impossible, or impossible in the present state.
pub(super) fn check_communication(at: Multiplexer, value: u64, objects: &Objects) -> Result<(), AbortCode> {
    let Some((direction, number)) = Direction::of(at.index.0) else { return Ok(()) };
    let (parameters, firmware) = (&objects.parameters, &objects.firmware);
    if number > 0 && firmware.has(Fault::PdoRulesFirstOnly) {
        return Ok(());
    }
    let cob_id = CobId(parameters.number_or_zero(at.index.0, 1) as u32);
    let is_valid_and_changes = cob_id.is_valid() && value != parameters.number_or_zero(at.index.0, at.sub.0);
    if at.sub.0 != 1 && cob_id.is_valid() && firmware.takes(Liberty::PdoParametersLocked) {
        return Err(AbortCode::INVALID_VALUE);
    }
    if firmware.has(Fault::PdoTimesRefused)
        && matches!(at.sub.0, 3 | 6)
        && value != parameters.number_or_zero(at.index.0, at.sub.0)
    {
        return Err(AbortCode::INVALID_VALUE);
    }
    let fits = match (at.sub.0, direction) {
        (1, _) => return check_cob_id(at, cob_id, CobId(value as u32), direction, number, objects),
        (2, _) => is_transmission_type(direction, value, cob_id, objects),
        // If the PDO can't be switched off, its inhibit time may change while the PDO is valid.
        (3, Direction::Transmit) if is_fixed(at.index.0, parameters) => true,
        (3, Direction::Transmit) => !is_valid_and_changes || firmware.has(Fault::InhibitTimeChangeWhileValid),
        (6, Direction::Transmit) => {
            value <= 240 && (!is_valid_and_changes || firmware.has(Fault::SyncStartValueChangeWhileValid))
        }
        _ => true,
    };
    if fits { Ok(()) } else { Err(AbortCode::INVALID_VALUE) }
}

/// Whether the COB-ID of the PDO is read-only.
fn is_fixed(index: u16, parameters: &Parameters) -> bool {
    parameters.entry(Multiplexer::new(index, 1)).is_ok_and(|entry| !entry.writable)
}

fn is_transmission_type(direction: Direction, value: u64, cob_id: CobId, objects: &Objects) -> bool {
    let network = &objects.model.sheet().network;
    let types = match direction {
        Direction::Receive => &network.rpdo_transmission_types,
        Direction::Transmit => &network.transmission_types,
    };
    let known = types.iter().any(|&(low, high)| (low.into()..=high.into()).contains(&value));
    let by_rtr = matches!(value, 252 | 253);
    if direction == Direction::Receive && value <= 240 && objects.has(Fault::SynchronousRpdoRefused) {
        return false;
    }
    if by_rtr && objects.has(Fault::RtrTypeWithoutRtrAccepted) {
        return true;
    }
    let possible = cob_id.allows_rtr() || !by_rtr;
    (known && possible) || objects.has(Fault::ReservedTransmissionTypeAccepted)
}

/// Checks a new COB-ID of a PDO. The CAN-ID may change only while the PDO is not valid (CiA 301, 7.5.2.35 and
/// 7.5.2.37). A PDO without mapping can't become valid.
fn check_cob_id(
    at: Multiplexer,
    old: CobId,
    new: CobId,
    direction: Direction,
    number: u16,
    objects: &Objects,
) -> Result<(), AbortCode> {
    let firmware = &objects.firmware;
    let reserved = new.0 & 0x1FFF_F800 != 0 || new.is_extended();
    let moved = old.is_valid() && new.is_valid() && new.can_id() != old.can_id();
    let is_lax = firmware.has(Fault::CanIdLowBitsMovable) && new.can_id() >> 7 == old.can_id() >> 7;
    if moved && !reserved && !is_lax && !firmware.has(Fault::CobIdChangeWhileValid) {
        return Err(firmware.cob_id_code(objects.model.sheet().abort(Rule::CanIdWhileInvalid, at)));
    }
    if firmware.has(Fault::PdoOffRefused) && old.is_valid() && !new.is_valid() {
        return Err(AbortCode::INVALID_VALUE);
    }
    if firmware.takes(Liberty::CobIdRewriteRefused) && old.is_valid() && new.is_valid() {
        return Err(firmware.cob_id_code(AbortCode::INVALID_VALUE));
    }
    let restricted = new.is_restricted() && !firmware.has(Fault::RestrictedCanIdAccepted);
    let asks_for_rtr =
        direction == Direction::Transmit && new.allows_rtr() && !objects.model.sheet().network.rtr && new != old;
    // A PDO that is delivered without mapping may keep its delivered COB-ID.
    let is_empty = mapping(direction, &objects.parameters, number).next().is_none()
        && !is_delivered_empty(direction, number, objects);
    let impossible = new.is_valid()
        && (restricted
            || (asks_for_rtr && !firmware.has(Fault::RtrBitClearable))
            || (is_empty && !firmware.has(Fault::EmptyPdoValidated)));
    if firmware.has(Fault::CanIdsTakenForRestricted) && (0x550..0x580).contains(&new.can_id()) {
        return Err(AbortCode::INVALID_VALUE);
    }
    if reserved || impossible { Err(AbortCode::INVALID_VALUE) } else { Ok(()) }
}

/// Whether the PDO is delivered valid and without mapping.
fn is_delivered_empty(direction: Direction, number: u16, objects: &Objects) -> bool {
    let delivered = |index: u16, sub| {
        objects.parameters.entry(Multiplexer::new(index + number, sub)).map(|entry| entry.default_bits())
    };
    let is_valid = |raw: u64| CobId(raw as u32).is_valid();
    delivered(direction.mapping(), 0) == Ok(0) && delivered(direction.communication(), 1).is_ok_and(is_valid)
}

/// Checks a write to the mapping of a PDO (1600h.., 1A00h..). The mapping may change only while the PDO is not valid,
/// its entries only while sub-index 0 is 0.
///
/// # Errors
/// The abort code for a mapping that is impossible, or impossible in the present state.
pub(super) fn check_mapping(at: Multiplexer, value: u64, objects: &Objects) -> Result<(), AbortCode> {
    let Some((direction, number)) = Direction::of(at.index.0) else { return Ok(()) };
    let (parameters, firmware) = (&objects.parameters, &objects.firmware);
    if number > 0 && firmware.has(Fault::PdoRulesFirstOnly) {
        return Ok(());
    }
    let valid = CobId(parameters.number_or_zero(direction.communication() + number, 1) as u32).is_valid();
    let in_use = at.sub.0 != 0 && parameters.number_or_zero(at.index.0, 0) != 0;
    if (valid || in_use) && !firmware.has(Fault::MappingChangeWhileValid) {
        return Err(objects.model.sheet().abort(Rule::MappingWhileDisabled, at));
    }
    if at.sub.0 != 0 {
        let checked = check_entry(MappingEntry(value as u32), direction, objects);
        let checked = if value == 0 { Ok(()) } else { checked.map_err(|code| firmware.entry_code(code)) };
        return checked.and_then(|()| check_length_so_far(at, value, objects));
    }
    check_count(at, value, direction, objects).map_err(|code| firmware.count_code(code))
}

/// Checks a written entry in a firmware that checks the length at once: all entries up to this one must fit into a PDO.
fn check_length_so_far(at: Multiplexer, value: u64, objects: &Objects) -> Result<(), AbortCode> {
    if !objects.takes(Liberty::MappingLengthAtEntry) || objects.has(Fault::MappingTooLongAccepted) {
        return Ok(());
    }
    let before = (1..at.sub.0).map(|sub| objects.parameters.number_or_zero(at.index.0, sub));
    let bits: u32 = before.chain([value]).map(|raw| u32::from(MappingEntry(raw as u32).bits())).sum();
    if bits <= 64 { Ok(()) } else { Err(objects.firmware.count_code(AbortCode::PDO_LENGTH)) }
}

/// Checks a write to sub-index 0: the mapped objects must exist and be mappable, and together fit into a PDO.
fn check_count(at: Multiplexer, value: u64, direction: Direction, objects: &Objects) -> Result<(), AbortCode> {
    let (parameters, firmware) = (&objects.parameters, &objects.firmware);
    if firmware.has(Fault::MappingCountUnchecked) {
        return Ok(());
    }
    let most = u8::try_from(value).map_err(|_| AbortCode::PDO_LENGTH)?;
    parameters.number(at.index.0, most).ok_or(AbortCode::PDO_LENGTH)?;
    let mut bits = 0;
    for sub in 1..=most {
        let entry = MappingEntry(parameters.number_or_zero(at.index.0, sub) as u32);
        if entry.0 == 0
            && (firmware.has(Fault::EmptyEntryMapped) || sub > 1 && firmware.has(Fault::LaterEmptyEntryMapped))
        {
            continue;
        }
        check_entry(entry, direction, objects)?;
        bits += u32::from(entry.bits());
    }
    if bits <= 64 || firmware.has(Fault::MappingTooLongAccepted) { Ok(()) } else { Err(AbortCode::PDO_LENGTH) }
}

/// Checks whether an object can be mapped with the length of the mapping entry.
fn check_entry(entry: MappingEntry, direction: Direction, objects: &Objects) -> Result<(), AbortCode> {
    let firmware = &objects.firmware;
    if firmware.takes(Liberty::MappingInBytes) && !entry.bits().is_multiple_of(8) {
        return Err(AbortCode::NOT_MAPPABLE);
    }
    if entry.is_dummy() {
        return check_dummy(entry, direction, objects);
    }
    let object = match objects.parameters.entry(entry.object()) {
        Ok(object) => object,
        Err(_) if firmware.has(Fault::MissingObjectMapped) && entry.0 != 0 => return Ok(()),
        Err(_) => return Err(AbortCode::NO_OBJECT),
    };
    if is_delivered(entry, direction, objects) {
        return Ok(());
    }
    let mappable = match direction {
        Direction::Receive => object.rpdo_mappable,
        Direction::Transmit => object.tpdo_mappable,
    };
    let bits = object.data_type.bits().unwrap_or(0);
    let unchecked = firmware.has(Fault::MappingLengthUnchecked) && entry.bits() > 0;
    let fits = (bits == u32::from(entry.bits()) || unchecked) && bits > 0;
    if fits && (mappable || firmware.has(Fault::UnmappableObjectMapped)) {
        Ok(())
    } else {
        Err(AbortCode::NOT_MAPPABLE)
    }
}

/// Whether a mapping as delivered has this entry. A delivered entry, even for a part of an object, may be mapped again.
fn is_delivered(entry: MappingEntry, direction: Direction, objects: &Objects) -> bool {
    let indexes = direction.mapping()..direction.mapping() + PDOS;
    let mut mapped = objects.parameters.entries().filter(|it| indexes.contains(&it.at.index.0) && it.at.sub.0 > 0);
    mapped.any(|it| it.default_bits() == u64::from(entry.0))
}

/// Checks a dummy entry: it must be in an RPDO, of a type in `DummyUsage` of the description, and have the type's full
/// length.
fn check_dummy(entry: MappingEntry, direction: Direction, objects: &Objects) -> Result<(), AbortCode> {
    let description = objects.model.description();
    let data_type = canvass_analyzer::dictionary::DataType(entry.object().index.0);
    let allowed = description.dummy_usage.get(&data_type.0).copied().unwrap_or(false);
    let fits = data_type.bits() == Some(u32::from(entry.bits())) && entry.object().sub.0 == 0;
    let possible = direction == Direction::Receive && allowed || objects.has(Fault::DummyMappedIntoTpdo);
    if possible && fits { Ok(()) } else { Err(AbortCode::NOT_MAPPABLE) }
}
