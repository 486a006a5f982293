use super::exchange::{Sender, answer_to, command, own_command, sender, wants_answer, words};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::Message;
use crate::wire::Fields;
use crate::wire::lss::Response;
use canvass_macros::rule;
use canvass_traces::Duration;

/// an LSS dialogue goes wrong
///
/// An answer on 7E4h belongs to another service than the request before it, comes without a request, or several slaves
/// answer a request to one slave. Identify and Fastscan may have several answers. Or a request is sent on 7E4h: its
/// master uses the wrong CAN-ID. Reserved bytes that are not 0 are an information.
///
/// # Why
/// All slaves in configuration state accept the node-ID and the bit rate that follow, so that two devices get the same
/// node-ID. Other wrong answers make the master configure a slave that does not exist.
///
/// # What to do
/// Switch all slaves to waiting (04h 00h), then address a single slave by the four numbers of its LSS address. Switch
/// all slaves to configuration (04h 01h) only on a bus with one slave.
#[rule(id = "lss/dialogue", severity = Error, rank = Detail, services = [Lss, Lmt])]
struct Dialogue {
    request: Option<Seen>,
    answer: Option<Seen>,
}

/// Whether only a request has this command specifier: switch state, activate bit timing, identify, Fastscan.
const fn is_request(command: u8) -> bool {
    matches!(command, 0x04 | 0x15 | 0x40..=0x43 | 0x46..=0x4C | 0x51)
}

impl Dialogue {
    fn answered(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let message = context.message();
        if matches!(message, Message::LssResponse(Response::Unknown { .. })) && is_request(own_command(context)) {
            let report = Report::at(context.now()).detail(4).evidence(context.evidence());
            return sink.report(report, || {
                let command = own_command(context);
                format!("the request {command:02X}h on 7E4h, the CAN-ID of the slaves: a master sends on 7E5h")
            });
        }
        let Some(request) = &self.request else {
            // The request may have preceded the capture.
            if context.now().since(context.scene.start) > Duration::from_secs(1) {
                let report = Report::at(context.now()).detail(1).evidence(context.evidence());
                sink.report(report, || format!("{}, without a request", words(message)));
            }
            return;
        };
        let report = Report::at(context.now()).evidence(request.evidence());
        if answer_to(command(request)) != Some(own_command(context)) {
            let detail = 2 << 16 | u64::from(command(request)) << 8 | u64::from(own_command(context));
            sink.report(report.detail(detail).evidence(context.evidence()), || {
                format!("\"{}\" answers the request \"{}\"", words(message), words(&request.decoded.message))
            });
            return;
        }
        if let Some(first) = self.answer.replace(context.seen())
            && wants_answer(&request.decoded.message)
        {
            let report = report.detail(3).evidence(first.evidence()).evidence(context.evidence());
            sink.report(report, || {
                let request = words(&request.decoded.message);
                format!("more than one slave answers \"{request}\": several are in configuration state")
            });
        }
    }
}

/// Whether a reserved byte of the message is not 0.
fn has_reserved(context: &Context<'_>) -> bool {
    let layout = match context.message() {
        Message::LssRequest(message) => message.layout(),
        Message::LssResponse(message) => message.layout(),
        Message::LmtRequest(message) => message.layout(),
        Message::LmtResponse(message) => message.layout(),
        _ => return false,
    };
    let payload = context.record.frame.data();
    let reserved = layout.fields.iter().filter(|field| field.is_reserved());
    reserved.filter_map(|field| field.within(payload.len())?.get(payload)).any(|value| value != 0)
}

impl Rule for Dialogue {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if has_reserved(context) {
            let detail = 5 << 16 | u64::from(own_command(context));
            let report = Report::at(context.now()).detail(detail).severity(Severity::Info);
            sink.report(report.evidence(context.evidence()), || {
                format!("reserved bytes after {:02X}h are not 0: {}", own_command(context), words(context.message()))
            });
        }
        match sender(context.message()) {
            Some(Sender::Master) => (self.request, self.answer) = (Some(context.seen()), None),
            Some(Sender::Slave) => self.answered(context, sink),
            None => {}
        }
    }

    fn interrupted(&mut self) {
        (self.request, self.answer) = (None, None);
    }
}
