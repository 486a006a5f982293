//! The start of a device after "save" and after "load", compared with its start before.

use super::store::{restarted, restores};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Breach, Judged, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::Service;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{self, Emcy, EmcyCode};
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::Duration;

const STORE: Multiplexer = Multiplexer::new(object::STORE_PARAMETERS, 1);
const RESTORE: Multiplexer = Multiplexer::new(object::RESTORE_DEFAULT_PARAMETERS, 1);

/// Wait after the confirmation of a command: some devices go on writing their memory, which a reset would interrupt.
const WRITTEN: Duration = Duration::from_millis(200);

/// Time after a boot-up message in which a device reports the errors of its start.
const REPORTED: Duration = Duration::from_millis(250);

/// A start of the device.
struct Start {
    /// The errors that the device reported.
    errors: Vec<EmcyCode>,
    /// The state after start remote node; `None` if the device shows none.
    state: Option<State>,
}

/// After "save" and reset node the device starts as before: it reports no further error, and enters operational if it
/// did so before.
#[case(id = "301/store/start", clause = "CiA 301 7.5.2.13", confidence = Cited, level = Must,
       needs = [Store], touches = [Nvm], catches = [StoreBreaksStart])]
fn after_save(bench: &mut Bench<'_>) -> Judged {
    starts_as_before(bench, STORE, b"save")
}

/// After "load" and reset node the device starts as before: it reports no further error, and enters operational if it
/// did so before.
///
/// An error that concerns only communication (8xxxh) is no breach: the defaults may make a device wait for nodes that
/// are not there.
#[case(id = "301/restore/start", clause = "CiA 301 7.5.2.14", confidence = Cited, level = Must,
       needs = [Store], touches = [Nvm, FactoryDefaults], catches = [RestoreBreaksStart])]
fn after_load(bench: &mut Bench<'_>) -> Judged {
    restores(bench)?;
    starts_as_before(bench, RESTORE, b"load")
}

fn starts_as_before(bench: &mut Bench<'_>, at: Multiplexer, signature: &[u8]) -> Judged {
    bench.expect_emergencies();
    let before = start(bench)?;
    bench.reset(Command::RESET_NODE)?;
    bench.write_confirmed(at, signature)?;
    bench.listen(WRITTEN)?;
    let after = start(bench)?;
    let cause = format!("\"{}\" and reset node", String::from_utf8_lossy(signature));
    let is_new = |code: &&EmcyCode| !before.errors.contains(code) && code.0 & 0xF000 != 0x8000;
    if let Some(code) = after.errors.iter().find(is_new) {
        let breach = Breach::new(Service::Emcy, format!("after {cause} the device starts without a new error"));
        let breach = breach.expected("the errors of the start before, or none").found(Observation::Emcy(*code));
        bench.check(Err(Box::new(breach)))?;
    }
    let stays = before.state == Some(State::OPERATIONAL) && after.state != Some(State::OPERATIONAL);
    bench.check(demand(!stays, || {
        Breach::new(Subject::Device, format!("after {cause} the device enters operational, as it did before"))
            .expected(Observation::State(State::OPERATIONAL))
            .found(after.state.map_or(Observation::Silence, Observation::State))
    }))
}

/// Restarts the device, and commands it to become operational.
fn start(bench: &mut Bench<'_>) -> Result<Start, Stop> {
    let begun = bench.now();
    restarted(bench)?;
    bench.listen(REPORTED)?;
    let emcy_id = emcy::CAN_ID_BASE + u16::from(bench.node().raw());
    let heard = bench.heard_since(begun);
    let own = heard.iter().filter(|record| record.frame.cob_id() == Some(emcy_id));
    let codes = own.filter_map(|record| Emcy::read(record.data()).ok()?.code());
    let errors = codes.filter(|code| !code.is_reset()).collect();
    bench.show_state()?;
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    Ok(Start { errors, state: bench.state()? })
}
