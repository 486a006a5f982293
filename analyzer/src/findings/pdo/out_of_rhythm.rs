use crate::NodeId;
use crate::findings::facts::{Odd, StreamEvent};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::{Message, PdoNumber};
use canvass_macros::rule;

/// a PDO leaves the rhythm that it has had
///
/// The capture has shown a rhythm of the PDO in many frames: a period that the PDO kept while its data did not change, or a
/// number of SYNC messages from one frame to the next. Then one frame is missing, comes much too late, or is additional, and
/// the rhythm goes on. A single event is an information. Additional frames in five consecutive periods are a warning: two
/// devices send the PDO. An additional frame within a period counts only if its data differ from the frames before and
/// after it, and these have equal data: an event of the device itself would change the data for longer. Where the SDO
/// traffic shows the event timer of the PDO, pdo/period judges late frames, and single additional frames are not reported.
///
/// # Why
/// A consumer works with an old value for a cycle, or with the value of another device.
///
/// # What to do
/// Compare with other PDOs at that time: if they are late too, see the bus load and the recorder. If an additional frame
/// has other data, look for a second sender with this CAN-ID.
#[rule(id = "pdo/out-of-rhythm", severity = Warning, rank = ProcessData, also = UnusualPdos)]
struct OutOfRhythm {
    /// The PDOs with a frame out of step. It is reported once the next frames are in step again.
    odd: Vec<OutOfStep>,
}

/// A frame out of step with SYNC.
struct OutOfStep {
    pdo: (NodeId, PdoNumber),
    odd: Odd,
    before: Option<Seen>,
    frame: Seen,
}

/// Number of consecutive periods with an additional frame that prove two senders.
const TWO_SENDERS: u8 = 5;
/// Maximum number of PDOs with an odd frame that are kept.
const MOST: usize = 64;

/// The detail of a finding: the kind of event, and the PDO.
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
    /// Reports a frame that comes too late, or an additional frame within a period.
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
                    let more = if is_proven {
                        "an additional frame in each period: two devices send it"
                    } else {
                        "an additional frame between two of them"
                    };
                    format!("{pdo} comes every {period}, with {more}")
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
