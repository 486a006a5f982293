//! Operating parameters (6000h).

use super::number;
use super::position::OPERATING_PARAMETERS;
use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_bus::client::Outcome;

/// Bits 4 to 11 have no meaning in any version of the profile.
const RESERVED: u32 = 0x0FF0;

/// Reserved bits of 6000h are refused, or at least read back as 0.
#[case(id = "406/operating-parameters/reserved-bits", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder], catches = [ReservedOperatingBitsAccepted])]
fn reserved_bits(bench: &mut Bench<'_>) -> Judged {
    let before = bench.read_number(OPERATING_PARAMETERS)?;
    let attempt = bench.download(OPERATING_PARAMETERS, &((before | RESERVED) as u16).to_le_bytes())?;
    if attempt.outcome != Outcome::Downloaded {
        return Ok(());
    }
    let after = bench.read_number(OPERATING_PARAMETERS)?;
    bench.check(demand(after & RESERVED == 0, || {
        let breach = Breach::new(OPERATING_PARAMETERS, "6000h does not accept reserved bits");
        breach.expected("bits 4 to 11 are 0").found(number(after & RESERVED)).told(format!("{after:04X}h"))
    }))
}

/// Parameters that configure without other effects. Presets act when they are written, whatever the value.
const PARAMETERS: [u16; 7] = [
    encoder::OPERATING_PARAMETERS,
    encoder::UNITS_PER_REVOLUTION,
    encoder::TOTAL_MEASURING_RANGE,
    encoder::MEASURING_STEPS,
    encoder::CYCLIC_TIMER,
    encoder::WORK_AREA_LOW_LIMIT,
    encoder::WORK_AREA_HIGH_LIMIT,
];
/// Bit 2 of 6000h: the measuring range and the units per revolution take effect.
const SCALING: u32 = 1 << 2;

/// Profile parameters that the description calls writable accept their current values. While scaling is off, the device
/// may lock the scaling parameters.
#[case(id = "406/operating-parameters/own-value", clause = "CiA 301 7.4.5", confidence = Cited, level = Must,
       needs = super::needs[Encoder, Description], catches = [OperatingParametersRefused])]
fn own_value(bench: &mut Bench<'_>) -> Judged {
    let scaled = bench.read_number(OPERATING_PARAMETERS)? & SCALING != 0;
    let mut objects = Vec::new();
    for at in PARAMETERS.map(|index| Multiplexer::new(index, 0)) {
        if bench.can_write(at)? {
            objects.push(at);
        }
    }
    if objects.is_empty() {
        let reason = Reason::new("a parameter of the encoder can be written", "6000h or another one", "none");
        return Err(Stop::NotApplicable(reason));
    }
    bench.each(objects, |bench, at| {
        let Outcome::Uploaded(value) = bench.upload(at)?.outcome else { return Ok(()) };
        let attempt = bench.download(at, &value)?;
        let locked = matches!(at.index.0, encoder::UNITS_PER_REVOLUTION | encoder::TOTAL_MEASURING_RANGE)
            && !scaled
            && attempt.abort().is_some();
        let of_the_moment = matches!(
            attempt.abort(),
            Some(AbortCode::GENERAL | AbortCode::LOCAL_CONTROL | AbortCode::DEVICE_STATE | AbortCode(0x0800_0020))
        );
        if locked || of_the_moment {
            return Ok(());
        }
        bench.check(attempt.under("with its current value").refused(Situation::Confirmed))
    })
}
