use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::Message;
use crate::wire::flying_master::FlyingMaster;
use canvass_macros::rule;
use canvass_traces::Duration;

/// the negotiation of flying masters goes wrong
///
/// Two masters say on 071h that they are active, without a negotiation between; the priority on 071h is reserved; or a
/// master answers on 074h a detection that nobody has asked for. If nobody answers a detection (075h) and the negotiation
/// goes on nevertheless, the finding is an information: a master without another one needs no negotiation.
///
/// # Why
/// Two active masters command the nodes against each other. A master that is not detected takes no part in the
/// negotiation, and does not take over.
///
/// # What to do
/// Compare 1F90h of all masters: the priorities and the times must fit each other (CiA 302-2).
#[rule(id = "bus/flying-master", severity = Error, rank = Participants, services = [FlyingMaster])]
struct Negotiation {
    /// The request for a detection, until a master answers.
    detection: Option<Seen>,
    /// Whether a detection was asked for.
    is_asked: bool,
    /// The master that was active last, since the last negotiation.
    active: Option<(u8, Seen)>,
    began: bool,
}

/// The lowest priority of a master; higher values are reserved.
const LOWEST_PRIORITY: u8 = 2;

impl Negotiation {
    fn active(&mut self, (priority, node): (u8, u8), context: &Context<'_>, sink: &mut Sink<'_>) {
        if priority > LOWEST_PRIORITY {
            let report = Report::at(context.now()).detail(1).severity(Severity::Warning);
            sink.report(report.evidence(context.evidence()), || format!("the priority {priority} on 071h is reserved"));
        }
        let before = self.active.replace((node, context.seen()));
        if let Some((other, seen)) = before.filter(|(other, _)| *other != node) {
            let report = Report::at(context.now()).evidence(seen.evidence()).evidence(context.evidence());
            sink.report(report, || {
                format!("node {other} and node {node} both say on 071h that they are the active master")
            });
        }
    }

    /// The negotiation goes on after a detection, or another detection begins.
    fn goes_on(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(asked) = self.detection.take() else { return };
        let report = Report::at(asked.time()).detail(2).severity(Severity::Info);
        sink.report(report.evidence(asked.evidence()).evidence(context.evidence()), || {
            "no device answers the master detection on 075h, and the negotiation goes on".to_owned()
        });
    }

    fn detected(&mut self, is_early: bool, context: &Context<'_>, sink: &mut Sink<'_>) {
        self.detection = None;
        if !self.is_asked && !is_early {
            let report = Report::at(context.now()).detail(3).severity(Severity::Warning);
            sink.report(report.evidence(context.evidence()), || {
                "a master answers on 074h, but no detection was asked for on 075h".to_owned()
            });
        }
    }
}

impl Rule for Negotiation {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Message::FlyingMaster(message) = *context.message() else { return };
        let began = std::mem::replace(&mut self.began, true);
        let is_early = !began && context.now().since(context.scene.start) < Duration::from_secs(1);
        match message {
            FlyingMaster::ActiveMaster { priority, node } => self.active((priority, node), context, sink),
            FlyingMaster::MasterDetected => self.detected(is_early, context, sink),
            FlyingMaster::MasterDetectionRequest => {
                self.goes_on(context, sink);
                (self.detection, self.is_asked) = (Some(context.seen()), true);
            }
            FlyingMaster::ActiveMasterRequest => self.goes_on(context, sink),
            FlyingMaster::NegotiationRequest | FlyingMaster::ForceNegotiation => {
                self.goes_on(context, sink);
                self.active = None;
            }
        }
    }

    fn interrupted(&mut self) {
        // The request for a detection may be missing.
        (self.detection, self.is_asked, self.active) = (None, true, None);
    }
}
