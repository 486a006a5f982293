//! Who is on the bus: whether the device is still there, as one that was switched off fails nothing, and who else is.

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

/// A device that is gone is looked for this long before each case, so that a run still comes to its end.
const LOOK: Duration = Duration::from_millis(250);

impl Bench<'_> {
    /// Whether the device has left the bus during a case: it neither answers, nor starts when it is reset.
    /// `regain` gives a device its node-ID again that has lost it, where the user allows that.
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

    /// Switches the supply of the device off and on by the user's own command. Says whether there is one.
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

    /// Whether the device is the only one on the bus, or the user allows that others are commanded too.
    ///
    /// # Errors
    /// As [`Bench::wait_for`].
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

    /// The other nodes that were heard since the start of the run.
    pub(crate) fn others(&self) -> &BTreeSet<NodeId> {
        self.traffic.watch.others()
    }

    /// Says that the device under test is given that node-ID: a node that uses it is not another one. 255, no node-ID, says
    /// nothing.
    pub(crate) fn gives_node_id(&mut self, node_id: u8) {
        if let Some(node) = NodeId::new(node_id) {
            self.traffic.watch.add_given(node);
        }
    }

    /// Looks for other nodes, once in a run: those that send no heartbeats show themselves by their SDO servers. Reading
    /// changes nothing in them.
    ///
    /// # Errors
    /// As [`Bench::wait_for`].
    pub(crate) fn look_for_others(&mut self) -> Result<(), Stop> {
        if std::mem::replace(&mut self.knowledge.others_known, true) {
            return Ok(());
        }
        let request = Request::upload(Multiplexer::new(object::DEVICE_TYPE, 0));
        let own = self.node();
        let others: Vec<NodeId> = NodeId::all().filter(|node| *node != own).collect();
        // As many at a time as the queues of interfaces hold.
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

    /// Which of these nodes answer an SDO request within that time.
    fn hear_answers(&mut self, of: &[NodeId], span: Duration, answering: &mut Vec<NodeId>) -> Result<(), Stop> {
        self.wait_for(span, |record| {
            let cob_id = record.frame.cob_id().filter(|_| Response::read(record.data()).is_ok())?;
            let node = of.iter().find(|node| cob_id == sdo::RESPONSE_BASE + u16::from(node.raw()));
            answering.extend(node.copied());
            None::<()>
        })
        .map(|_| ())
    }

    /// Whether nobody was heard at that node-ID.
    pub fn is_vacant(&self, node: u8) -> bool {
        NodeId::new(node).is_some_and(|node| !self.traffic.watch.others().contains(&node))
    }

    /// Looks for a device that had left; where the user has given a command that switches it off and on, that is tried
    /// first.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if it is still away.
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

/// A command of the user's, for the shell that the user types it into.
fn shell(command: &str) -> std::process::Command {
    #[cfg(windows)]
    {
        use std::os::windows::process::CommandExt;
        // With /S it takes off these two quotation marks, and leaves those in the command alone.
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

    /// Node 64 sends nothing by itself, but answers: `640#40..` is asked and `5C0#43..` said.
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
