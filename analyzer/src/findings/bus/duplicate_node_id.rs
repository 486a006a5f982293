use super::interleaving::Interleaving;
use crate::findings::effect::Effect;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::{Message, Service};
use crate::network::sdo::ChannelIndex;
use crate::object;
use crate::wire::error_control::State;
use crate::wire::sdo::{Request, Response};
use crate::{Multiplexer, NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// Effects of two nodes that answer to one node-ID.
const EFFECTS: &[Effect] = &[Effect::never_on(&["lss/"]), Effect::on_the_rest().of_same_node().if_less_grave()];

/// two devices have the same node-ID
///
/// Messages with one node-ID come from two devices: its heartbeats alternate between two states without any command, or
/// between two intervals; one SDO request gets two different answers, or several requests get the same answer twice; a
/// second boot-up follows the first without a reset while the other device's heartbeat continues; or a constant part of
/// its identity is read with two values, without a boot-up in between. The rule does not count copies of a frame that
/// the interface made, a server that repeats one answer again and again, and answers within ten seconds after the abort
/// of a client, which some servers send.
///
/// # Why
/// Both devices execute and answer every message to this node-ID. Configuring one device overwrites the configuration
/// of the other, and the data of both are mixed on the same CAN-IDs. Frames of both that start at the same moment cause
/// bus errors.
///
/// # What to do
/// Disconnect the devices one by one until the node-ID is silent, and give one of the two devices another node-ID. The
/// usual cause is several devices of the same type with the default node-ID.
#[rule(
    id = "bus/duplicate-node-id",
    severity = Error,
    rank = Loss,
    services = [Heartbeat, BootUp, Nmt, Sdo],
    leads_to = EFFECTS
)]
struct DuplicateNodeId {
    nodes: PerNode<Voice>,
}

/// The latest messages of a node-ID.
#[derive(Default)]
struct Voice {
    interleaving: Interleaving,
    state: Option<State>,
    /// Number of alternations between two states without a command.
    flips: u32,
    /// The second-last state.
    earlier: Option<State>,
    last_boot_up: Option<Timestamp>,
    /// The time of the last heartbeat, and the interval before it.
    beat: Option<(Timestamp, Duration)>,
    /// State, time and interval of the last heartbeat before an unexplained boot-up.
    surviving: Option<(State, Timestamp, Duration)>,
    answer: Option<Answer>,
    /// Number of unanswered requests: a repeated request rightly gets two answers.
    outstanding: u8,
    /// Time of the latest request. A request that is unanswered long after this time gets no answer any more.
    asked: Option<Timestamp>,
    /// Number of requests that got the same answer twice.
    doubles: u32,
    /// Time of the last abort by a client: some servers answer it, so that later answers prove nothing for a while.
    aborted: Option<Timestamp>,
    identity: [Option<u32>; 4],
}

/// The answer to the latest SDO request.
struct Answer {
    channel: ChannelIndex,
    seen: Seen,
    /// Whether the answer was repeated already: a server that repeats itself is no second device.
    repeated: bool,
}

impl Voice {
    /// Number of alternations that prove two devices.
    const FLIPS: u32 = 4;
    /// Number of requests with two equal answers that prove two devices.
    const DOUBLES: u32 = 3;
    /// Requests that are unanswered for this time get no answer any more.
    const FORGOTTEN: Duration = Duration::from_secs(10);

    fn commanded(&mut self) {
        (self.flips, self.state, self.earlier, self.surviving) = (0, None, None, None);
        self.interleaving.restart();
    }
}

impl Rule for DuplicateNodeId {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if let Message::Nmt(nmt) = context.message() {
            if !context.begins_anew() {
                return;
            }
            return self.nodes.named_mut(nmt.node).for_each(|(_, voice)| {
                voice.commanded();
                if nmt.command.is_reset() {
                    voice.last_boot_up = None;
                }
            });
        }
        let Some(node) = context.node() else { return };
        let voice = &mut self.nodes[node];
        match context.message() {
            Message::ErrorControl(message) if context.decoded.service == Service::Heartbeat => {
                voice.heartbeat(message.state, node, context, sink);
            }
            Message::ErrorControl(_) => voice.boot_up(context),
            Message::SdoRequest(Request::Abort(_)) => (voice.answer, voice.aborted) = (None, Some(context.now())),
            Message::SdoRequest(_) | Message::SdoBlockDownload(_) => {
                voice.asked(context.now());
            }
            Message::SdoResponse(response) => voice.answered(*response, node, context, sink),
            _ => {}
        }
    }

    fn interrupted(&mut self) {
        for voice in self.nodes.values_mut() {
            voice.commanded();
            (voice.last_boot_up, voice.answer) = (None, None);
        }
    }
}

impl Voice {
    /// Counts a request. Requests that are unanswered for a long time are no longer expected to be answered.
    fn asked(&mut self, now: Timestamp) {
        if self.asked.replace(now).is_some_and(|before| now.since(before) > Self::FORGOTTEN) {
            self.outstanding = 0;
        }
        self.answer = None;
        self.outstanding = self.outstanding.saturating_add(1);
    }

    fn heartbeat(&mut self, state: State, node: NodeId, context: &Context<'_>, sink: &mut Sink<'_>) {
        let report = Report::at(context.now()).node(node);
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        if let Some((a, b)) = self.interleaving.beat(context.now(), context.scene.slack()) {
            sink.report(report.detail(1), || {
                format!("heartbeats come after {a} and after {b} in turn: two devices, each every {}", a + b)
            });
        }
        if self.state != Some(state) {
            let back = self.earlier == Some(state);
            self.flips = if back { self.flips + 1 } else { 0 };
            (self.earlier, self.state) = (self.state, Some(state));
            if self.flips >= Self::FLIPS
                && let Some(other) = self.earlier
            {
                sink.report(report.detail(2), || {
                    format!("heartbeats show {other} and {state} in turn, without a command in between")
                });
            }
        }
        let interval = self.beat.map(|(last, _)| context.now().since(last));
        self.beat = Some((context.now(), interval.unwrap_or_default()));
        if let Some((before, last, period)) = self.surviving.take()
            && before == state
            && state != State::PRE_OPERATIONAL
            && goes_on(last, period, context.now())
        {
            sink.report(report.detail(3), || {
                format!("a second boot-up, but another heartbeat continues with {state}: a second device has started")
            });
        }
    }

    fn boot_up(&mut self, context: &Context<'_>) {
        // If both boot-ups are within seconds, the first device may still be the same one: the following heartbeats
        // decide.
        let recent = |then: Timestamp| context.now().since(then) <= Duration::from_secs(10);
        let repeated = self.last_boot_up.is_some_and(recent);
        self.last_boot_up = Some(context.now());
        let survivor = self.state.zip(self.beat).map(|(state, (at, period))| (state, at, period));
        self.surviving = survivor.filter(|_| repeated);
        self.beat = None;
        (self.flips, self.earlier, self.state) = (0, None, None);
        self.interleaving.restart();
        // Earlier requests may still be answered: requests and answers wait in queues.
        (self.answer, self.doubles) = (None, 0);
        // The device or its firmware may have been replaced.
        self.identity = [None; 4];
    }

    fn answered(&mut self, response: Response, node: NodeId, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(channel) = context.decoded.channel else { return };
        let first = self.answer.take().filter(|first| first.channel == channel);
        let repeats = first.as_ref().is_some_and(|first| first.seen.record.frame == context.record.frame);
        if let Some(first) = &first {
            self.second_answer(first, response, node, context, sink);
        }
        self.identify(response, node, context, sink);
        self.outstanding = self.outstanding.saturating_sub(1);
        let doubtful = self.aborted.is_some_and(|aborted| context.now().since(aborted) <= Self::FORGOTTEN);
        let is_last = self.outstanding == 0 && self.asked.is_some() && !doubtful;
        self.answer = is_last.then(|| Answer { channel, seen: context.seen(), repeated: repeats });
    }

    /// Handles a further answer to a request that was answered already.
    fn second_answer(
        &mut self,
        first: &Answer,
        response: Response,
        node: NodeId,
        context: &Context<'_>,
        sink: &mut Sink<'_>,
    ) {
        let now = context.now();
        let report = Report::at(now).node(node).evidence(first.seen.evidence()).evidence(context.evidence());
        // A server that gives up a transfer also sends an abort, but later.
        let longest = Duration::from_millis(if matches!(response, Response::Abort(_)) { 100 } else { 1_000 });
        if let Message::SdoResponse(before) = first.seen.decoded.message
            && contradicts(before, response)
            && now.since(first.seen.time()) <= longest
        {
            sink.report(report.detail(4), || "one SDO request got two different answers".to_owned());
        }
        let is_same = first.seen.record.frame == context.record.frame;
        if is_same && !first.repeated && response.multiplexer().is_some() {
            self.doubles += 1;
            if self.doubles >= Self::DOUBLES {
                sink.report(report.detail(10), || {
                    format!("SDO requests get the same answer twice, {} apart", now.since(first.seen.time()))
                });
            }
        }
    }

    /// Vendor-ID, product code, revision and serial number can't change while the node is running.
    fn identify(&mut self, response: Response, node: NodeId, context: &Context<'_>, sink: &mut Sink<'_>) {
        // An answer about another object than the requested one proves nothing about either.
        let Some((sub, value)) = identity(response).filter(|_| context.decoded.violation.is_none()) else { return };
        let Some(known) = self.identity.get_mut(usize::from(sub) - 1) else { return };
        if let Some(before) = known.replace(value).filter(|before| *before != value) {
            let report = Report::at(context.now()).node(node).detail(5 + u64::from(sub));
            sink.report(report.evidence(context.evidence()), || {
                format!("1018h:{sub:02X} was {before:08X}h and is now {value:08X}h: another device")
            });
        }
    }
}

/// A value of the identity object, if one message contains it whole.
fn identity(response: Response) -> Option<(u8, u32)> {
    let Response::InitiateUpload { multiplexer, payload } = response else { return None };
    let sub @ 1..=4 = multiplexer.sub.0 else { return None };
    let value = payload.value()?.first_chunk::<4>()?;
    (multiplexer.index.0 == object::IDENTITY).then(|| (sub, u32::from_le_bytes(*value)))
}

/// Whether a heartbeat comes a whole number of periods after the last one, within a tenth of the period.
fn goes_on(last: Timestamp, period: Duration, now: Timestamp) -> bool {
    let Some(phase) = now.since(last).nanos().checked_rem(period.nanos()) else { return false };
    phase.min(period.nanos() - phase) <= period.nanos() / 10
}

/// Whether two answers to one request, about the same object, contradict each other. After beginning a transfer or
/// confirming a download a server may still abort it.
fn contradicts(a: Response, b: Response) -> bool {
    let ends = match a {
        Response::InitiateUpload { payload, .. } => payload.value().is_some(),
        Response::Abort(_) => true,
        _ => false,
    };
    if !ends && matches!(b, Response::Abort(_)) {
        return false;
    }
    let object = |response: Response| -> Option<Multiplexer> { response.multiplexer() };
    object(a).is_some() && object(a) == object(b) && a != b
}
