//! Slaves without node-ID: how a slave loses its node-ID, and how it then behaves.

use super::dialogue::{
    address, breach, configure, exchange, expect, expect_configuration, node_id, node_ids, observed, set_node_id,
    shown, tell, wait,
};
use super::node_id::{back_to_own, started_elsewhere};
use crate::bench::{Bench, is_from};
use crate::case;
use crate::cases::layer_setting::RESTART;
use crate::cases::layer_setting::expect_dialogue;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control;
use canvass_analyzer::wire::lss::{self, ConfigureCommand, Lss, Request, Response};
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::Observation;
use canvass_traces::{Duration, Record};

/// The node-ID for "not configured".
const NONE: u8 = 255;

/// Runs `test` while the device has no node-ID; restores its own afterwards, whatever the result.
pub(super) fn unconfigured(bench: &mut Bench<'_>, test: impl FnOnce(&mut Bench<'_>, [u32; 4]) -> Judged) -> Judged {
    let address = address(bench)?;
    configure(bench)?;
    let answer = set_node_id(bench, NONE)?;
    let taken = matches!(answer, Some(Response::Configured { command: ConfigureCommand::NodeId, error: 0, .. }));
    wait(bench)?;
    bench.command_all(Command::RESET_COMMUNICATION)?;
    bench.listen(Duration::from_millis(1_000))?;
    let judged = match taken && is_without(bench)? {
        true => test(bench, address),
        false => Err(Stop::NotApplicable(Reason::new(
            "LSS can remove the node-ID",
            "a device without node-ID",
            "it keeps its node-ID",
        ))),
    };
    // A breach in the case takes precedence over a failure to configure the device after it.
    let configured = bench.uncancelled(back_to_own);
    judged.and(configured)
}

/// Whether the device has no node-ID any more. The tester waits until a slow device has started.
fn is_without(bench: &mut Bench<'_>) -> Result<bool, Stop> {
    let deadline = bench.now() + bench.timing().boot_up;
    while bench.now() < deadline {
        if tell(bench, Request::IdentifyNonConfigured)? == Some(Response::NonConfigured) {
            return Ok(true);
        }
        if bench.answers()? {
            // The device may report that it has no node-ID, but still answer SDOs: one case judges that.
            configure(bench)?;
            let is_without = node_id(bench)? == Some(NONE);
            wait(bench)?;
            return Ok(is_without);
        }
    }
    Ok(true)
}

/// A device without node-ID sends nothing except LSS responses: no boot-up message and no SDO response.
#[case(id = "305/unconfigured/silent", clause = "CiA 305", confidence = Unknown, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [UnconfiguredNodeBoots])]
fn silent(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, _| {
        bench.command_all(Command::RESET_NODE)?;
        let (node, others) = (bench.node(), bench.others().clone());
        // Others may be on the bus. Frames with the device's old node-ID are the device's, and so is the start of an
        // unknown node.
        let heard = bench.wait_for(Duration::from_millis(1_500), |record| {
            let cob_id = record.frame.cob_id()?;
            let is_known = NodeId::of_cob_id(cob_id).is_some_and(|node| others.contains(&node));
            let is_start = cob_id & 0x780 == error_control::CAN_ID_BASE && record.frame.data() == [0] && !is_known;
            (is_start || is_from(node, &record.frame)).then_some(record.frame)
        })?;
        bench.check(heard.map_or(Ok(()), |frame| {
            let breach = breach("a device without node-ID sends nothing after a reset");
            Err(Box::new(breach.expected(Observation::Silence).found(Observation::Frame(frame))))
        }))?;
        let answers = bench.answers()?;
        bench.check(demand(!answers, || {
            let breach = breach("a device without node-ID answers no SDO request");
            breach.expected(Observation::Silence).found(Observation::named("an SDO response"))
        }))
    })
}

/// A device without node-ID answers identify non-configured remote slave with 50h.
#[case(id = "305/unconfigured/identify", clause = "CiA 305 6.6.4", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssIdentifyUnanswered])]
fn identify(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, _| {
        // The first search has already shown that the device has no node-ID.
        for _ in 0..2 {
            let answer = exchange(bench, Request::IdentifyNonConfigured)?;
            let expected = observed(Some(Response::NonConfigured));
            bench.check(expect("the search for slaves without node-ID", expected, answer, |answer| {
                answer == Response::NonConfigured
            }))?;
        }
        expect_dialogue::<Lss>(bench)
    })
}

/// A device that receives its first node-ID by LSS starts with it when it leaves configuration.
#[case(id = "305/unconfigured/boots", clause = "CiA 305 6.4.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [UnconfiguredNodeIdWaits, BootUpMissing, BootUpWrongData])]
fn boots(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, _| {
        let own = bench.node().raw();
        configure(bench)?;
        set_node_id(bench, own)?;
        bench.watch_restart();
        bench.drain()?;
        bench.send(&Request::SwitchGlobal { mode: 0 }.to_frame(lss::MASTER_CAN_ID))?;
        let boot_up = bench.wait_for_boot_up()?;
        bench.check(demand(boot_up.is_some(), || {
            started_elsewhere("a device without node-ID starts with the node-ID that it receives", own, None)
        }))
    })
}

/// A device that has received its first node-ID by LSS stays in configuration, and silent, when it is switched to
/// configuration once more: it starts when it leaves configuration.
#[case(id = "305/unconfigured/told-again", clause = "CiA 305 6.3.2", confidence = Attested, level = Must,
       needs = [Lss, Alone], touches = [NodeId], catches = [LssLeavesWhenToldAgain])]
fn told_again(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, _| {
        let own = bench.node().raw();
        configure(bench)?;
        set_node_id(bench, own)?;
        bench.drain()?;
        let from = bench.now();
        tell(bench, Request::SwitchGlobal { mode: 1 })?;
        bench.listen(RESTART)?;
        let heard = bench.heard_since(from);
        // Another case judges a device that continues with its old node-ID.
        let id = error_control::CAN_ID_BASE + u16::from(own);
        let is_boot_up = |record: &&Record| record.frame.cob_id() == Some(id) && record.data() == [0];
        let early = heard.iter().find(is_boot_up).map(|record| record.frame);
        bench.check(early.map_or(Ok(()), |frame| {
            let breach = breach("a device without node-ID that is switched to configuration again does not start");
            Err(Box::new(breach.expected(Observation::Silence).found(Observation::Frame(frame))))
        }))?;
        expect_configuration(bench, "switch state global to configuration, for the second time")
    })
}

/// The inquiry of the node-ID returns 255 for a device without node-ID.
#[case(id = "305/unconfigured/inquiry", clause = "CiA 305 6.5.3", confidence = Attested, level = Should,
       needs = [Lss, LssInquiry, Alone], touches = [NodeId], catches = [LssNodeIdInquiredWrong])]
fn inquiry(bench: &mut Bench<'_>) -> Judged {
    unconfigured(bench, |bench, _| {
        let begun = bench.now();
        configure(bench)?;
        let given = exchange(bench, Request::InquireNodeId)?;
        wait(bench)?;
        let other = node_ids(bench, begun).into_iter().find(|node| *node != NONE).map(Response::NodeId);
        let is_right = given == Some(Response::NodeId(NONE)) && other.is_none();
        bench.check(demand(is_right, || {
            let breach = breach("a device without node-ID says so").expected(Observation::Number(NONE.into()));
            let found = other.or(given);
            breach.found(observed(found)).told(shown(found))
        }))
    })
}
