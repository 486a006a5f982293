//! The position of an encoder lies in the measuring range, whatever scaling the device has accepted.

use crate::Knowledge;
use crate::profile::{Broken, Dialogue};
use crate::property::ProfileProperty;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::objects;
use canvass_analyzer::wire::sdo::Request;

/// The position lies in its range for every scaling (6000h, 6001h, 6002h) and preset (6003h) that the device has
/// accepted.
pub(super) static IN_RANGE: ProfileProperty = ProfileProperty {
    id: "PROP-15",
    title: "the position stays in its range",
    explanation: " For every scaling (6000h, 6001h, 6002h) and preset (6003h) that the device has accepted, the position 6004h \
                  lies\n in the measuring range: from 0 to 6002h - 1.\n",
};

const POSITION: Multiplexer = Multiplexer::new(objects::POSITION_VALUE, 0);
const OPERATING_PARAMETERS: Multiplexer = Multiplexer::new(objects::OPERATING_PARAMETERS, 0);
const RANGE: Multiplexer = Multiplexer::new(objects::TOTAL_MEASURING_RANGE, 0);
/// Bit of 6000h that makes 6001h and 6002h scale the position.
const SCALING: u64 = 1 << 2;

/// Checks a value: the position must be inside its range.
pub(super) fn judge(
    at: Multiplexer,
    value: &[u8],
    knowledge: &Knowledge,
    expected: &dyn Fn(Multiplexer) -> Option<u64>,
) -> Option<Broken> {
    if at != POSITION || value.len() > 4 || knowledge.services.acts_when_stored.contains(&RANGE) {
        return None;
    }
    let position = value.iter().rev().fold(0, |raw, &byte| raw << 8 | u64::from(byte));
    let scaled = expected(OPERATING_PARAMETERS)? & SCALING != 0;
    // 6002h = 0 stands for a range of 2^32.
    let range = expected(RANGE).filter(|&range| scaled && range > 0)?;
    (position >= range).then(|| Broken {
        property: &IN_RANGE,
        expected: format!("6004h from 0 to {} (6002h - 1)", range - 1),
        actual: format!("{position}"),
    })
}

/// Writes scaling and preset, then reads the position.
pub(super) fn dialogue(script: &mut dyn Dialogue) -> bool {
    if script.knowledge().entry(POSITION).is_none() {
        return false;
    }
    script.ask(Request::download(OPERATING_PARAMETERS, &[SCALING as u8, 0]));
    for index in [objects::UNITS_PER_REVOLUTION, objects::TOTAL_MEASURING_RANGE, objects::PRESET_VALUE] {
        if script.below(3) == 0 {
            continue;
        }
        let at = Multiplexer::new(index, 0);
        let value = match script.below(3) {
            0 => script.value_of(at),
            1 => Some(1 << script.below(28)),
            _ => Some(script.number() & 0xFFFF),
        };
        if let Some(value) = value {
            script.ask(Request::download(at, &value.to_le_bytes()[..4]));
        }
    }
    script.ask(Request::upload(OPERATING_PARAMETERS));
    script.ask(Request::upload(POSITION));
    true
}
