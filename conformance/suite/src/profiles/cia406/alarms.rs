//! Alarms (6503h, 6504h) and warnings (6505h, 6506h), and their agreement with EMCY and error register.

use super::number;
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Breach, Judged, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{self, Emcy, EmcyCode};
use canvass_analyzer::wire::nmt::Command;
use canvass_traces::{Duration, Record};

const ALARMS: Multiplexer = Multiplexer::new(encoder::ALARMS, 0);
const SUPPORTED_ALARMS: Multiplexer = Multiplexer::new(encoder::SUPPORTED_ALARMS, 0);
const WARNINGS: Multiplexer = Multiplexer::new(encoder::WARNINGS, 0);
const SUPPORTED_WARNINGS: Multiplexer = Multiplexer::new(encoder::SUPPORTED_WARNINGS, 0);
const ERROR_REGISTER: Multiplexer = Multiplexer::new(object::ERROR_REGISTER, 0);
/// The upper temperature limit of Kübler's Sendix encoders, in degrees Celsius plus 64.
const TEMPERATURE_LIMIT: Multiplexer = Multiplexer::new(0x2120, 3);
/// -31 °C, colder than any test bench.
const FREEZING: u8 = 0x21;
/// Bit 14 of 6505h, the temperature warning of these encoders.
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

/// 6503h shows supported alarms only: it has no bit set that is 0 in 6504h.
#[case(id = "406/alarms/supported", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, Alarms], catches = [UnsupportedAlarmSet])]
fn supported_alarms(bench: &mut Bench<'_>) -> Judged {
    within(bench, ALARMS, SUPPORTED_ALARMS)
}

/// 6505h shows supported warnings only: it has no bit set that is 0 in 6506h.
#[case(id = "406/warnings/supported", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, Alarms], catches = [UnsupportedWarningSet])]
fn supported_warnings(bench: &mut Bench<'_>) -> Judged {
    within(bench, WARNINGS, SUPPORTED_WARNINGS)
}

fn within(bench: &mut Bench<'_>, shown: Multiplexer, supported: Multiplexer) -> Judged {
    let (bits, known) = (bench.read_number(shown)?, bench.read_number(supported)?);
    bench.check(demand(bits & !known == 0, || {
        let duty = format!("{shown} has only bits that {supported} supports");
        let breach = Breach::new(shown, duty).expected(format!("only bits of {known:04X}h"));
        breach.found(number(bits & !known)).told(format!("{bits:04X}h"))
    }))
}

/// The reserved bits 2 to 11 of 6503h are 0.
#[case(id = "406/alarms/reserved-bits", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = super::needs[Encoder, Alarms], catches = [ReservedAlarmBitSet])]
fn reserved_alarms(bench: &mut Bench<'_>) -> Judged {
    let alarms = bench.read_number(ALARMS)?;
    bench.check(demand(alarms & RESERVED_ALARMS == 0, || {
        let breach = Breach::new(ALARMS, "reserved bits of 6503h are 0").expected("bits 2 to 11 are 0");
        breach.found(number(alarms & RESERVED_ALARMS)).told(format!("{alarms:04X}h"))
    }))
}

/// The error register shows an alarm too: while a bit of 6503h is set, 1001h is not 0.
#[case(id = "406/alarms/error-register", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, Alarms], catches = [AlarmWithoutEmcy])]
fn error_register(bench: &mut Bench<'_>) -> Judged {
    let (alarms, register) = (bench.read_number(ALARMS)?, bench.read_number(ERROR_REGISTER)?);
    bench.check(demand(alarms == 0 || register != 0, || {
        let duty = format!("1001h shows that there is an alarm (6503h = {alarms:04X}h)");
        Breach::new(ERROR_REGISTER, duty).expected("at least one bit set").found(number(register))
    }))
}

/// An EMCY 1000h after the start reports an alarm: a bit of 6503h is set.
#[case(id = "406/alarms/emcy", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, Alarms], catches = [EmcyWithoutAlarm])]
fn alarm_of_emcy(bench: &mut Bench<'_>) -> Judged {
    bench.expect_emergencies();
    bench.drain()?;
    bench.command(Command::RESET_NODE)?;
    let heard = bench.listen(bench.timing().boot_up)?;
    let sent = emergencies(bench, &heard);
    let alarms = bench.read_number(ALARMS)?;
    bench.check(demand(alarms != 0 || !has_code(&sent, EmcyCode::GENERIC), || {
        let breach = Breach::new(ALARMS, "6503h shows what the EMCY 1000h reports");
        breach.expected("at least one bit set").found(number(alarms))
    }))
}

/// A temperature above its limit is a warning: bit 14 of 6505h is set, and the device sends EMCY 4200h. When the
/// temperature is within its limits again, both report its end.
#[case(id = "406/warnings/temperature", clause = "CiA 406", confidence = Unknown, level = Must,
       needs = super::needs[Encoder, TemperatureLimit], catches = [WarningWithoutEmcy, WarningNotSet, WarningNotCleared])]
fn temperature(bench: &mut Bench<'_>) -> Judged {
    const DEVICE_TEMPERATURE: EmcyCode = EmcyCode(0x4200);
    const SPAN: Duration = Duration::from_millis(500);
    bench.expect_emergencies();
    let usual = bench.read(TEMPERATURE_LIMIT)?;
    bench.drain()?;
    // The EMCY may come before the confirmation of the write, where `listen` does not see it: the objects are judged.
    let first = bench.read_number(ERROR_REGISTER)?;
    bench.write(TEMPERATURE_LIMIT, &[FREEZING])?;
    bench.listen(SPAN)?;
    let (warnings, register) = (bench.read_number(WARNINGS)?, bench.read_number(ERROR_REGISTER)?);
    bench.check(demand(warnings & TEMPERATURE_WARNING != 0, || {
        let duty = "6505h bit 14 is set while the temperature is above its limit";
        Breach::new(WARNINGS, duty).expected("bit 14 set").found(number(warnings)).told(format!("{warnings:04X}h"))
    }))?;
    bench.check(demand(register & 0x08 != 0, || {
        let duty = format!("1001h shows the error of EMCY {DEVICE_TEMPERATURE}");
        let breach = Breach::new(ERROR_REGISTER, duty).expected("bit 3 set").found(number(register));
        breach.told(format!("{first:02X}h, then {register:02X}h"))
    }))?;
    bench.write(TEMPERATURE_LIMIT, &usual)?;
    bench.listen(SPAN)?;
    let warnings = bench.read_number(WARNINGS)?;
    bench.check(demand(warnings & TEMPERATURE_WARNING == 0, || {
        let duty = "6505h bit 14 is clear again when the temperature is within its limits";
        Breach::new(WARNINGS, duty).expected("bit 14 clear").found(number(warnings)).told(format!("{warnings:04X}h"))
    }))
}
