use super::exchange::{Sender, sender};
use super::series::{Series, Step};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::Message;
use crate::wire::{lmt, lss};
use canvass_macros::rule;

/// two slaves have the same LSS or LMT address
///
/// More than one answer follows a request that identifies a single address: its lowest and highest numbers are equal.
/// Several answers to a range are usual.
///
/// # Why
/// The master can't address one of the slaves alone: both get the same node-ID.
///
/// # What to do
/// Connect the slaves one after the other and read 1018h: the serial numbers of two devices of one type must differ. A
/// device without a serial number reports 0.
#[rule(id = "lss/same-address", severity = Error, rank = Participants, services = [Lss, Lmt])]
struct SameAddress {
    series: Series,
    /// The request that identifies one address, and the answer to it.
    asked: Option<Seen>,
    answer: Option<Seen>,
}

impl Rule for SameAddress {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if sender(context.message()) == Some(Sender::Master) {
            let is_single = self.series.see(context, true) == Step::Complete { is_exact: true };
            (self.asked, self.answer) = (is_single.then(|| context.seen()), None);
            return;
        }
        let is_answer = matches!(
            context.message(),
            Message::LssResponse(lss::Response::Identified) | Message::LmtResponse(lmt::Response::Identified)
        );
        let Some(asked) = self.asked.as_ref().filter(|_| is_answer) else { return };
        if let Some(first) = self.answer.replace(context.seen()) {
            let report = Report::at(context.now()).evidence(asked.evidence());
            sink.report(report.evidence(first.evidence()).evidence(context.evidence()), || {
                "two answers to a request that identifies one address".to_owned()
            });
        }
    }

    fn interrupted(&mut self) {
        self.series.interrupted();
        (self.asked, self.answer) = (None, None);
    }
}
