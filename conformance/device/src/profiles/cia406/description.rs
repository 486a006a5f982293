//! The properties of an encoder as derived from its description, for devices without sheet.

use super::sheet::{EncoderKind, Measurement};
use crate::models::{Rule, is_writable, written};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_analyzer::object;
use canvass_analyzer::profiles::cia406::objects as encoder;
use toml::{Table, Value};

/// The object with the period of the first TPDO.
const CYCLIC_TIMER: Multiplexer = Multiplexer::new(encoder::CYCLIC_TIMER, 0);

/// Derives the measurement, and adds related rows to `sheet`; `None` if the device has no position.
pub(super) fn describe(description: &DeviceDescription, sheet: &mut Table) -> Option<Measurement> {
    description.dictionary.entry(Multiplexer::new(encoder::POSITION_VALUE, 0)).ok()?;
    let links = links(description);
    sheet.insert("quirks".to_owned(), quirks(description, !links.is_empty()).into());
    sheet.insert("link".to_owned(), Value::Array(links));
    sheet.insert("check".to_owned(), Value::Array(checks(description)));
    Some(measurement(description))
}

/// The physical resolution. 6501h and 6502h give it for a rotary encoder; 6002h gives it for a linear encoder (1000h),
/// whose 6501h is the length of a step.
fn measurement(description: &DeviceDescription) -> Measurement {
    let number = |index| {
        let entry = description.dictionary.entry(Multiplexer::new(index, 0)).ok()?;
        entry.default.as_ref()?.fixed()?.to_raw()
    };
    let count = |index| number(index).unwrap_or(1).clamp(1, u64::from(u32::MAX)) as u32;
    if number(object::DEVICE_TYPE).is_some_and(|device_type| matches!(device_type >> 16, 8 | 9)) {
        let revolutions = count(encoder::TOTAL_MEASURING_RANGE);
        let step_nm = count(encoder::SINGLE_TURN_RESOLUTION);
        let kind = EncoderKind::Linear;
        return Measurement { kind, single_turn_bits: 0, revolutions, step_nm, ..Measurement::default() };
    }
    let bits = number(encoder::SINGLE_TURN_RESOLUTION).map_or(13, |steps| steps.max(1).ilog2().min(32) as u8);
    let revolutions = count(encoder::NUMBER_OF_REVOLUTIONS);
    Measurement { single_turn_bits: bits, revolutions, ..Measurement::default() }
}

/// Whether the description names 2104h and 2105h limit switches. These objects are the manufacturer's.
pub fn shows_limit_switches(description: &DeviceDescription) -> bool {
    [0x2104, 0x2105].into_iter().all(|index| {
        let entry = description.dictionary.entry(Multiplexer::new(index, 0));
        entry.is_ok_and(|entry| entry.name.to_ascii_lowercase().contains("limit switch"))
    })
}

/// Links the cyclic timer to the event timer of TPDO 1, if both can be written.
fn links(description: &DeviceDescription) -> Vec<Value> {
    let timers = [CYCLIC_TIMER, Multiplexer::new(object::TPDO_COMMUNICATION_PARAMETER, 5)];
    if !timers.iter().all(|at| is_writable(description, *at)) {
        return Vec::new();
    }
    let objects: Vec<Value> = timers.iter().map(|at| written(*at).into()).collect();
    let mut link = Table::new();
    link.insert("kind".to_owned(), "same".into());
    link.insert("objects".to_owned(), Value::Array(objects));
    vec![link.into()]
}

/// Quirks that the description shows.
fn quirks(description: &DeviceDescription, has_event_timer: bool) -> Table {
    let mut quirks = Table::new();
    let is_cyclic = !has_event_timer && is_writable(description, CYCLIC_TIMER);
    quirks.insert("cyclic_tpdo".to_owned(), is_cyclic.into());
    quirks.insert("limit_switches".to_owned(), shows_limit_switches(description).into());
    quirks
}

/// Checks that the low limit of a work area is at most the high limit, for each channel that has both.
fn checks(description: &DeviceDescription) -> Vec<Value> {
    let (low, high) = (encoder::WORK_AREA_LOW_LIMIT, encoder::WORK_AREA_HIGH_LIMIT);
    let row = |(at, rule, of): (Multiplexer, &str, Multiplexer)| {
        let mut row = Table::new();
        row.insert("at".to_owned(), written(at).into());
        row.insert("rule".to_owned(), rule.into());
        row.insert("of".to_owned(), written(of).into());
        row.insert("abort".to_owned(), i64::from(Rule::AtMost.standard_abort().0).into());
        Value::Table(row)
    };
    let channels = (1..=254).map(|sub| (Multiplexer::new(low, sub), Multiplexer::new(high, sub)));
    let both = channels.filter(|(low, high)| [low, high].iter().all(|at| description.dictionary.entry(**at).is_ok()));
    both.flat_map(|(low, high)| [(low, "at-most", high), (high, "at-least", low)]).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::Model;

    #[test]
    fn the_resolution_is_that_of_the_description() {
        let eds = include_bytes!("../../../models/kuebler-sendix-58x8.eds");
        let model = Model::generic("my.eds", eds).unwrap();
        let measurement: &Measurement = model.sheet().application.get().unwrap();
        assert_eq!((measurement.single_turn_bits, measurement.revolutions), (13, 4096));
    }

    /// If TPDO 1 has no event timer, 6200h is its timer; if TPDO 1 has one, it is linked with 6200h.
    #[test]
    fn the_cyclic_timer_is_that_of_the_first_tpdo() {
        let of = |id: &str| {
            let eds = Model::by_id(id).unwrap().eds_text().unwrap();
            let model = Model::generic("my.eds", eds.as_bytes()).unwrap();
            let quirks = &model.sheet().quirks;
            (quirks.cyclic_tpdo, quirks.limit_switches, model.sheet().links.len(), model.sheet().checks.len())
        };
        assert_eq!(of("lika-ax58"), (true, true, 0, 0));
        assert_eq!(of("tr-c65"), (true, false, 0, 0));
        assert_eq!(of("kuebler-sendix-58x8"), (false, false, 1, 4));
        assert_eq!(of("reference-301"), (false, false, 0, 0));
    }
}
