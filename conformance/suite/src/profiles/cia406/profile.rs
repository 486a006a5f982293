//! The objects of an encoder, and their types.

use super::number;
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Breach, Judged, demand, observed};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_bus::client::Outcome;

/// The mandatory objects of an encoder of class C2.
const MANDATORY: [u16; 14] = [
    encoder::OPERATING_PARAMETERS,
    encoder::UNITS_PER_REVOLUTION,
    encoder::TOTAL_MEASURING_RANGE,
    encoder::PRESET_VALUE,
    encoder::POSITION_VALUE,
    encoder::OPERATING_STATUS,
    encoder::SINGLE_TURN_RESOLUTION,
    encoder::NUMBER_OF_REVOLUTIONS,
    encoder::ALARMS,
    encoder::SUPPORTED_ALARMS,
    encoder::WARNINGS,
    encoder::SUPPORTED_WARNINGS,
    encoder::PROFILE_AND_SOFTWARE_VERSION,
    encoder::OFFSET_VALUE,
];

/// The lengths of the data types; two lengths if the profile's versions differ.
const LENGTHS: [(u16, &[usize]); 17] = [
    (encoder::OPERATING_PARAMETERS, &[2]),
    (encoder::UNITS_PER_REVOLUTION, &[4]),
    (encoder::TOTAL_MEASURING_RANGE, &[4]),
    (encoder::PRESET_VALUE, &[4]),
    (encoder::POSITION_VALUE, &[4]),
    (encoder::CYCLIC_TIMER, &[2]),
    (encoder::OPERATING_STATUS, &[2]),
    (encoder::SINGLE_TURN_RESOLUTION, &[4]),
    // UNSIGNED16; more than 65535 revolutions need UNSIGNED32.
    (encoder::NUMBER_OF_REVOLUTIONS, &[2, 4]),
    (encoder::ALARMS, &[2]),
    (encoder::SUPPORTED_ALARMS, &[2]),
    (encoder::WARNINGS, &[2]),
    (encoder::SUPPORTED_WARNINGS, &[2]),
    (encoder::PROFILE_AND_SOFTWARE_VERSION, &[4]),
    (encoder::OPERATING_TIME, &[4]),
    (encoder::OFFSET_VALUE, &[4]),
    (encoder::SERIAL_NUMBER, &[4]),
];

const DEVICE_TYPE: Multiplexer = Multiplexer::new(object::DEVICE_TYPE, 0);
const REVOLUTIONS: Multiplexer = Multiplexer::new(encoder::NUMBER_OF_REVOLUTIONS, 0);

/// The upper word of the device type 1000h matches the encoder: 1 is a single-turn encoder, with one revolution in
/// 6502h, 2 a multi-turn encoder, with several.
#[case(id = "406/device-type/turns", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder], catches = [DeviceTypeTurnsWrong])]
fn device_type(bench: &mut Bench<'_>) -> Judged {
    let kind = bench.read_number(DEVICE_TYPE)? >> 16;
    let revolutions = bench.read_number(REVOLUTIONS)?;
    let fits = match kind {
        1 => revolutions <= 1,
        2 => revolutions > 1,
        _ => true,
    };
    if kind == 0 {
        bench.note("1000h does not say which kind of encoder it is");
    }
    bench.check(demand(fits, || {
        let expected = if kind == 1 { "1 revolution, as a single-turn encoder has" } else { "more than 1 revolution" };
        let duty = format!("6502h fits the type {kind} of 1000h");
        Breach::new(REVOLUTIONS, duty).expected(expected).found(number(revolutions))
    }))
}

/// All objects that class C2 requires exist.
#[case(id = "406/profile/mandatory-objects", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder], catches = [OperatingStatusMissing, AlarmsMissing])]
fn mandatory(bench: &mut Bench<'_>) -> Judged {
    bench.each(MANDATORY, |bench, index| {
        let at = Multiplexer::new(index, 0);
        let attempt = bench.upload(at)?;
        bench.check(demand(!attempt.is_silent() && attempt.abort() != Some(AbortCode::NO_OBJECT), || {
            let duty = format!("{index:04X}h, which class C2 demands, exists");
            Breach::new(at, duty)
                .expected("the value")
                .found(observed(&attempt.outcome))
                .told(attempt.outcome.to_string())
        }))
    })
}

/// The objects of the profile have the lengths of their data types.
#[case(id = "406/profile/data-types", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder], catches = [PositionSixteenBit, OperatingParametersThirtyTwoBit])]
fn data_types(bench: &mut Bench<'_>) -> Judged {
    bench.each(LENGTHS, |bench, (index, lengths)| {
        let at = Multiplexer::new(index, 0);
        let Outcome::Uploaded(value) = bench.upload(at)?.outcome else { return Ok(()) };
        bench.check(demand(lengths.contains(&value.len()), || {
            let expected: Vec<String> = lengths.iter().map(ToString::to_string).collect();
            let breach = Breach::new(at, format!("{index:04X}h has the length of its data type"));
            let breach = breach.expected(format!("{} bytes", expected.join(" or ")));
            breach.found(number(value.len() as u64)).told(format!("{} bytes", value.len()))
        }))
    })
}
