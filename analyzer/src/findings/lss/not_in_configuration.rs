use super::exchange::{Sender, is_leave, sender, words};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::Message;
use crate::wire::{lmt, lss};
use canvass_macros::rule;

/// a layer setting is asked of slaves that are not in configuration state
///
/// The master has switched all slaves to waiting (04h 00h), and then activates bit timing (15h) without switching a slave to
/// configuration. No slave answers this request, so nothing else shows the mistake. If a slave answers another request in
/// this state, it has not followed the switch: this is an information. lss/unanswered reports requests without an answer.
///
/// # Why
/// No slave changes its bit rate, while the master may change its own.
///
/// # What to do
/// Activate bit timing before the switch to waiting. Only slaves in configuration state change their bit rate.
#[rule(id = "lss/not-in-configuration", severity = Warning, rank = Detail, services = [Lss, Lmt])]
struct NotInConfiguration {
    /// The request that switched all slaves to waiting, as long as all of them wait.
    left: Option<Seen>,
}

/// Whether a message shows that a slave is in configuration state from now on.
const fn enters(message: &Message) -> bool {
    matches!(
        message,
        Message::LssRequest(lss::Request::SwitchGlobal { mode: 1.. })
            | Message::LmtRequest(lmt::Request::SwitchGlobal { mode: 1.. })
            | Message::LmtRequest(lmt::Request::SwitchSelective { part: lmt::Part::SerialNumber, .. })
            | Message::LssResponse(lss::Response::Switched | lss::Response::Identified)
    )
}

/// Whether only a slave in configuration state sends the answer.
const fn is_of_configuration(message: &Message) -> bool {
    matches!(
        message,
        Message::LssResponse(lss::Response::Configured { .. } | lss::Response::Part { .. } | lss::Response::NodeId(_))
            | Message::LmtResponse(lmt::Response::Configured { .. } | lmt::Response::Part { .. })
    )
}

impl Rule for NotInConfiguration {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let message = context.message();
        if sender(message) == Some(Sender::Master) && is_leave(message) {
            self.left = Some(context.seen());
            return;
        }
        if enters(message) {
            self.left = None;
        }
        let Some(left) = &self.left else { return };
        let report = Report::at(context.now()).evidence(left.evidence()).evidence(context.evidence());
        let activates = matches!(
            message,
            Message::LssRequest(lss::Request::ActivateBitTiming { .. })
                | Message::LmtRequest(lmt::Request::ActivateBitTiming { .. })
        );
        if activates {
            sink.report(report, || format!("\"{}\" after all slaves were switched to waiting", words(message)));
        } else if is_of_configuration(message) {
            sink.report(report.detail(1).severity(Severity::Info), || {
                format!("\"{}\", although all slaves were switched to waiting", words(message))
            });
            self.left = None;
        }
    }

    fn interrupted(&mut self) {
        self.left = None;
    }
}
