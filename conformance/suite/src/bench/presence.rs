//! The nodes on the bus: whether the device under test is still there, and which other nodes there are. A device that
//! was switched off fails no case.

use super::{Bench, Met};
use crate::touch::Touch;
use crate::verdict::{Reason, Stop};
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::{self, Request, Response};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::Duration;
use std::collections::BTreeSet;

/// Time for which, before each case, the tester looks for a device that has left. It is short, so that a run still
/// comes to its end.
const LOOK: Duration = Duration::from_millis(250);

impl Bench<'_> {
    /// Whether the device has left the bus during a case: it neither answers nor starts when it is reset. `regain`
    /// restores the node-ID of a device that has lost it, if the user allows that.
    pub(crate) fn has_left(&mut self, case: &'static str, regain: impl FnOnce(&mut Self)) -> bool {
        if self.knowledge.gone.is_some() {
            return false;
        }
        let there = self.uncancelled(|bench| {
            bench.is_there() || {
                regain(bench);
                bench.is_there()
            }
        });
        self.knowledge.gone = (!there).then_some(case);
        !there
    }

    fn is_there(&mut self) -> bool {
        matches!(self.answers(), Ok(true)) || self.reset(Command::RESET_NODE).is_ok()
    }

    /// Switches the supply of the device off and on with the user's own command. Returns whether there is such a
    /// command.
    ///
    /// # Errors
    /// [`Stop::Error`] if the command can't be run or fails.
    pub(crate) fn power_cycle(&mut self) -> Result<bool, Stop> {
        let Some(command) = &self.options.power_cycle else { return Ok(false) };
        let failed = |actual: String| {
            Stop::Error(Reason::new("the user's command switches the device off and on", "status 0", actual))
        };
        let status = shell(command).status();
        let status = status.map_err(|error| failed(error.to_string()))?;
        if !status.success() {
            return Err(failed(status.to_string()));
        }
        self.traffic.watch.expect_boot_up();
        self.wait_for_boot_up()?;
        Ok(true)
    }

    /// Whether the device is alone on the bus, or the user allows commands to other nodes.
    ///
    /// # Errors
    /// The errors of [`Bench::wait_for`].
    pub(crate) fn is_alone(&mut self) -> Result<Met, Stop> {
        if self.options.allow.contains(&Touch::OtherNodes) {
            return Ok(Ok(()));
        }
        self.look_for_others()?;
        Ok(match self.traffic.watch.others().first() {
            None => Ok(()),
            Some(other) => Err(format!("node {other} is on this bus too, and commanding other nodes is not allowed")),
        })
    }

    /// The other nodes heard since the start of the run.
    pub(crate) fn others(&self) -> &BTreeSet<NodeId> {
        self.traffic.watch.others()
    }

    /// Declares that the device under test may get this node-ID: a node that uses it is not another node. 255 means no
    /// node-ID and has no effect.
    pub(crate) fn gives_node_id(&mut self, node_id: u8) {
        if let Some(node) = NodeId::new(node_id) {
            self.traffic.watch.add_given(node);
        }
    }

    /// Looks for other nodes, once in a run: nodes without heartbeats are found by the answers of their SDO servers.
    /// Reading changes nothing in them.
    ///
    /// # Errors
    /// The errors of [`Bench::wait_for`].
    pub(crate) fn look_for_others(&mut self) -> Result<(), Stop> {
        if std::mem::replace(&mut self.knowledge.others_known, true) {
            return Ok(());
        }
        let request = Request::upload(Multiplexer::new(object::DEVICE_TYPE, 0));
        let own = self.node();
        let others: Vec<NodeId> = NodeId::all().filter(|node| *node != own).collect();
        // The transmit queue of an interface holds at least eight frames.
        let mut answering = Vec::new();
        for some in others.chunks(8) {
            for node in some {
                self.send(&request.to_frame(sdo::REQUEST_BASE + u16::from(node.raw())))?;
            }
            self.hear_answers(&others, Duration::from_millis(20), &mut answering)?;
        }
        self.hear_answers(&others, self.timing().silence, &mut answering)?;
        for node in answering {
            self.traffic.watch.add_other(node);
        }
        Ok(())
    }

    /// Adds the nodes that answer an SDO request within `span`.
    fn hear_answers(&mut self, of: &[NodeId], span: Duration, answering: &mut Vec<NodeId>) -> Result<(), Stop> {
        self.wait_for(span, |record| {
            let cob_id = record.frame.cob_id().filter(|_| Response::read(record.data()).is_ok())?;
            let node = of.iter().find(|node| cob_id == sdo::RESPONSE_BASE + u16::from(node.raw()));
            answering.extend(node.copied());
            None::<()>
        })
        .map(|_| ())
    }

    /// Whether no node with this node-ID was heard.
    pub(crate) fn is_vacant(&self, node: u8) -> bool {
        NodeId::new(node).is_some_and(|node| !self.traffic.watch.others().contains(&node))
    }

    /// Looks for a device that has left. If the user has given a command that switches the device off and on, that
    /// command runs first.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device is still away.
    pub(crate) fn look_for_it(&mut self) -> Result<(), Stop> {
        let Some(case) = self.knowledge.gone else { return Ok(()) };
        if self.power_cycle()? && self.is_there() {
            self.knowledge.gone = None;
            return Ok(());
        }
        let node = self.node();
        let request = Request::upload(Multiplexer::new(object::DEVICE_TYPE, 0));
        self.send_request(&request)?;
        let sign = self
            .wait_for(LOOK.max(self.silence()), |record| super::traffic::is_from(node, &record.frame).then_some(()))?;
        match sign {
            Some(()) => {
                self.knowledge.gone = None;
                Ok(())
            }
            None => {
                let actual = format!("it stopped answering during {case}");
                Err(Stop::Inconclusive(Reason::new("the device is on the bus", "a sign of the device", actual)))
            }
        }
    }
}

/// A command of the user, run by the shell in which the user would type it.
fn shell(command: &str) -> std::process::Command {
    #[cfg(windows)]
    {
        use std::os::windows::process::CommandExt;
        // With /S, `cmd` removes these two quotation marks and keeps those inside the command.
        let mut shell = std::process::Command::new("cmd");
        shell.args(["/D", "/S", "/C"]).raw_arg(format!("\"{command}\""));
        shell
    }
    #[cfg(not(windows))]
    {
        let mut shell = std::process::Command::new("sh");
        shell.arg("-c").arg(command);
        shell
    }
}

#[cfg(test)]
mod tests {
    use crate::scripted::{table, with_bench};

    /// Node 64 sends nothing by itself, but answers the request `640#40..` with `5C0#43..`.
    const SILENT_NEIGHBOUR: &[(&str, &str)] = &[("640#4000100000000000", "5C0#4300100096010200")];

    #[test]
    fn a_silent_neighbour_is_not_commanded() {
        let (alone, vacant) =
            with_bench(table(SILENT_NEIGHBOUR), |bench| (bench.is_alone().unwrap(), bench.vacant_neighbour()));
        assert!(alone.is_err_and(|why| why.contains("node 64")));
        assert_eq!(vacant, Some(62));
    }

    #[test]
    fn without_an_answer_nobody_is_there() {
        assert_eq!(with_bench(table(&[]), |bench| bench.is_alone().unwrap()), Ok(()));
    }
}
