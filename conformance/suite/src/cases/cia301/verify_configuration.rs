//! Verify configuration (1020h): a configuration tool leaves date and time in the device, so that a master can check
//! whether the device still has the known configuration.

use crate::bench::Bench;
use crate::case;
use crate::verdict::Judged;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;

const DATE: Multiplexer = Multiplexer::new(object::VERIFY_CONFIGURATION, 1);
const TIME: Multiplexer = Multiplexer::new(object::VERIFY_CONFIGURATION, 2);
const STORE: Multiplexer = Multiplexer::new(object::STORE_PARAMETERS, 1);
/// Days since 1984-01-01, and milliseconds since midnight.
const STAMP: [[u8; 4]; 2] = [15_000_u32.to_le_bytes(), 43_200_000_u32.to_le_bytes()];

fn stamp(bench: &mut Bench<'_>) -> Judged {
    for (at, value) in [DATE, TIME].into_iter().zip(STAMP) {
        bench.download(at, &value)?.expect_confirmation()?;
    }
    holds(bench, STAMP, "1020h holds the written value")
}

fn holds(bench: &mut Bench<'_>, expected: [[u8; 4]; 2], duty: &str) -> Judged {
    for (at, value) in [DATE, TIME].into_iter().zip(expected) {
        bench.expect_value(at, &value, duty.to_owned())?;
    }
    Ok(())
}

/// Date and time in 1020h are 0 as soon as a parameter is changed.
///
/// The standard demands this for changes of boot-up values, and leaves open whether it includes a change that is not
/// stored.
#[case(id = "301/verify-configuration/cleared", clause = "CiA 301 7.5.2.23", confidence = Cited, level = Should,
       needs = [VerifyConfiguration, ScratchObject], catches = [ConfigurationDateKept], cct = "8.9")]
fn cleared(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 4, 1])?;
    stamp(bench)?;
    bench.write(scratch.multiplexer, &scratch.other)?;
    let duty = format!("a change of {} sets 1020h to 0", scratch.multiplexer);
    holds(bench, [[0; 4]; 2], &duty)
}

/// A stored date and time in 1020h are restored after reset node. The case stores the old values again afterwards.
#[case(id = "301/verify-configuration/stored", clause = "CiA 301 7.5.2.23", confidence = Cited, level = Must,
       needs = [VerifyConfiguration, Store], touches = [Nvm], catches = [ConfigurationDateLost, StoreWithoutEffect],
       cct = "8.9")]
fn stored(bench: &mut Bench<'_>) -> Judged {
    let before = [bench.read(DATE)?, bench.read(TIME)?];
    stamp(bench)?;
    bench.write(STORE, b"save")?;
    let judged = bench
        .reset(Command::RESET_NODE)
        .and_then(|()| holds(bench, STAMP, "1020h has its stored value after reset node"));
    for (at, value) in [DATE, TIME].into_iter().zip(&before) {
        bench.write(at, value)?;
    }
    bench.write(STORE, b"save")?;
    judged
}
