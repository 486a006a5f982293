use crate::findings::effect::{Effect, SETTLE};
use crate::findings::facts::{Pending, RequestEvent};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::Message;
use crate::network::Cause;
use crate::network::sdo::ChannelIndex;
use crate::wire::error_control::State;
use crate::wire::sdo::Request;
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::Duration;

/// No client gives up faster than this, so a faster next request comes from a second client.
const TWO_CLIENTS: Duration = Duration::from_millis(5);

/// Effects: reactions of the client.
const EFFECTS: &[Effect] =
    &[Effect::on(&["sdo/aborted", "sdo/retries", "sdo/protocol-violation"]).of_same_node().spanning(SETTLE)];

/// an SDO request gets no answer
///
/// The server does not answer an SDO request within the timeout, or until the client gives up and sends another
/// request. Requests to stopped nodes, which must not answer, are not reported. Requests to several nodes that never
/// send a message count as a scan for nodes, and are not reported, nor are requests before the node's boot-up.
///
/// # Why
/// The client waits for its timeout and then usually aborts; the start-up of the machine is delayed or fails.
///
/// # What to do
/// If the node still sends other messages, its SDO server is busy or hangs. If it sends no message at all, it is
/// switched off or has another node-ID. Two clients on one channel receive each other's answers: give the second client
/// its own channel (1201h).
#[rule(id = "sdo/unanswered", severity = Error, rank = ProcessData, services = [Sdo], leads_to = EFFECTS)]
struct Unanswered {
    /// timeout for an answer
    #[threshold(ms = 2000)]
    wait: Duration,
    /// timeout for an answer for 1010h, 1011h, 1F50h or 1F51h
    #[threshold(ms = 10_000)]
    store: Duration,
    /// number of silent nodes from which requests count as a scan
    #[threshold(count = 4)]
    scan: u64,
    #[from(super::impatient_client::patience)]
    patience: Duration,
    /// The channels whose unanswered request was reported.
    told: Vec<ChannelIndex>,
    /// The abandoned requests with the reason: an answer may still come.
    given_up: Vec<(ChannelIndex, Pending, String)>,
    /// The first request to each node that has not sent any message yet.
    absent: PerNode<Option<Box<(Seen, String)>>>,
}

/// Reports a request, or keeps it if the node may not exist at all.
fn tell(
    absent: &mut PerNode<Option<Box<(Seen, String)>>>,
    pending: &Pending,
    why: &str,
    scene: &Scene<'_>,
    sink: &mut Sink<'_>,
) {
    let Some(node) = pending.request.decoded.node else { return };
    // A node that is stopped, by command or by its own heartbeat, must not answer.
    let state = scene.bus.node(node).and_then(|node| node.state);
    if matches!(state, Some((State::STOPPED, Cause::Command | Cause::ErrorControl))) {
        return;
    }
    if scene.was_asked_too_early(pending) {
        return;
    }
    let message = format!("no answer to the request{}: {why}", pending.about());
    if scene.facts.node(node).first_seen.is_none() {
        absent[node].get_or_insert_with(|| Box::new((pending.request.clone(), message)));
        return;
    }
    let asked = pending.request.time();
    let lives = scene.facts.node(node).last_seen.is_some_and(|seen| seen > asked);
    let also =
        if lives { "; the node still sends other messages" } else { "; nor did the node send anything else since" };
    let report = Report::at(asked).node(node).detail(pending.detail()).object(pending.object);
    sink.report(report.evidence(pending.request.evidence()), || format!("{message}{also}"));
}

/// Whether a message on the client's CAN-ID looks like the server's answer to a read request: a read request has no
/// bits set after its command specifier.
pub(super) fn is_misplaced_answer(pending: &Pending, context: &Context<'_>) -> bool {
    const SPECIFIER: u8 = 0xE0;
    let reads = |message: &Message| matches!(message, Message::SdoRequest(Request::InitiateUpload { .. }));
    let has_size = context.record.frame.data().first().is_some_and(|command| command & !SPECIFIER != 0);
    let same = pending.object.is_some() && pending.object == context.decoded.object;
    same && has_size && reads(context.message()) && reads(&pending.request.decoded.message)
}

impl Unanswered {
    /// Maximum number of abandoned requests whose answers are awaited.
    const MOST: usize = 64;

    /// Handles an abandoned request; another rule reports clients that give up at once.
    fn give_up(&mut self, pending: &Pending, context: &Context<'_>, sink: &mut Sink<'_>) {
        let waited = context.now().since(pending.request.time());
        let aborts = matches!(context.message(), Message::SdoRequest(Request::Abort(_)));
        if aborts && waited < self.patience {
            return;
        }
        if is_misplaced_answer(pending, context) {
            let why =
                format!("a message that looks like the answer followed on the request's own CAN-ID after {waited}");
            return tell(&mut self.absent, pending, &why, context.scene, sink);
        }
        if waited < TWO_CLIENTS && !aborts {
            let why = format!("another one followed after {waited}, as if two clients used this channel");
            return tell(&mut self.absent, pending, &why, context.scene, sink);
        }
        let why = format!("the client gave up after {waited}");
        let Some(channel) = context.decoded.channel else { return };
        if self.given_up.len() >= Self::MOST {
            self.tell_given_up(None, context.scene, sink);
        }
        self.given_up.push((channel, pending.clone(), why));
    }

    /// Reports the requests that were abandoned at least `wait` ago; without `wait`, all.
    fn tell_given_up(&mut self, wait: Option<Duration>, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let due = |pending: &Pending| wait.is_none_or(|wait| scene.now.since(pending.request.time()) > wait);
        for (_, pending, why) in self.given_up.extract_if(.., |row| due(&row.1)) {
            tell(&mut self.absent, &pending, &why, scene, sink);
        }
    }
}

impl Rule for Unanswered {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let request = &context.news().request;
        if matches!(request, RequestEvent::Repeated) {
            return;
        }
        let channel = context.decoded.channel;
        let told = self.told.iter().position(|told| Some(*told) == channel);
        let told = told.map(|at| self.told.swap_remove(at));
        match request {
            RequestEvent::GivenUp(pending) if told.is_none() => self.give_up(pending, context, sink),
            RequestEvent::AnsweredLate { pending, .. } => {
                let answered = |row: &(ChannelIndex, Pending, String)| {
                    Some(row.0) == channel && row.1.request.time() == pending.request.time()
                };
                self.given_up.retain(|row| !answered(row));
            }
            _ => {}
        }
    }

    fn tick(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        if !self.given_up.is_empty() {
            self.tell_given_up(Some(self.wait), scene, sink);
        }
        for (channel, pending) in scene.facts.requests.open() {
            let limit = if pending.is_store() { self.store } else { self.wait };
            // The time counts from the first of repeated requests.
            let late = scene.now.since(pending.request.time()) > limit + scene.slack();
            if late && !self.told.contains(&channel) {
                self.told.push(channel);
                tell(&mut self.absent, pending, &format!("nothing came within {limit}"), scene, sink);
            }
        }
    }

    fn interrupted(&mut self) {
        self.told.clear();
        self.given_up.clear();
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        self.tell_given_up(None, scene, sink);
        // At the end of the capture half of the timeout suffices for a report.
        for (channel, pending) in scene.facts.requests.open() {
            let limit = if pending.is_store() { self.store } else { self.wait };
            let waited = scene.now.since(pending.request.time());
            if waited.times(4) > limit && !self.told.contains(&channel) {
                let why = format!("nothing came in the {waited} until the capture ends");
                tell(&mut self.absent, pending, &why, scene, sink);
            }
        }
        let silent = |node: NodeId| scene.facts.node(node).first_seen.is_none();
        let asked = self.absent.iter().filter(|(node, request)| request.is_some() && silent(*node)).count();
        let is_scan = asked as u64 >= self.scan;
        for (node, request) in self.absent.iter_mut() {
            let Some((request, message)) = request.take().map(|absent| *absent) else { continue };
            let facts = scene.facts.node(node);
            let first = facts.first_seen;
            // The rule sdo/too-early reports requests to a node that has not booted yet.
            if first.is_none() && is_scan || first.is_some() && first == facts.first_boot_up {
                continue;
            }
            let report = Report::at(request.time()).node(node).evidence(request.evidence());
            sink.report(report, || match first {
                None => format!("{message}; the node never sends anything"),
                Some(first) => {
                    let later = first.since(request.time());
                    format!("{message}; the node sends its first message {later} after the request")
                }
            });
        }
    }
}
