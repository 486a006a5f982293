//! Storing the configuration of LSS (CiA 305, 6.4.5).

use super::dialogue::{configure, exchange, expect_error, expect_plain, set_node_id, wait};
use super::node_id::{boots, started_elsewhere, vacant};
use crate::bench::Bench;
use crate::case;
use crate::cases::layer_setting::expect_dialogue;
use crate::verdict::{Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::wire::lss::{ConfigureCommand, Lss, Request, Response};
use canvass_analyzer::wire::nmt::Command;

/// Stores the node-ID; makes the case not applicable if the device does not store.
fn store(bench: &mut Bench<'_>) -> Result<(), Stop> {
    let answer = exchange(bench, Request::StoreConfiguration)?;
    bench.listen(bench.timing().silence)?;
    match answer {
        Some(Response::Configured { command: ConfigureCommand::Store, error: 1, .. }) => {
            let duty = "the device can store its LSS configuration";
            Err(Stop::NotApplicable(Reason::new(duty, "error code 0", "error code 1: it does not support storing")))
        }
        // Another case judges a missing confirmation.
        None => Ok(()),
        answer => expect_error("store configuration", ConfigureCommand::Store, &[0], answer).or_inconclusive(),
    }
}

/// A stored node-ID takes effect at reset node. The case stores the old node-ID again afterwards.
#[case(id = "305/store/persists", clause = "CiA 305 6.4.5", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId, Nvm], catches = [LssStoreNotPersistent, NmtResetNodeKeepsParameters, NmtBroadcastIgnored])]
fn persists(bench: &mut Bench<'_>) -> Judged {
    let (own, other) = (bench.node().raw(), vacant(bench)?);
    configure(bench)?;
    set_node_id(bench, other)?;
    if let Err(stop) = store(bench) {
        set_node_id(bench, own)?;
        wait(bench)?;
        expect_dialogue::<Lss>(bench)?;
        return Err(stop);
    }
    wait(bench)?;
    bench.watch_restart();
    bench.command_all(Command::RESET_NODE)?;
    boots(bench, other)?;
    // Only a second reset distinguishes the stored value from the pending one.
    bench.command_all(Command::RESET_NODE)?;
    let booted = boots(bench, other)?;
    let duty = "a node-ID that was stored is used after reset node";
    bench.check(demand(booted == Some(other), || started_elsewhere(duty, other, booted)))?;
    bench.uncancelled(|bench| {
        configure(bench)?;
        set_node_id(bench, own)?;
        store(bench)?;
        wait(bench)?;
        bench.command_all(Command::RESET_NODE)?;
        boots(bench, own)?;
        expect_dialogue::<Lss>(bench)
    })
}

/// The slave answers store configuration with success, "not supported" or a failure of the memory, however long storing
/// takes.
#[case(id = "305/store/answer", clause = "CiA 305 6.4.5", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [Nvm], catches = [LssStoreUnanswered, LssStoreSpecificError])]
fn answer(bench: &mut Bench<'_>) -> Judged {
    configure(bench)?;
    let sent = bench.now();
    let answer = exchange(bench, Request::StoreConfiguration)?;
    if answer.is_some() {
        bench.measure("store configuration of LSS", bench.now().since(sent));
    }
    bench.check(expect_error("store configuration", ConfigureCommand::Store, &[0, 1, 2, 255], answer))?;
    bench.check(expect_plain("store configuration", answer))?;
    bench.listen(bench.timing().silence)?;
    wait(bench)
}
