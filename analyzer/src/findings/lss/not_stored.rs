use super::exchange::{Sender, configured, is_leave, sender, words};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::Message;
use crate::wire::layer_setting::ConfigureCommand;
use crate::wire::lss::Request;
use canvass_macros::rule;

/// a node-ID or bit rate was changed and not stored
///
/// An LSS or LMT slave has accepted a new node-ID or bit rate, and is switched back to waiting, or the capture ends,
/// without an answered store. The rule lss/refused reports a refused store. If the master uses Fastscan, the severity
/// is info: such masters assign node-IDs at every start.
///
/// # Why
/// At the next power-on the device has its old node-ID and bit rate again, often after the technician has left.
///
/// # What to do
/// Send store configuration (17h) before switching back to waiting, unless the master sets the node-ID at every start.
#[rule(id = "lss/not-stored", severity = Warning, rank = Detail, services = [Lss, Lmt])]
struct NotStored {
    /// The slave's answers to configurations that are not stored yet: node-ID and bit rate.
    changed: [Option<Seen>; 2],
    /// The latest request.
    request: Option<String>,
    /// The master's requests for node-ID and bit rate.
    asked: [String; 2],
    /// Whether the master looks for slaves without node-ID, to assign a node-ID to them at every start.
    assigns: bool,
}

impl NotStored {
    fn tell(&mut self, sink: &mut Sink<'_>) {
        let [node_id, bit_rate] = std::mem::take(&mut self.changed);
        let Some(first) = node_id.as_ref().or(bit_rate.as_ref()) else { return };
        let report = Report::at(first.time()).evidence(node_id.as_ref().map(Seen::evidence));
        let report = report.evidence(bit_rate.as_ref().map(Seen::evidence));
        let report = if self.assigns { report.severity(Severity::Info) } else { report };
        sink.report(report, || {
            let asked = [&node_id, &bit_rate].into_iter().zip(&self.asked).filter(|row| row.0.is_some());
            let asked: Vec<&str> = asked.map(|row| row.1.as_str()).collect();
            format!("\"{}\" was confirmed but not stored", asked.join("\" and \""))
        });
    }
}

impl Rule for NotStored {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let message = context.message();
        match sender(message) {
            Some(Sender::Master) => {
                self.assigns |= matches!(message, Message::LssRequest(Request::Fastscan { .. }));
                self.request = Some(words(message));
                if is_leave(message) {
                    self.tell(sink);
                }
            }
            Some(Sender::Slave) => match configured(message) {
                // A refusal has a finding of its own.
                Some((ConfigureCommand::Store, _)) => self.changed = [None, None],
                Some((setting @ (ConfigureCommand::NodeId | ConfigureCommand::BitTiming), 0)) => {
                    let at = usize::from(setting == ConfigureCommand::BitTiming);
                    self.changed[at] = Some(context.seen());
                    self.asked[at] = self.request.clone().unwrap_or_else(|| words(message));
                }
                _ => {}
            },
            None => {}
        }
    }

    fn interrupted(&mut self) {
        self.changed = [None, None];
    }

    fn finish(&mut self, _: &Scene<'_>, sink: &mut Sink<'_>) {
        self.tell(sink);
    }
}
