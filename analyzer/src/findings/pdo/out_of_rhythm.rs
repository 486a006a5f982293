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
struct OutOfRhythm;

/// Number of periods with another frame that prove two senders.
const TWO_SENDERS: u8 = 5;

/// What happened, in words, with a number that distinguishes it.
fn event(pdo: PdoNumber, is_timed: bool, context: &Context<'_>) -> Option<(u64, Severity, String)> {
    let info = |kind, text| Some((kind, Severity::Info, text));
    match context.news().stream {
        StreamEvent::OutOfStep(Odd { step, passed }) if passed < step => {
            info(1, format!("{pdo} came once more after {passed} SYNC messages; before and after it comes at every {step}."))
        }
        StreamEvent::OutOfStep(Odd { step, passed }) => {
            info(2, format!("{pdo} came only after {passed} SYNC messages, once; else it comes at every {step}."))
        }
        StreamEvent::Additional { period, times: TWO_SENDERS.. } => {
            let text = format!("{pdo} comes every {period}, and another one in each period: two devices send it");
            Some((3, Severity::Warning, text))
        }
        StreamEvent::Additional { period, .. } if !is_timed => {
            info(3, format!("{pdo} comes every {period}, and once more between"))
        }
        StreamEvent::Late { since, period } if !is_timed => {
            let late = context.now().since(since);
            info(4, format!("{pdo} comes {late} after the one before; until then it came every {period}"))
        }
        _ => None,
    }
}

impl Rule for OutOfRhythm {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let (Some(node), &Message::Pdo(pdo)) = (context.node(), context.message()) else { return };
        let (number, is_timed) = match pdo {
            PdoNumber::Transmit(number) => {
                (u64::from(number), context.scene.facts.tpdos.of(node, number).event_timer.is_some())
            }
            PdoNumber::Receive(number) => (1 << 16 | u64::from(number), false),
        };
        let Some((kind, severity, text)) = event(pdo, is_timed, context) else { return };
        let report = Report::at(context.now()).node(node).detail(kind << 32 | number).severity(severity);
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || text);
    }
}
