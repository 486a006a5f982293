//! Alarms (6503h, 6504h) and warnings (6505h, 6506h), and that EMCY and error register say the same.

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{self, Emcy, EmcyCode};
use canvass_analyzer::wire::nmt::Command;
use canvass_traces::{Duration, Record};

const ALARMS: Multiplexer = Multiplexer::new(0x6503, 0);
const SUPPORTED_ALARMS: Multiplexer = Multiplexer::new(0x6504, 0);
const WARNINGS: Multiplexer = Multiplexer::new(0x6505, 0);
const SUPPORTED_WARNINGS: Multiplexer = Multiplexer::new(0x6506, 0);
const ERROR_REGISTER: Multiplexer = Multiplexer::new(0x1001, 0);
/// The upper temperature limit of Kübler's Sendix encoders, in degrees Celsius plus 64.
const TEMPERATURE_LIMIT: Multiplexer = Multiplexer::new(0x2120, 3);
/// Below what any bench is: -31 °C.
const FREEZING: u8 = 0x21;
/// Bit 14 of 6505h, of these encoders.
const TEMPERATURE_WARNING: u32 = 1 << 14;
/// Bits 2 to 11 of 6503h have no meaning.
const RESERVED_ALARMS: u32 = 0x0FFC;

fn emergencies(bench: &Bench<'_>, heard: &[Record]) -> Vec<Emcy> {
    let cob_id = emcy::CAN_ID_BASE + u16::from(bench.node().raw());
    let own = heard.iter().filter(|record| record.frame.cob_id() == Some(cob_id));
    own.filter_map(|record| Emcy::read(record.frame.data()).ok()).collect()
}

fn has_code(emergencies: &[Emcy], code: EmcyCode) -> bool {
    emergencies.iter().any(|emcy| emcy.code() == Some(code))
}

/// No alarm is shown that is not supported: what 6504h does not have, 6503h does not have either.
#[case(id = "406/alarms/supported", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = [Encoder, Alarms], catches = [UnsupportedAlarmSet])]
fn supported_alarms(bench: &mut Bench<'_>) -> Judged {
    within(bench, ALARMS, SUPPORTED_ALARMS)
}

/// No warning is shown that is not supported: what 6506h does not have, 6505h does not have either.
#[case(id = "406/warnings/supported", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = [Encoder, Alarms], catches = [UnsupportedWarningSet])]
fn supported_warnings(bench: &mut Bench<'_>) -> Judged {
    within(bench, WARNINGS, SUPPORTED_WARNINGS)
}

fn within(bench: &mut Bench<'_>, shown: Multiplexer, supported: Multiplexer) -> Judged {
    let (bits, known) = (bench.read_number(shown)?, bench.read_number(supported)?);
    bench.check(demand(bits & !known == 0, || {
        let duty = format!("{shown} has no bit that {supported} does not support");
        Reason::new(duty, format!("no bit beside {known:04X}h"), format!("{bits:04X}h"))
    }))
}

/// Reserved bits of 6503h, 2 to 11, are 0.
#[case(id = "406/alarms/reserved-bits", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = [Encoder, Alarms], catches = [ReservedAlarmBitSet])]
fn reserved_alarms(bench: &mut Bench<'_>) -> Judged {
    let alarms = bench.read_number(ALARMS)?;
    bench.check(demand(alarms & RESERVED_ALARMS == 0, || {
        Reason::new("reserved bits of 6503h are 0", "bits 2 to 11 are 0", format!("{alarms:04X}h"))
    }))
}

/// An alarm is in the error register too: while 6503h has a bit, 1001h is not 0.
#[case(id = "406/alarms/error-register", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = [Encoder, Alarms], catches = [AlarmWithoutEmcy])]
fn error_register(bench: &mut Bench<'_>) -> Judged {
    let (alarms, register) = (bench.read_number(ALARMS)?, bench.read_number(ERROR_REGISTER)?);
    bench.check(demand(alarms == 0 || register != 0, || {
        let duty = format!("1001h shows that there is an alarm (6503h = {alarms:04X}h)");
        Reason::new(duty, "bit 0 at least", format!("{register:02X}h"))
    }))
}

/// An EMCY 1000h after the start is an alarm: 6503h has a bit.
#[case(id = "406/alarms/emcy", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = [Encoder, Alarms], catches = [EmcyWithoutAlarm])]
fn alarm_of_emcy(bench: &mut Bench<'_>) -> Judged {
    bench.expect_emergencies();
    bench.drain()?;
    bench.command(Command::RESET_NODE)?;
    let heard = bench.listen(bench.timing().boot_up)?;
    let sent = emergencies(bench, &heard);
    let alarms = bench.read_number(ALARMS)?;
    bench.check(demand(alarms != 0 || !has_code(&sent, EmcyCode::GENERIC), || {
        Reason::new("6503h shows what the EMCY 1000h reports", "a bit of 6503h", "0000h")
    }))
}

/// A temperature beyond its limit is a warning: 6505h bit 14 is set, and an EMCY 4200h is sent. When it is back, both say
/// so.
#[case(id = "406/warnings/temperature", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = [Encoder, TemperatureLimit], catches = [WarningWithoutEmcy, WarningNotSet, WarningNotCleared])]
fn temperature(bench: &mut Bench<'_>) -> Judged {
    const DEVICE_TEMPERATURE: EmcyCode = EmcyCode(0x4200);
    const SPAN: Duration = Duration::from_millis(500);
    bench.expect_emergencies();
    let usual = bench.read(TEMPERATURE_LIMIT)?;
    bench.drain()?;
    // What the transfer itself hears is not handed out: the EMCY may come before the confirmation.
    let first = bench.read_number(ERROR_REGISTER)?;
    bench.write(TEMPERATURE_LIMIT, &[FREEZING])?;
    bench.listen(SPAN)?;
    let (warnings, register) = (bench.read_number(WARNINGS)?, bench.read_number(ERROR_REGISTER)?);
    demand(warnings & TEMPERATURE_WARNING != 0, || {
        let duty = "6505h bit 14 is set while the temperature is above its limit";
        Reason::new(duty, "bit 14", format!("{warnings:04X}h"))
    })?;
    demand(register & 0x08 != 0, || {
        let duty = format!("1001h and EMCY {DEVICE_TEMPERATURE} report it");
        Reason::new(duty, "bit 3 of 1001h", format!("{first:02X}h, then {register:02X}h"))
    })?;
    bench.write(TEMPERATURE_LIMIT, &usual)?;
    bench.listen(SPAN)?;
    let warnings = bench.read_number(WARNINGS)?;
    bench.check(demand(warnings & TEMPERATURE_WARNING == 0, || {
        let duty = "6505h bit 14 is clear again when the temperature is within its limits";
        Reason::new(duty, "bit 14 clear", format!("{warnings:04X}h"))
    }))
}
