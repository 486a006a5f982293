//! The sub-indexes of 1010h and 1011h one by one (CiA 301, 7.5.2.13 and 7.5.2.14): each needs its signature, shows its
//! abilities, and restores only its own group.

use super::store::{Two, not_by_itself, of_the_profile, restarted, restores, two};
use crate::bench::Bench;
use crate::bench::objects::Scratch;
use crate::bench::sdo::number;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Check, Judged, Reason, Stop, demand, tried};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::Outcome;
use canvass_bus::observation::Observation;
use canvass_traces::Duration;

const STORE: Multiplexer = Multiplexer::new(object::STORE_PARAMETERS, 1);
/// Bits of the values of 1010h: the device stores on command, or autonomously. 1011h has only the first.
const COMMAND: u32 = 1 << 0;
const AUTO: u32 = 1 << 1;
/// Writing the memory takes time; a reset during that time would undo the command.
const WRITTEN: Duration = Duration::from_millis(200);

/// The sub-indexes of 1010h or 1011h that the device has, up to 7Fh: 80h to FEh are reserved.
fn sub_indexes(bench: &mut Bench<'_>, index: u16) -> Result<Vec<Multiplexer>, Stop> {
    let Outcome::Uploaded(highest) = bench.upload(Multiplexer::new(index, 0))?.outcome else { return Ok(Vec::new()) };
    let mut found = Vec::new();
    for sub in 1..=highest.first().copied().unwrap_or_default().min(0x7F) {
        let at = Multiplexer::new(index, sub);
        if bench.has(at)? {
            found.push(at);
        }
    }
    Ok(found)
}

/// Each sub-index of 1010h refuses any signature but "save".
#[case(id = "301/store/every-signature", clause = "CiA 301 7.5.2.13", confidence = Cited, level = Must,
       needs = [Store], touches = [Nvm], catches = [StoreSignatureFirstOnly, StoreSignatureUnchecked], cct = "8.3",
       answers = [WrongSignature])]
fn every_store_signature(bench: &mut Bench<'_>) -> Judged {
    every_signature(bench, object::STORE_PARAMETERS, [*b"evas", *b"SAVE", *b"load", [0; 4], [1, 0, 0, 0]])
}

/// Each sub-index of 1011h refuses any signature but "load".
#[case(id = "301/restore/every-signature", clause = "CiA 301 7.5.2.14", confidence = Cited, level = Must,
       needs = [Store], touches = [Nvm, FactoryDefaults], catches = [StoreSignatureFirstOnly, RestoreSignatureUnchecked],
       cct = "8.3", answers = [WrongSignature])]
fn every_restore_signature(bench: &mut Bench<'_>) -> Judged {
    restores(bench)?;
    every_signature(bench, object::RESTORE_DEFAULT_PARAMETERS, [*b"daol", *b"LOAD", *b"save", [0; 4], [1, 0, 0, 0]])
}

fn every_signature(bench: &mut Bench<'_>, index: u16, wrong: [[u8; 4]; 5]) -> Judged {
    let objects = sub_indexes(bench, index)?;
    let mut asked = 0;
    bench.each(objects, |bench, at| {
        if !bench.can_write(at)? {
            return Ok(());
        }
        asked += 1;
        bench.each(wrong, |bench, signature| {
            let attempt = bench.download(at, &signature)?;
            bench.check(attempt.refused(Situation::WrongSignature))
        })
    })?;
    tried(asked, "a sub-index that sub-index 0 counts and that can be written")
}

/// Each sub-index of 1010h and 1011h is an UNSIGNED32 that tells its capability: on command in bit 0, and for 1010h
/// also by itself in bit 1. All other bits are 0.
#[case(id = "301/store/every-capability", clause = "CiA 301 7.5.2.14", confidence = Cited, level = Must,
       needs = [StoreObject], catches = [RestoreCapabilityWrong, StoreCapabilityWrong], cct = "8.1")]
fn every_capability(bench: &mut Bench<'_>) -> Judged {
    let mut objects = sub_indexes(bench, object::STORE_PARAMETERS)?;
    objects.extend(sub_indexes(bench, object::RESTORE_DEFAULT_PARAMETERS)?);
    tried(objects.len(), "a sub-index that sub-index 0 counts")?;
    bench.each(objects, |bench, at| {
        let known = if at.index.0 == object::STORE_PARAMETERS { COMMAND | AUTO } else { COMMAND };
        let value = bench.upload(at)?.value()?;
        bench.check(demand(value.len() == 4 && number(&value) & !known == 0, || {
            let expected = if known == COMMAND { "bit 0 only" } else { "bits 0 and 1 only" };
            let duty = "1010h and 1011h tell their capability in an UNSIGNED32";
            Breach::new(at, duty).expected(expected).found(Observation::Value(value))
        }))
    })
}

/// 1011h:02 restores communication parameters, and does not change stored application parameters.
#[case(id = "301/restore/communication-only", clause = "CiA 301 7.5.2.14", confidence = Cited, level = Must,
       needs = [Store, ScratchObject, ApplicationParameter], touches = [Nvm, FactoryDefaults],
       catches = [RestoreGroupIgnored, RestoreWithoutEffect], cct = "8.8")]
fn communication_only(bench: &mut Bench<'_>) -> Judged {
    group_only(bench, 2)
}

/// 1011h:03 restores application parameters, and does not change stored communication parameters.
#[case(id = "301/restore/application-only", clause = "CiA 301 7.5.2.14", confidence = Cited, level = Must,
       needs = [Store, ScratchObject, ApplicationParameter], touches = [Nvm, FactoryDefaults],
       catches = [RestoreGroupIgnored, RestoreWithoutEffect], cct = "8.8")]
fn application_only(bench: &mut Bench<'_>) -> Judged {
    group_only(bench, 3)
}

fn group_only(bench: &mut Bench<'_>, sub: u8) -> Judged {
    let order = Multiplexer::new(object::RESTORE_DEFAULT_PARAMETERS, sub);
    if !bench.has(order)? {
        return Err(Stop::NotApplicable(Reason::new("a group can be restored alone", order.to_string(), "absent")));
    }
    not_by_itself(bench)?;
    let two = two(bench)?;
    of_the_profile(&two.application)?;
    let seen = after_restore(bench, &two, order);
    // The device gets its old values back, whether the check passed or not.
    for scratch in [&two.communication, &two.application] {
        bench.download(scratch.multiplexer, &scratch.value)?;
    }
    bench.write(STORE, b"save")?;
    bench.reset(Command::RESET_NODE)?;
    let (communication, application) = seen?;
    let (restored, kept) = if sub == 2 {
        ((&two.communication, communication), (&two.application, application))
    } else {
        ((&two.application, application), (&two.communication, communication))
    };
    bench.check(is_default(bench, restored.0, &restored.1))?;
    bench.check(is_kept(kept.0, &kept.1))
}

/// Stores both objects with other values, restores the group, and returns both values after the reset.
fn after_restore(bench: &mut Bench<'_>, two: &Two, order: Multiplexer) -> Result<(Vec<u8>, Vec<u8>), Stop> {
    let values = |bench: &mut Bench<'_>| {
        Ok::<_, Stop>((bench.read(two.communication.multiplexer)?, bench.read(two.application.multiplexer)?))
    };
    for scratch in [&two.communication, &two.application] {
        bench.write(scratch.multiplexer, &scratch.other)?;
    }
    bench.write(STORE, b"save")?;
    bench.listen(WRITTEN)?;
    restarted(bench)?;
    if values(bench)? != (two.communication.other.clone(), two.application.other.clone()) {
        let reason = Reason::new("1010h:01 stores both groups", "both values after reset node", "other values");
        return Err(Stop::NotApplicable(reason));
    }
    bench.download(order, b"load")?.expect_confirmation()?;
    bench.listen(WRITTEN)?;
    restarted(bench)?;
    values(bench)
}

/// Requires that the value after the restore is not the stored value, unless the stored value is also the default.
fn is_default(bench: &Bench<'_>, scratch: &Scratch, now: &[u8]) -> Check {
    let description = bench.target().description.as_ref();
    let default = description.and_then(|description| {
        let entry = description.dictionary.entry(scratch.multiplexer).ok()?;
        entry.start_value(bench.node())?.encode(entry.data_type).ok()
    });
    demand(now != scratch.other || default.as_ref() == Some(&scratch.other), || {
        Breach::new(scratch.multiplexer, "a parameter of the restored group has its default after reset node")
            .expected("another value than the stored one")
            .found(Observation::Value(now.to_vec()))
    })
}

fn is_kept(scratch: &Scratch, now: &[u8]) -> Check {
    demand(now == scratch.other, || {
        Breach::new(scratch.multiplexer, "a stored parameter is not restored together with the other group")
            .expected(Observation::Value(scratch.other.clone()))
            .found(Observation::Value(now.to_vec()))
    })
}
