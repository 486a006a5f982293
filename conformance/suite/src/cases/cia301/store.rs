//! Store and restore parameters (1010h, 1011h). All these cases may write non-volatile memory, so the user must allow
//! them.

use crate::bench::Bench;
use crate::bench::objects::Scratch;
use crate::bench::sdo::number;
use crate::case;
use crate::situation::Situation;
use crate::touch::Touch;
use crate::verdict::{Breach, Check, Judged, Reason, Stop, demand, observed};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::Request;
use canvass_bus::client::Outcome;
use canvass_bus::observation::Observation;

const STORE: Multiplexer = Multiplexer::new(object::STORE_PARAMETERS, 1);
const RESTORE: Multiplexer = Multiplexer::new(object::RESTORE_DEFAULT_PARAMETERS, 1);
/// Bits of the value of 1010h:01: the device stores on command, or autonomously.
const COMMAND: u32 = 1 << 0;
const AUTO: u32 = 1 << 1;

/// 1010h refuses any signature but "save", with abort 0800 0020h, 0609 0030h or 0800 0000h.
#[case(id = "301/store/wrong-signature", clause = "CiA 301 7.5.2.13", confidence = Cited, level = Must,
       needs = [Store], touches = [Nvm], catches = [StoreSignatureUnchecked], cct = "8.3")]
fn wrong_signature(bench: &mut Bench<'_>) -> Judged {
    for signature in [b"evas", b"SAVE", b"wron", b"load"] {
        let attempt = bench.download(STORE, signature)?;
        bench.check(attempt.refused(Situation::WrongSignature))?;
    }
    Ok(())
}

/// Whether 1010h covers an object according to the description: 1010h has a sub-index of its own for the group of the
/// object. Otherwise the manufacturer chooses the stored objects.
fn is_covered(bench: &mut Bench<'_>, object: Multiplexer) -> Result<bool, Stop> {
    match object.index.0 {
        0x1000..=0x1FFF => bench.has(Multiplexer::new(object::STORE_PARAMETERS, 2)),
        0x6000..=0x9FFF => bench.has(Multiplexer::new(object::STORE_PARAMETERS, 3)),
        _ => Ok(false),
    }
}

/// "save" stores the values that parameters have at that moment: they are restored after reset node, and later writes
/// are not. This holds for all tested parameters that 1010h covers according to the description, and for at least one
/// parameter. The case stores the old values again afterwards.
#[case(id = "301/store/persists", clause = "CiA 301 7.5.2.13", confidence = Cited, level = Must,
       needs = [Store, ScratchObject], touches = [Nvm], catches = [ParameterDriftsAtReset, ErrorBehaviourAlwaysLeaves, StoreWithoutEffect, LaterValuesStored], cct = "8.5")]
fn persists(bench: &mut Bench<'_>) -> Judged {
    let mut scratches = bench.scratch_objects()?;
    scratches.extend(bench.application_scratch()?);
    scratches.dedup_by_key(|scratch| scratch.multiplexer);
    for scratch in &scratches {
        bench.write_confirmed(scratch.multiplexer, &scratch.other)?;
    }
    let saved = bench.download(STORE, b"save")?;
    if !bench.stores_by_itself()? {
        // These values are written after the store command, so they are not stored.
        for scratch in &scratches {
            bench.write(scratch.multiplexer, &scratch.value)?;
        }
    }
    bench.note("1010h was written twice: the device's non-volatile memory has done two more cycles");
    let after = bench.reset(Command::RESET_NODE).and_then(|()| {
        scratches.iter().map(|scratch| Ok(bench.upload(scratch.multiplexer)?.outcome)).collect::<Result<Vec<_>, Stop>>()
    });
    // The device gets its old values back, whether the check passed or not.
    for scratch in &scratches {
        bench.download(scratch.multiplexer, &scratch.value)?;
    }
    bench.write(STORE, b"save")?;
    saved.expect_confirmation()?;
    judge_stored(bench, &scratches, &after?)
}

fn judge_stored(bench: &mut Bench<'_>, scratches: &[Scratch], after: &[Outcome]) -> Judged {
    let mut any = false;
    for (scratch, now) in scratches.iter().zip(after) {
        let is_stored = *now == Outcome::Uploaded(scratch.other.clone());
        any |= is_stored;
        if is_covered(bench, scratch.multiplexer)? {
            bench.check(demand(is_stored, || {
                let breach =
                    Breach::new(scratch.multiplexer, STORED).expected(Observation::Value(scratch.other.clone()));
                breach.found(observed(now))
            }))?;
        } else if !is_stored {
            bench.note(format!("{} is not stored by 1010h:01", scratch.multiplexer));
        }
    }
    bench.check(demand(any, || {
        let breach = Breach::new(STORE, "a confirmed \"save\" stores parameters");
        breach.expected("one of the parameters that were written").found(Observation::named("nothing is stored"))
    }))
}

const STORED: &str = "a parameter that 1010h covers has its stored value after reset node";

/// "load" restores the defaults at the next reset, not before it.
#[case(id = "301/restore/at-reset", clause = "CiA 301 7.5.2.14", confidence = Cited, level = Must,
       needs = [Store, ScratchObject], touches = [Nvm, FactoryDefaults], catches = [RestoreAtOnce], cct = "8.4")]
fn at_reset(bench: &mut Bench<'_>) -> Judged {
    if !bench.has(RESTORE)? {
        return Err(Stop::NotApplicable(Reason::new("the device restores its defaults", "1011h:01", "none")));
    }
    let scratch = bench.scratch(&[2, 1, 4])?;
    bench.write(scratch.multiplexer, &scratch.other)?;
    bench.download(RESTORE, b"load")?.expect_confirmation()?;
    let duty = "\"load\" changes nothing before the next reset";
    bench.expect_value(scratch.multiplexer, &scratch.other, duty)
}

/// 1011h refuses any signature but "load", with abort 0800 0020h, 0609 0030h or 0800 0000h.
#[case(id = "301/restore/wrong-signature", clause = "CiA 301 7.5.2.14", confidence = Cited, level = Must,
       needs = [Store], touches = [Nvm, FactoryDefaults], catches = [RestoreSignatureUnchecked], cct = "8.3")]
fn restore_wrong_signature(bench: &mut Bench<'_>) -> Judged {
    restores(bench)?;
    for signature in [b"daol", b"LOAD", b"wron", b"save"] {
        let attempt = bench.download(RESTORE, signature)?;
        bench.check(attempt.refused(Situation::WrongSignature))?;
    }
    Ok(())
}

/// 1010h:01 tells whether the device stores parameters on command (bit 0) and by itself (bit 1); its other bits are 0.
#[case(id = "301/store/capability", clause = "CiA 301 7.5.2.13", confidence = Cited, level = Must,
       needs = [StoreObject], catches = [StoreCapabilityWrong], cct = "8.1")]
fn capability(bench: &mut Bench<'_>) -> Judged {
    let value = bench.upload(STORE)?.value()?;
    bench.check(demand(value.len() == 4 && number(&value) & !(COMMAND | AUTO) == 0, || {
        let breach = Breach::new(STORE, "1010h:01 is an UNSIGNED32 that tells how the device stores parameters");
        breach.expected("bits 0 and 1 only").found(Observation::Value(value))
    }))
}

/// A parameter of the device profile that was changed but not stored has its power-on value after reset node, unless
/// 1010h tells that the device stores parameters by itself.
#[case(id = "301/store/not-stored", clause = "CiA 301 7.3.2.2.1", confidence = Cited, level = Must,
       needs = [Store, ApplicationParameter], catches = [NmtResetNodeKeepsParameters])]
fn not_stored(bench: &mut Bench<'_>) -> Judged {
    not_by_itself(bench)?;
    let Some(scratch) = bench.application_scratch()? else { return Ok(()) };
    of_the_profile(&scratch)?;
    bench.write(scratch.multiplexer, &scratch.other)?;
    bench.reset(Command::RESET_NODE)?;
    bench.expect_value(scratch.multiplexer, &scratch.value, "a value that was not stored is lost with reset node")
}

/// Makes a case not applicable if the scratch object is the manufacturer's: it need not be a parameter, and a reset may
/// keep its value.
pub(super) fn of_the_profile(scratch: &Scratch) -> Judged {
    if scratch.multiplexer.index.0 >= 0x6000 {
        return Ok(());
    }
    let actual = format!("{} belongs to the manufacturer", scratch.multiplexer);
    Err(Stop::NotApplicable(Reason::new("an object of the device profile can be written", "6000h and above", actual)))
}

/// Makes a case not applicable if the device stores autonomously: then every value is stored.
pub(super) fn not_by_itself(bench: &mut Bench<'_>) -> Judged {
    if !bench.stores_by_itself()? {
        return Ok(());
    }
    let reason = Reason::new("the device stores on command only", "bit 1 of 1010h:01 clear", "set");
    Err(Stop::NotApplicable(reason))
}

/// A communication and an application parameter, each with its power-on value.
pub(super) struct Two {
    pub communication: Scratch,
    pub application: Scratch,
}

pub(super) fn two(bench: &mut Bench<'_>) -> Result<Two, Stop> {
    let found = bench.scratch_objects()?.into_iter().find(|scratch| scratch.multiplexer.index.0 < 0x2000);
    let Some(communication) = found else {
        let reason = Reason::new("a communication parameter can be written without consequence", "one", "none");
        return Err(Stop::NotApplicable(reason));
    };
    let Some(application) = bench.application_scratch()? else {
        let reason = Reason::new("an application object can be written without consequence", "one", "none");
        return Err(Stop::NotApplicable(reason));
    };
    Ok(Two { communication, application })
}

/// Writes both objects, stores by this sub-index of 1010h, resets, and returns both values. The old values are stored
/// again.
fn after_store(bench: &mut Bench<'_>, two: &Two, sub: u8) -> Result<[Vec<u8>; 2], Stop> {
    let objects = [&two.communication, &two.application];
    for scratch in objects {
        bench.write(scratch.multiplexer, &scratch.other)?;
    }
    bench.write(Multiplexer::new(object::STORE_PARAMETERS, sub), b"save")?;
    let after = bench
        .reset(Command::RESET_NODE)
        .and_then(|()| Ok([bench.read(objects[0].multiplexer)?, bench.read(objects[1].multiplexer)?]));
    for scratch in objects {
        bench.write(scratch.multiplexer, &scratch.value)?;
    }
    bench.write(STORE, b"save")?;
    bench.reset(Command::RESET_NODE)?;
    after
}

/// 1010h:01 stores communication and application parameters, if 1010h covers them according to the description.
#[case(id = "301/store/all", clause = "CiA 301 7.5.2.13", confidence = Cited, level = Must,
       needs = [Store, ScratchObject, ApplicationParameter], touches = [Nvm], catches = [StoreLosesGroup, StoreWithoutEffect],
       cct = "8.5")]
fn all(bench: &mut Bench<'_>) -> Judged {
    let two = two(bench)?;
    let after = after_store(bench, &two, 1)?.map(Outcome::Uploaded);
    judge_stored(bench, &[two.communication, two.application], &after)
}

fn stored(scratch: &Scratch, now: &[u8]) -> Check {
    demand(now == scratch.other, || {
        let breach = Breach::new(scratch.multiplexer, STORED).expected(Observation::Value(scratch.other.clone()));
        breach.found(Observation::Value(now.to_vec()))
    })
}

fn lost(scratch: &Scratch, now: &[u8]) -> Check {
    demand(now == scratch.value, || {
        Breach::new(scratch.multiplexer, "a parameter is not stored together with the other group")
            .expected(Observation::Value(scratch.value.clone()))
            .found(Observation::Value(now.to_vec()))
    })
}

/// 1010h:02 stores communication parameters only.
#[case(id = "301/store/communication-only", clause = "CiA 301 7.5.2.13", confidence = Cited, level = Must,
       needs = [Store, ScratchObject, ApplicationParameter], touches = [Nvm], catches = [StoreGroupIgnored], cct = "8.5")]
fn communication_only(bench: &mut Bench<'_>) -> Judged {
    group_only(bench, 2)
}

/// 1010h:03 stores application parameters only.
#[case(id = "301/store/application-only", clause = "CiA 301 7.5.2.13", confidence = Cited, level = Must,
       needs = [Store, ScratchObject, ApplicationParameter], touches = [Nvm], catches = [StoreGroupIgnored], cct = "8.6")]
fn application_only(bench: &mut Bench<'_>) -> Judged {
    group_only(bench, 3)
}

fn group_only(bench: &mut Bench<'_>, sub: u8) -> Judged {
    let object = Multiplexer::new(object::STORE_PARAMETERS, sub);
    if !bench.has(object)? {
        let reason = Reason::new("the group can be stored alone", object.to_string(), "absent");
        return Err(Stop::NotApplicable(reason));
    }
    not_by_itself(bench)?;
    let two = two(bench)?;
    of_the_profile(&two.application)?;
    let [communication, application] = after_store(bench, &two, sub)?;
    if sub == 2 {
        bench.check(stored(&two.communication, &communication))?;
        bench.check(lost(&two.application, &application))
    } else {
        bench.check(stored(&two.application, &application))?;
        bench.check(lost(&two.communication, &communication))
    }
}

/// After a reset during storing, either all parameters that the device can store are old, or all are new.
#[case(id = "301/store/reset-at-once", clause = "CiA 301 7.5.2.13", confidence = Cited, level = Should,
       needs = [Store, ScratchObject, ApplicationParameter], touches = [Nvm], catches = [StoreTornByReset])]
fn reset_at_once(bench: &mut Bench<'_>) -> Judged {
    not_by_itself(bench)?;
    let two = two(bench)?;
    of_the_profile(&two.application)?;
    let objects = [&two.communication, &two.application];
    for scratch in objects {
        bench.write(scratch.multiplexer, &scratch.other)?;
    }
    bench.send_request(&Request::download(STORE, b"save"))?;
    bench.reset(Command::RESET_NODE)?;
    let now = [bench.read(objects[0].multiplexer)?, bench.read(objects[1].multiplexer)?];
    for scratch in objects {
        bench.write(scratch.multiplexer, &scratch.value)?;
    }
    bench.write(STORE, b"save")?;
    bench.reset(Command::RESET_NODE)?;
    let is_new = [now[0] == two.communication.other, now[1] == two.application.other];
    if is_new[0] == is_new[1] {
        return Ok(());
    }
    // The breach does not count if the device can't store these objects at all.
    let whole = after_store(bench, &two, 1)?;
    let can_be_stored = whole[0] == two.communication.other && whole[1] == two.application.other;
    let [old, found] = if is_new[0] { [objects[1], objects[0]] } else { [objects[0], objects[1]] };
    bench.check(demand(!can_be_stored, || {
        Breach::new(STORE, "after a reset while parameters are stored, all parameters are old or all are new")
            .expected("all old or all new")
            .found(Observation::named("some parameters are new and some are old"))
            .told(format!("{} old, {} new", old.multiplexer, found.multiplexer))
    }))
}

/// "load" and a reset restore the defaults.
#[case(id = "301/restore/defaults", clause = "CiA 301 7.5.2.14", confidence = Cited, level = Must,
       needs = [Store, ScratchObject], touches = [Nvm, FactoryDefaults], catches = [RestoreWithoutEffect], cct = "8.8")]
fn defaults(bench: &mut Bench<'_>) -> Judged {
    restores(bench)?;
    let scratch = bench.scratch(&[2, 1, 4])?;
    bench.write(scratch.multiplexer, &scratch.other)?;
    bench.write(STORE, b"save")?;
    bench.download(RESTORE, b"load")?.expect_confirmation()?;
    // Writing the memory takes time; a reset during that time would undo the command.
    bench.listen(canvass_traces::Duration::from_millis(200))?;
    restarted(bench)?;
    let now = bench.read(scratch.multiplexer)?;
    bench.write(scratch.multiplexer, &scratch.value)?;
    bench.write(STORE, b"save")?;
    bench.check(demand(now != scratch.other, || {
        Breach::new(scratch.multiplexer, "a parameter has its default after \"load\" and reset node")
            .expected("another value than the stored one")
            .found(Observation::Value(now))
    }))
}

/// Resets the device. If the device then has no node-ID, because its defaults include none, the tester gives it its own
/// again, if the user allows that.
pub(super) fn restarted(bench: &mut Bench<'_>) -> Judged {
    let reset = bench.reset(Command::RESET_NODE);
    match (reset, crate::cases::cia305::needs::LSS.rescue()) {
        (Err(Stop::Inconclusive(_) | Stop::Breach(_)), Some(regain))
            if bench.options().allow.contains(&Touch::NodeId) && !bench.answers()? =>
        {
            regain(bench, true)?;
            bench.note("after \"load\" and reset node the device had no node-ID: the tester set it again by LSS");
            Ok(())
        }
        (reset, _) => reset,
    }
}

/// Makes a case not applicable if the device can't restore defaults.
pub(super) fn restores(bench: &mut Bench<'_>) -> Result<(), Stop> {
    if bench.has(RESTORE)? {
        return Ok(());
    }
    Err(Stop::NotApplicable(Reason::new("defaults can be restored", "1011h:01", "the device has no 1011h:01")))
}

/// A device whose 1010h:01 tells that it does not store parameters on command (bit 0 is 0) refuses "save".
#[case(id = "301/store/not-supported", clause = "CiA 301 7.5.2.13", confidence = Cited, level = Must,
       needs = [StoreObject], touches = [Nvm], catches = [StoreCapabilityDenied])]
fn not_supported(bench: &mut Bench<'_>) -> Judged {
    let value = bench.read_number(STORE)?;
    if value & COMMAND != 0 {
        let reason =
            Reason::new("the device does not store on command", "bit 0 of 1010h:01 clear", format!("{value:08X}h"));
        return Err(Stop::NotApplicable(reason));
    }
    let mut attempt = bench.download(STORE, b"save")?;
    attempt.what = "\"save\" to a device that does not store on command".to_owned();
    bench.check(attempt.refused(Situation::StoreUnsupported))
}

/// The device executes "save" in operational, or refuses it because of its state, with abort 0800 0022h or a related
/// code. The case notes which of the two it does.
#[case(id = "301/store/operational", clause = "CiA 301 7.3.2.2.3", confidence = Cited, level = Should,
       needs = [Store], touches = [Nvm], catches = [StoreSilentWhenOperational, SdoSilentWhenOperational])]
fn operational(bench: &mut Bench<'_>) -> Judged {
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    let mut attempt = bench.download(STORE, b"save")?;
    attempt.what = "\"save\" in operational".to_owned();
    bench.note(format!("\"save\" in operational: {}", attempt.outcome));
    bench.listen(canvass_traces::Duration::from_millis(100))?;
    bench.check(attempt.refused(Situation::StoreInOperational))
}
