use crate::NodeId;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::Message;
use crate::wire::srdo::{Fit, Half, Srdo};
use canvass_macros::rule;

/// the two frames of an SRDO do not fit each other
///
/// The second frame of an SRDO is not the inverse of the first one, comes without it or too late, or does not come at
/// all; or the data frame has another length than at least ten before it. Both CAN-IDs are known to be a pair, by 1301h and the following or by an earlier SRDO.
///
/// # Why
/// The consumer goes to its safe state.
///
/// # What to do
/// If one of the frames is missing, look for error frames and at the bus load; if the data differs, at the firmware of
/// the producer, or for a second sender on one of the CAN-IDs.
#[rule(id = "srdo/halves", severity = Error, rank = ProcessData, services = [Srdo, Nmt])]
struct Halves {
    /// The data frames that wait for their inverse.
    open: Vec<(Key, Seen)>,
    /// The SRDOs that were seen before the last command, and not since.
    fresh: Vec<Key>,
    all: Vec<Key>,
    lengths: Vec<Length>,
}

/// The length of an SRDO.
struct Length {
    key: Key,
    length: usize,
    /// Number of data frames in a row with this length.
    times: u32,
}

/// Number of data frames that make a length usual.
const USUAL: u32 = 10;

/// An SRDO: the node, and the number if it is known.
type Key = (Option<NodeId>, Option<u8>);

/// Maximum number of SRDOs that are followed.
const MOST: usize = 64;

impl Halves {
    fn tell(&self, detail: u64, others: Option<&Seen>, context: &Context<'_>, sink: &mut Sink<'_>, what: &str) {
        let report = Report::at(context.now()).node(context.node()).detail(detail);
        let report = report.evidence(others.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || what.to_owned());
    }

    fn length(&mut self, key: Key, context: &Context<'_>, sink: &mut Sink<'_>) {
        let length = context.record.frame.data().len();
        let Some(at) = self.lengths.iter().position(|known| known.key == key) else {
            if self.lengths.len() < MOST {
                self.lengths.push(Length { key, length, times: 1 });
            }
            return;
        };
        let known = &mut self.lengths[at];
        if known.length == length {
            known.times = known.times.saturating_add(1);
            return;
        }
        let before = std::mem::replace(known, Length { key, length, times: 1 });
        if before.times >= USUAL {
            let text = format!("{length} bytes, the {} before had {}", before.times, before.length);
            self.tell(4, context.previous, context, sink, &text);
        }
    }

    fn see(&mut self, srdo: Srdo, context: &Context<'_>, sink: &mut Sink<'_>) {
        let key = (context.node(), srdo.number);
        if !self.all.contains(&key) && self.all.len() < MOST {
            self.all.push(key);
        }
        let place = self.open.iter().position(|(known, _)| *known == key);
        let open = place.map(|place| self.open.swap_remove(place).1);
        match (srdo.half, srdo.fit) {
            (Half::Normal, _) => {
                self.length(key, context, sink);
                self.fresh.retain(|known| *known != key);
                if let Some(open) = &open {
                    self.tell(1, Some(open), context, sink, "the inverted data did not follow the data");
                }
                self.open.push((key, context.seen()));
            }
            (Half::Inverted, Fit::Inverse) => {}
            (Half::Inverted, Fit::Different) => {
                self.tell(2, open.as_ref(), context, sink, "the second frame is not the inverse of the first one");
            }
            // After a command the data may have been held back.
            (Half::Inverted, Fit::Alone) if self.fresh.contains(&key) => {}
            (Half::Inverted, Fit::Alone) => {
                self.tell(3, open.as_ref(), context, sink, "inverted data without its data in the time before");
            }
        }
    }
}

impl Rule for Halves {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match context.message() {
            Message::Srdo(srdo) => self.see(*srdo, context, sink),
            _ if context.begins_anew() => self.interrupted(),
            _ => {}
        }
    }

    fn interrupted(&mut self) {
        self.open.clear();
        self.lengths.clear();
        self.fresh.clone_from(&self.all);
    }
}
