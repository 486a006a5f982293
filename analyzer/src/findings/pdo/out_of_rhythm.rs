use crate::NodeId;
use crate::findings::facts::{Odd, StreamEvent};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::{Message, PdoNumber};
use canvass_macros::rule;

/// a PDO leaves the rhythm that it has had
///
/// A PDO has had one rhythm for a long time: a period, while its data did not change, or one number of SYNC messages between
/// two frames. Then a frame is left out, comes much too late or comes between two others, and the rhythm goes on. A
/// single event is an information. It is a warning if another frame comes into five periods in a row: then two devices
/// send the PDO. Where the SDO traffic of the capture shows an event timer, a single additional frame or a late one is
/// not reported here: an event may send the PDO, and pdo/period compares it with its timer.
///
/// # Why
/// A consumer works with an old value for a cycle, or with a value that another device has sent.
///
/// # What to do
/// Compare with other PDOs at that time: if they are late too, see the bus load and the recorder. If the data of an
/// additional frame differ from those around it, look for a second sender with this CAN-ID.
#[rule(id = "pdo/out-of-rhythm", severity = Warning, rank = ProcessData, also = UnusualPdos)]
struct OutOfRhythm {
    /// The PDOs with a frame out of step with SYNC, until the next frames show that it was a single one.
    odd: Vec<OutOfStep>,
}

/// A frame out of step with SYNC.
struct OutOfStep {
    pdo: (NodeId, PdoNumber),
    odd: Odd,
    before: Option<Seen>,
    frame: Seen,
}

/// Number of periods with another frame that prove two senders.
const TWO_SENDERS: u8 = 5;
/// Maximum number of PDOs with an odd frame that are kept.
const MOST: usize = 64;

/// The number that distinguishes findings: the kind of event and the PDO.
fn detail(kind: u64, pdo: PdoNumber) -> u64 {
    let number = match pdo {
        PdoNumber::Transmit(number) => u64::from(number),
        PdoNumber::Receive(number) => 1 << 16 | u64::from(number),
    };
    kind << 32 | number
}

impl OutOfStep {
    fn tell(&self, sink: &mut Sink<'_>) {
        let (node, pdo) = self.pdo;
        let Odd { step, passed } = self.odd;
        let is_additional = passed < step;
        let report = Report::at(self.frame.time()).node(node).detail(detail(u64::from(is_additional), pdo));
        let report = report.severity(Severity::Info).evidence(self.before.as_ref().map(Seen::evidence));
        sink.report(report.evidence(self.frame.evidence()), || {
            let what = if is_additional { "once more after" } else { "only after" };
            format!("{pdo} comes {what} {passed} SYNC messages, once; else it comes at every {step}.")
        });
    }
}

impl OutOfRhythm {
    /// Reports a frame that does not fit the learned period.
    fn unpunctual(pdo: (NodeId, PdoNumber), context: &Context<'_>, sink: &mut Sink<'_>) {
        let (node, pdo) = pdo;
        let is_timed = match pdo {
            PdoNumber::Transmit(number) => context.scene.facts.tpdos.of(node, number).event_timer.is_some(),
            PdoNumber::Receive(_) => false,
        };
        let report = Report::at(context.now()).node(node);
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        match context.news().stream {
            StreamEvent::Additional { period, times } if !is_timed || times >= TWO_SENDERS => {
                let is_proven = times >= TWO_SENDERS;
                let report = if is_proven { report } else { report.severity(Severity::Info) };
                sink.report(report.detail(detail(2, pdo)).measure(u64::from(times)), || {
                    let more =
                        if is_proven { "another one in each period: two devices send it" } else { "once more between" };
                    format!("{pdo} comes every {period}, and {more}")
                });
            }
            StreamEvent::Late { since, period } if !is_timed => {
                sink.report(report.detail(detail(3, pdo)).severity(Severity::Info), || {
                    let late = context.now().since(since);
                    format!("{pdo} comes {late} after the one before; until then it came every {period}")
                });
            }
            _ => {}
        }
    }
}

impl Rule for OutOfRhythm {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let (Some(node), &Message::Pdo(number)) = (context.node(), context.message()) else { return };
        let pdo = (node, number);
        match context.news().stream {
            StreamEvent::OutOfStep(odd) => {
                self.odd.retain(|odd| odd.pdo != pdo);
                if self.odd.len() < MOST {
                    self.odd.push(OutOfStep { pdo, odd, before: context.previous.cloned(), frame: context.seen() });
                }
            }
            StreamEvent::InStep => {
                self.odd.extract_if(.., |odd| odd.pdo == pdo).for_each(|odd| odd.tell(sink));
            }
            _ => Self::unpunctual(pdo, context, sink),
        }
    }

    fn interrupted(&mut self) {
        self.odd.clear();
    }
}
