//! Store and restore parameters (1010h, 1011h). All of it may write non-volatile memory, so the user has to allow it.

use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Check, Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_bus::client::sdo::Bytes;

const STORE: Multiplexer = Multiplexer::new(0x1010, 1);
const RESTORE: Multiplexer = Multiplexer::new(0x1011, 1);

/// Any signature but "save" is refused by 1010h with abort 0800 0020h.
#[case(id = "301/store/wrong-signature", clause = "CiA 301 7.5.2.13", confidence = Derived, level = Must,
       needs = [Store], touches = [Nvm], catches = [StoreSignatureUnchecked], cct = "8.3")]
fn wrong_signature(bench: &mut Bench<'_>) -> Judged {
    for signature in [b"evas", b"SAVE", b"wron", b"load"] {
        let attempt = bench.download(STORE, signature)?;
        bench.check(attempt.refused(Situation::WrongSignature))?;
    }
    Ok(())
}

/// What was stored by "save" is there after reset node. The old value is stored again afterwards.
#[case(id = "301/store/persists", clause = "CiA 301 7.5.2.13", confidence = Derived, level = Must,
       needs = [Store, ScratchObject], touches = [Nvm], catches = [StoreWithoutEffect], cct = "8.5")]
fn persists(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 1, 4])?;
    bench.write(scratch.multiplexer, &scratch.other)?;
    bench.download(STORE, b"save")?.expect_confirmation()?;
    bench.note("1010h was written twice: the device's non-volatile memory has done two more cycles");
    let stored = bench.reset(Command::RESET_NODE).and_then(|()| bench.read(scratch.multiplexer));
    // Whatever came of it, the device gets its old value back.
    bench.write(scratch.multiplexer, &scratch.value)?;
    bench.write(STORE, b"save")?;
    let stored = stored?;
    bench.check(demand(stored == scratch.other, || {
        let duty = format!("{} has its stored value after reset node", scratch.multiplexer);
        Reason::new(duty, Bytes(&scratch.other).to_string(), Bytes(&stored).to_string())
    }))
}

/// "load" restores the defaults with the next reset, not before.
#[case(id = "301/restore/at-reset", clause = "CiA 301 7.5.2.14", confidence = Derived, level = Must,
       needs = [Store, ScratchObject], touches = [Nvm, FactoryDefaults], catches = [RestoreAtOnce], cct = "8.4")]
fn at_reset(bench: &mut Bench<'_>) -> Judged {
    if !bench.has(RESTORE)? {
        return Err(Stop::NotApplicable(Reason::new("the device restores its defaults", "1011h:01", "none")));
    }
    let scratch = bench.scratch(&[2, 1, 4])?;
    bench.write(scratch.multiplexer, &scratch.other)?;
    bench.download(RESTORE, b"load")?.expect_confirmation()?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.other)
}

/// Any signature but "load" is refused by 1011h with abort 0800 0020h.
#[case(id = "301/restore/wrong-signature", clause = "CiA 301 7.5.2.14", confidence = Derived, level = Must,
       needs = [Store], touches = [Nvm, FactoryDefaults], catches = [RestoreSignatureUnchecked], cct = "8.3")]
fn restore_wrong_signature(bench: &mut Bench<'_>) -> Judged {
    restores(bench)?;
    for signature in [b"daol", b"LOAD", b"wron", b"save"] {
        let attempt = bench.download(RESTORE, signature)?;
        bench.check(attempt.refused(Situation::WrongSignature))?;
    }
    Ok(())
}

/// 1010h:01 says whether the device stores on command (bit 0) and by itself (bit 1); the other bits are 0.
#[case(id = "301/store/capability", clause = "CiA 301 7.5.2.13", confidence = Derived, level = Should,
       needs = [Store], catches = [StoreCapabilityWrong], cct = "8.1")]
fn capability(bench: &mut Bench<'_>) -> Judged {
    let value = bench.read_number(STORE)?;
    bench.check(demand(value & !3 == 0, || {
        Reason::new("1010h:01 tells how the device stores", "bits 0 and 1 only", format!("{value:08X}h"))
    }))
}

/// A value that was changed but not stored is lost with reset node.
#[case(id = "301/store/not-stored", clause = "CiA 301 7.5.2.13", confidence = Derived, level = Must,
       needs = [Store, ApplicationParameter], catches = [NmtResetNodeKeepsParameters])]
fn not_stored(bench: &mut Bench<'_>) -> Judged {
    let Some(scratch) = bench.application_scratch()? else { return Ok(()) };
    bench.write(scratch.multiplexer, &scratch.other)?;
    bench.reset(Command::RESET_NODE)?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.value)
}

/// A communication and an application parameter, each with its power-on value.
struct Two {
    communication: crate::bench::objects::Scratch,
    application: crate::bench::objects::Scratch,
}

fn two(bench: &mut Bench<'_>) -> Result<Two, Stop> {
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

/// Writes both, stores by that sub-index of 1010h, resets, and gives both values of after. The old ones are stored again.
fn after_store(bench: &mut Bench<'_>, two: &Two, sub: u8) -> Result<[Vec<u8>; 2], Stop> {
    let objects = [&two.communication, &two.application];
    for scratch in objects {
        bench.write(scratch.multiplexer, &scratch.other)?;
    }
    bench.write(Multiplexer::new(0x1010, sub), b"save")?;
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

/// 1010h:01 stores communication and application parameters.
#[case(id = "301/store/all", clause = "CiA 301 7.5.2.13", confidence = Derived, level = Must,
       needs = [Store, ScratchObject, ApplicationParameter], touches = [Nvm], catches = [StoreLosesGroup, StoreWithoutEffect],
       cct = "8.5")]
fn all(bench: &mut Bench<'_>) -> Judged {
    let two = two(bench)?;
    let [communication, application] = after_store(bench, &two, 1)?;
    bench.check(stored(&two.communication, &communication))?;
    bench.check(stored(&two.application, &application))
}

fn stored(scratch: &crate::bench::objects::Scratch, now: &[u8]) -> Check {
    demand(now == scratch.other, || {
        let duty = format!("{} has its stored value after reset node", scratch.multiplexer);
        Reason::new(duty, Bytes(&scratch.other).to_string(), Bytes(now).to_string())
    })
}

fn lost(scratch: &crate::bench::objects::Scratch, now: &[u8]) -> Check {
    demand(now == scratch.value, || {
        let duty = format!("{} was not stored with the other group", scratch.multiplexer);
        Reason::new(duty, Bytes(&scratch.value).to_string(), Bytes(now).to_string())
    })
}

/// 1010h:02 stores communication parameters only.
#[case(id = "301/store/communication-only", clause = "CiA 301 7.5.2.13", confidence = Derived, level = Must,
       needs = [Store, ScratchObject, ApplicationParameter], touches = [Nvm], catches = [StoreGroupIgnored], cct = "8.5")]
fn communication_only(bench: &mut Bench<'_>) -> Judged {
    group_only(bench, 2)
}

/// 1010h:03 stores application parameters only.
#[case(id = "301/store/application-only", clause = "CiA 301 7.5.2.13", confidence = Derived, level = Must,
       needs = [Store, ScratchObject, ApplicationParameter], touches = [Nvm], catches = [StoreGroupIgnored], cct = "8.6")]
fn application_only(bench: &mut Bench<'_>) -> Judged {
    group_only(bench, 3)
}

fn group_only(bench: &mut Bench<'_>, sub: u8) -> Judged {
    let object = Multiplexer::new(0x1010, sub);
    if !bench.has(object)? {
        let reason = Reason::new("the group can be stored alone", object.to_string(), "absent");
        return Err(Stop::NotApplicable(reason));
    }
    let two = two(bench)?;
    if sub == 3 && two.application.multiplexer.index.0 < 0x6000 {
        let actual = format!("{} belongs to the manufacturer", two.application.multiplexer);
        let reason = Reason::new("an object of the device profile can be written", "6000h and above", actual);
        return Err(Stop::NotApplicable(reason));
    }
    let [communication, application] = after_store(bench, &two, sub)?;
    if sub == 2 {
        bench.check(stored(&two.communication, &communication))?;
        bench.check(lost(&two.application, &application))
    } else {
        bench.check(stored(&two.application, &application))?;
        bench.check(lost(&two.communication, &communication))
    }
}

/// A reset right after the confirmation of "save" leaves either all old or all new values.
#[case(id = "301/store/reset-at-once", clause = "CiA 301 7.5.2.13", confidence = Derived, level = Must,
       needs = [Store, ScratchObject, ApplicationParameter], touches = [Nvm], catches = [StoreTornByReset])]
fn reset_at_once(bench: &mut Bench<'_>) -> Judged {
    use canvass_analyzer::wire::sdo::Request;
    let two = two(bench)?;
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
    bench.check(demand(is_new[0] == is_new[1], || {
        let shown = |new: bool| if new { "new" } else { "old" };
        let actual =
            format!("{} {}, {} {}", objects[0].multiplexer, shown(is_new[0]), objects[1].multiplexer, shown(is_new[1]));
        Reason::new("a reset while parameters are stored leaves a whole image", "all old or all new", actual)
    }))
}

/// "load" and a reset bring the defaults back.
#[case(id = "301/restore/defaults", clause = "CiA 301 7.5.2.14", confidence = Derived, level = Must,
       needs = [Store, ScratchObject], touches = [Nvm, FactoryDefaults], catches = [RestoreWithoutEffect], cct = "8.8")]
fn defaults(bench: &mut Bench<'_>) -> Judged {
    restores(bench)?;
    let scratch = bench.scratch(&[2, 1, 4])?;
    bench.write(scratch.multiplexer, &scratch.other)?;
    bench.write(STORE, b"save")?;
    bench.download(RESTORE, b"load")?.expect_confirmation()?;
    // The memory takes its time; a reset while it is written would undo the order.
    bench.listen(canvass_traces::Duration::from_millis(200))?;
    bench.reset(Command::RESET_NODE)?;
    let now = bench.read(scratch.multiplexer)?;
    bench.write(scratch.multiplexer, &scratch.value)?;
    bench.write(STORE, b"save")?;
    bench.check(demand(now != scratch.other, || {
        let duty = format!("{} has its default after \"load\" and reset node", scratch.multiplexer);
        Reason::new(duty, "another value than was stored", Bytes(&now).to_string())
    }))
}

/// Not applicable where defaults can't be restored.
fn restores(bench: &mut Bench<'_>) -> Result<(), Stop> {
    if bench.has(RESTORE)? {
        return Ok(());
    }
    Err(Stop::NotApplicable(Reason::new("defaults can be restored", "1011h:01", "the device has no 1011h:01")))
}

/// A device whose 1010h:01 says that it does not store on command (bit 0 is 0) refuses "save".
#[case(id = "301/store/not-supported", clause = "CiA 301 7.5.2.13", confidence = Derived, level = Must,
       needs = [Store], touches = [Nvm], catches = [StoreCapabilityDenied])]
fn not_supported(bench: &mut Bench<'_>) -> Judged {
    let value = bench.read_number(STORE)?;
    if value & 1 != 0 {
        let reason =
            Reason::new("the device does not store on command", "bit 0 of 1010h:01 clear", format!("{value:08X}h"));
        return Err(Stop::NotApplicable(reason));
    }
    let mut attempt = bench.download(STORE, b"save")?;
    attempt.what = "\"save\" to a device that does not store on command".to_owned();
    let strict = [
        AbortCode::NOT_TRANSFERRED,
        AbortCode::LOCAL_CONTROL,
        AbortCode::DEVICE_STATE,
        AbortCode::READ_ONLY,
        AbortCode::UNSUPPORTED_ACCESS,
    ];
    bench.check(attempt.refused_with(&strict, &[AbortCode::GENERAL]))
}

/// "save" in operational is carried out, or refused with abort 0800 0022h. Which of the two is noted.
#[case(id = "301/store/operational", clause = "CiA 301 7.5.2.13", confidence = Derived, level = Should,
       needs = [Store], touches = [Nvm], catches = [StoreSilentWhenOperational, SdoSilentWhenOperational])]
fn operational(bench: &mut Bench<'_>) -> Judged {
    bench.command(Command::START)?;
    bench.listen(bench.timing().reaction)?;
    let mut attempt = bench.download(STORE, b"save")?;
    attempt.what = "\"save\" in operational".to_owned();
    bench.note(format!("\"save\" in operational: {}", attempt.outcome));
    bench.listen(canvass_traces::Duration::from_millis(100))?;
    match attempt.abort() {
        Some(_) => bench.check(attempt.refused(Situation::OverflowWhilePeriod)),
        None => bench.check(attempt.expect_confirmation()),
    }
}
