//! Identification of the encoder: resolutions (6501h, 6502h, 650Ah), versions (6507h), operating time (6508h), serial
//! number (650Bh).

use super::number;
use super::position::{UNITS_PER_REVOLUTION, small_range};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Allowed, Breach, Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_traces::Duration;

const SINGLE_TURN: Multiplexer = Multiplexer::new(encoder::SINGLE_TURN_RESOLUTION, 0);
const REVOLUTIONS: Multiplexer = Multiplexer::new(encoder::NUMBER_OF_REVOLUTIONS, 0);
const VERSIONS: Multiplexer = Multiplexer::new(encoder::PROFILE_AND_SOFTWARE_VERSION, 0);
const OPERATING_TIME: Multiplexer = Multiplexer::new(encoder::OPERATING_TIME, 0);
const SERIAL_NUMBER: Multiplexer = Multiplexer::new(encoder::SERIAL_NUMBER, 0);
const IDENTITY_SERIAL_NUMBER: Multiplexer = Multiplexer::new(object::IDENTITY, 4);
/// The value of 6508h and 650Bh for "not supported".
const UNUSED: u32 = u32::MAX;

/// 6501h is the physical resolution: scaling does not change it.
///
/// Some devices show the scaled resolution, as their manuals say.
#[case(id = "406/resolution/physical", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder], catches = [SingleTurnResolutionFollowsScaling])]
fn physical(bench: &mut Bench<'_>) -> Judged {
    let before = bench.read_number(SINGLE_TURN)?;
    small_range(bench)?;
    bench.write(UNITS_PER_REVOLUTION, &200_u32.to_le_bytes())?;
    let after = bench.read_number(SINGLE_TURN)?;
    bench.check(demand(after == before, || {
        Breach::new(SINGLE_TURN, "6501h does not follow 6001h").expected(number(before)).found(number(after))
    }))
}

/// 6501h and 6502h are not 0: every encoder has steps and at least one revolution.
#[case(id = "406/resolution/not-zero", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder], catches = [RevolutionsZero])]
fn not_zero(bench: &mut Bench<'_>) -> Judged {
    bench.each([SINGLE_TURN, REVOLUTIONS], |bench, at| {
        let value = bench.read_number(at)?;
        bench.check(demand(value > 0, || {
            Breach::new(at, format!("{at} tells the physical resolution")).expected("at least 1").found(number(value))
        }))
    })
}

/// One of the two words of 6507h holds the version of the profile, as major and minor number.
#[case(id = "406/version/profile", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder], catches = [ProfileVersionUnset])]
fn version(bench: &mut Bench<'_>) -> Judged {
    let versions = bench.read_number(VERSIONS)?;
    let is_version = |word: u32| matches!(word >> 8, 1..=5) || matches!(word, 0x0100..=0x0599);
    bench.check(demand(versions != UNUSED && (is_version(versions & 0xFFFF) || is_version(versions >> 16)), || {
        let duty = "6507h names the version of the profile";
        let breach = Breach::new(VERSIONS, duty).expected("a word from 0100h to 05FFh").found(number(versions));
        breach.told(format!("{versions:08X}h"))
    }))
}

/// 6508h counts upwards in tenths of an hour; FFFF FFFFh means that it does not count.
#[case(id = "406/operating-time/counts", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder], catches = [OperatingTimeBackwards, OperatingTimeInSeconds])]
fn operating_time(bench: &mut Bench<'_>) -> Judged {
    const SPAN: Duration = Duration::from_secs(3);
    if !bench.has(OPERATING_TIME)? {
        let reason = Reason::new("the encoder counts its operating time", "6508h", "none");
        return Err(Stop::NotApplicable(reason));
    }
    let before = bench.read_number(OPERATING_TIME)?;
    if before == UNUSED {
        return Ok(());
    }
    bench.listen(SPAN)?;
    let after = bench.read_number(OPERATING_TIME)?;
    bench.check(demand(after.checked_sub(before).is_some_and(|passed| passed <= 1), || {
        let duty = format!("{SPAN} add no more than one tenth of an hour to 6508h");
        let expected = Allowed::OneOf(vec![number(before), number(u64::from(before) + 1)]);
        Breach::new(OPERATING_TIME, duty).expected(expected).found(number(after))
    }))
}

/// 650Bh equals the serial number of the identity object, 1018h:04; FFFF FFFFh means that it is not used.
#[case(id = "406/serial-number/identity", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder], catches = [SerialNumberDiffers])]
fn serial_number(bench: &mut Bench<'_>) -> Judged {
    if !bench.has(SERIAL_NUMBER)? || !bench.has(IDENTITY_SERIAL_NUMBER)? {
        let reason = Reason::new("the serial number is in both objects", "650Bh and 1018h:04", "one of them at most");
        return Err(Stop::NotApplicable(reason));
    }
    let (own, identity) = (bench.read_number(SERIAL_NUMBER)?, bench.read_number(IDENTITY_SERIAL_NUMBER)?);
    bench.check(demand(own == identity || own == UNUSED, || {
        let breach = Breach::new(SERIAL_NUMBER, "650Bh is the serial number of 1018h:04");
        breach.expected(Allowed::OneOf(vec![number(identity), number(UNUSED)])).found(number(own))
    }))
}
