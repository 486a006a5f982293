use crate::NodeId;
use crate::findings::effect::Effect;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::{Message, Service};
use crate::object;
use crate::wire::lss::{MASTER_CAN_ID, SLAVE_CAN_ID};
use crate::wire::sdo::Request;
use crate::wire::sync;
use canvass_macros::rule;
use canvass_traces::Duration;

/// Effects: the node's other messages, and those of nodes with less priority, are late or missing.
const EFFECTS: &[Effect] = &[Effect::on_the_rest().of_same_node().if_less_grave()];

/// a frame is repeated without pause
///
/// The same frame comes again and again, with less than three milliseconds between two frames. After a pause of SYNC
/// its messages must come ten times as often, because a producer sends late messages at once. Messages that come
/// regularly, such as PDOs and heartbeats, count only if they came with longer pauses before, and if no command and no
/// SDO download to their node can have changed their period; the severity is then warning. PDOs that follow SYNC do not
/// count, nor does a request that is answered each time: a client may poll.
///
/// # Why
/// The frame takes the bus from all messages with higher CAN-IDs, and its receivers execute it each time.
///
/// # What to do
/// Look at the program of the sender: a transmit request that is not cleared, or an error handler without a pause. A
/// gateway that hears its own frames repeats them as well.
#[rule(
    id = "bus/repeated",
    severity = Error,
    rank = Participants,
    services = [Nmt, BootUp, Heartbeat, Guarding, Sync, Time, Emcy, Pdo, Sdo, Lss, Lmt, Srdo, FlyingMaster],
    leads_to = EFFECTS
)]
struct Repeated {
    /// number of repetitions that is reported
    #[threshold(count = 20, min = 2)]
    most: u64,
    /// a longer pause ends the repetitions
    #[threshold(us = 3000)]
    pause: Duration,
    run: Option<Box<Run>>,
    /// By CAN-ID, the pauses of regular messages; empty before the first one.
    slow: Vec<Pauses>,
    /// The last two longer pauses of SYNC, the later one last.
    sync: [Duration; 2],
}

/// The longer pauses of a regular message.
#[derive(Clone, Copy, Default)]
struct Pauses {
    /// Number of consecutive pauses.
    count: u8,
    /// The node that the message concerns; `None` if the message has none.
    node: Option<NodeId>,
}

/// The messages whose period a frame may change.
enum Changed {
    /// No messages.
    Nothing,
    /// The messages of one node.
    Node(NodeId),
    /// All messages: those that follow SYNC among them.
    All,
}

/// Repetitions of a frame.
struct Run {
    can_id: u16,
    count: u64,
    first: Seen,
}

/// Whether a message of the service comes regularly in a network that works, so that it may also come often.
const fn is_regular(service: Service) -> bool {
    matches!(service, Service::Sync | Service::Pdo | Service::Heartbeat | Service::Guarding | Service::Srdo)
}

/// The CAN-ID of the other side of a dialogue; `None` for messages without one.
const fn other_side(can_id: u16) -> Option<u16> {
    match can_id {
        0x581..=0x5FF => Some(can_id + 0x80),
        0x601..=0x67F => Some(can_id - 0x80),
        MASTER_CAN_ID => Some(SLAVE_CAN_ID),
        SLAVE_CAN_ID => Some(MASTER_CAN_ID),
        _ => None,
    }
}

/// Whether the other side of the dialogue has sent since the previous frame with the same CAN-ID.
fn is_dialogue(can_id: u16, previous: &Seen, context: &Context<'_>) -> bool {
    let other = other_side(can_id).and_then(|other| context.scene.latest.get(other));
    other.is_some_and(|other| other.time() >= previous.time())
}

/// Whether SYNC has come since the previous frame with the same CAN-ID: the producer of SYNC sets the pace of the PDO.
fn follows_sync(previous: &Seen, context: &Context<'_>) -> bool {
    let last = context.scene.latest.get(sync::CAN_ID).filter(|_| context.decoded.service == Service::Pdo);
    last.is_some_and(|last| last.time() >= previous.time())
}

/// The messages whose period the frame may change.
fn changed(context: &Context<'_>) -> Changed {
    if context.begins_anew() {
        return Changed::All;
    }
    let (
        Message::SdoRequest(
            Request::InitiateDownload { multiplexer, .. } | Request::InitiateBlockDownload { multiplexer, .. },
        ),
        Some(node),
    ) = (context.message(), context.node())
    else {
        return Changed::Nothing;
    };
    match multiplexer.index.0 {
        object::COB_ID_SYNC | object::COMMUNICATION_CYCLE_PERIOD => Changed::All,
        _ => Changed::Node(node),
    }
}

impl Repeated {
    /// Number of longer pauses after which frames without pause are not the usual period of a regular message.
    const SELDOM: u8 = 2;
    /// The same number for SYNC.
    const SYNC_SELDOM: u8 = 10;

    /// Notes a pause of a regular message.
    fn paused(&mut self, can_id: u16, pause: Duration, context: &Context<'_>) {
        if context.decoded.service == Service::Sync {
            self.sync = [self.sync[1], pause];
        }
        if self.slow.is_empty() {
            self.slow.resize(0x800, Pauses::default());
        }
        if let Some(slow) = self.slow.get_mut(usize::from(can_id)) {
            *slow = Pauses { count: slow.count.saturating_add(1), node: context.node() };
        }
    }

    /// Forgets the pauses of messages that may have another period now.
    fn forget(&mut self, changed: &Changed) {
        match changed {
            Changed::Nothing => {}
            Changed::Node(node) => {
                self.slow.iter_mut().filter(|slow| slow.node == Some(*node)).for_each(|slow| slow.count = 0);
            }
            Changed::All => self.slow.fill(Pauses::default()),
        }
    }

    /// Begins to count, if the message does not come as often in its usual period.
    #[cold]
    fn begin(&mut self, can_id: u16, previous: &Seen, service: Service, is_regular: bool) {
        let slow = self.slow.get_mut(usize::from(can_id)).map_or(0, |slow| std::mem::take(&mut slow.count));
        // A producer of SYNC may send a few messages before it begins its cycle.
        let seldom = if service == Service::Sync { Self::SYNC_SELDOM } else { Self::SELDOM };
        if !is_regular || slow >= seldom {
            self.run = Some(Box::new(Run { can_id, count: 1, first: previous.clone() }));
        }
    }

    /// Number of repetitions after which the rule reports the message.
    fn most(&self, service: Service) -> u64 {
        let [usual, last] = self.sync;
        // After a regular pause a producer of SYNC has no late messages to send.
        let may_catch_up = service == Service::Sync && last > usual.times(2);
        if may_catch_up { 10 * self.most } else { self.most }
    }

    #[cold]
    fn tell(&self, run: &Run, context: &Context<'_>, sink: &mut Sink<'_>) {
        let service = context.decoded.service;
        let node = context.node().filter(|_| service != Service::Nmt);
        let begin = run.first.time();
        let report = Report::at(begin).until(context.now()).node(node).detail(run.can_id.into()).measure(run.count);
        let report = if is_regular(service) { report.severity(Severity::Warning) } else { report };
        sink.report(report.evidence(run.first.evidence()).evidence(context.evidence()), || {
            let span = context.now().since(begin);
            format!("the same {service} {} times within {span}", run.count + 1)
        });
    }
}

impl Rule for Repeated {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let (Some(previous), Some(can_id)) = (context.previous, context.record.frame.id().as_standard()) else {
            return;
        };
        self.forget(&changed(context));
        let service = context.decoded.service;
        let is_regular = is_regular(service) && *context.message() != Message::GlobalFailSafe;
        let pause = context.now().since(previous.time());
        if pause > self.pause {
            if is_regular {
                self.paused(can_id, pause, context);
            }
            return;
        }
        if previous.record.frame != context.record.frame {
            return;
        }
        if is_dialogue(can_id, previous, context) || follows_sync(previous, context) {
            return;
        }
        let most = self.most(service);
        match self.run.as_deref_mut() {
            Some(run) if run.can_id == can_id && run.first.record.frame == context.record.frame => {
                run.count += 1;
                let is_due = run.count == most || run.count > most && run.count.is_power_of_two();
                if is_due && let Some(run) = self.run.take() {
                    self.tell(&run, context, sink);
                    self.run = Some(run);
                }
            }
            _ => self.begin(can_id, previous, service, is_regular),
        }
    }

    fn interrupted(&mut self) {
        self.run = None;
    }
}
