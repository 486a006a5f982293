//! CiA 305: layer setting services. All of them address every LSS slave on the bus, so the device must be alone.

mod configuration;
mod crowd;
mod dialogue;
mod fastscan;
mod identify;
pub(crate) mod needs;
mod switch;

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::wire::lss::{ConfigureCommand, Part, Request, Response};
use dialogue::{configure, exchange, shown};

/// In waiting the slave answers no inquiry; in configuration it does.
#[case(id = "305/waiting/inquiries", clause = "CiA 305 6.5", confidence = Attested, level = Must,
       needs = [Lss, Alone], catches = [LssAnsweredWhileWaiting])]
fn inquiries(bench: &mut Bench<'_>) -> Judged {
    for request in Part::ALL.map(|part| Request::Inquire { part }).into_iter().chain([Request::InquireNodeId]) {
        let response = exchange(bench, request)?;
        demand(response.is_none(), || {
            Reason::new(format!("\"{request}\" is not answered in waiting"), "silence", shown(response))
        })?;
    }
    // Silence means something only if the slave is there.
    configure(bench)?;
    exchange(bench, Request::SwitchGlobal { mode: 0 })?;
    Ok(())
}

/// Node-IDs that don't exist, 0 and 128 to 254, are refused with error code 1.
#[case(id = "305/node-id/invalid", clause = "CiA 305 6.4.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssNodeIdUnchecked])]
fn invalid_node_id(bench: &mut Bench<'_>) -> Judged {
    configure(bench)?;
    let mut wrong = None;
    for node_id in [0, 128, 200, 254] {
        let response = exchange(bench, Request::ConfigureNodeId { node_id })?;
        let refused =
            matches!(response, Some(Response::Configured { command: ConfigureCommand::NodeId, error: 1, .. }));
        if !refused && wrong.is_none() {
            wrong = Some((node_id, shown(response)));
        }
    }
    // What was pending is replaced by the node-ID that the device has, before it can come into force.
    let node_id = bench.node().raw();
    exchange(bench, Request::ConfigureNodeId { node_id })?;
    bench.watch_restart();
    exchange(bench, Request::SwitchGlobal { mode: 0 })?;
    match wrong {
        None => Ok(()),
        Some((node_id, actual)) => {
            Err(Stop::from(Reason::new(format!("node-ID {node_id} is refused"), "error code 1", actual)))
        }
    }
}
