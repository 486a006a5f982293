//! Requirements on the whole dialogue with the SDO server in a case, its preparation included: each response belongs to
//! the request before it, and a server that has to serve SDO leaves no request unanswered.

use super::Bench;
use crate::verdict::{Breach, Judged};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control::{CAN_ID_BASE, ErrorControl};
use canvass_analyzer::wire::nmt::{self, Command, Nmt};
use canvass_analyzer::wire::sdo::{self, AbortCode, Request, Response};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::client::sdo::{Bytes, name};
use canvass_bus::observation::Observation;
use canvass_traces::{Direction, Duration, Record, Timestamp};

impl Bench<'_> {
    /// Requires that the dialogue of the case so far is in order.
    ///
    /// # Errors
    /// The errors of [`Bench::check`].
    pub fn expect_dialogue(&mut self) -> Judged {
        let evidence = self.evidence();
        // Long evidence keeps only its first and last frames: requests are missing in the gap.
        let gap = (evidence.omitted() > 0).then(|| evidence.gap());
        // The times of the frames differ a little from the times between which the tester waited.
        let patience = Duration::from_nanos(self.timing().sdo_response.nanos() / 10 * 9);
        let mut dialogue = Dialogue::new(self.node(), patience);
        for (place, exhibit) in evidence.frames().enumerate() {
            if gap == Some(place) {
                (dialogue.turn, dialogue.phase) = (Turn::Unknown, Phase::Unknown);
            }
            dialogue.observe(&exhibit.record);
        }
        self.check(dialogue.breach().map_or(Ok(()), |breach| Err(Box::new(breach))))
    }
}

/// The side that sends the next message of the dialogue.
#[derive(Clone, Copy, Debug)]
enum Turn {
    /// The tester does not know, or a transfer is under way whose messages name no object.
    Unknown,
    /// The server has to answer the initiation of a transfer.
    Server { asked: Asked },
    /// The server has answered, and the next message is a request.
    Client { answered: Asked },
}

#[derive(Clone, Copy, Debug)]
struct Asked {
    at: Timestamp,
    multiplexer: Multiplexer,
    is_upload: bool,
    phase: Phase,
}

/// The state of the device at a request, as far as it decides whether the device has to answer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Phase {
    /// The device may be in any state.
    Unknown,
    /// The device has started, and got no command since.
    Started,
    /// The device was commanded to a state in which it serves SDO.
    Serving,
}

struct Dialogue {
    node: NodeId,
    patience: Duration,
    turn: Turn,
    phase: Phase,
    /// The requests that the tester has given up: their answers may still come.
    given_up: Vec<Asked>,
    /// Whether the device has answered after a start without a command: it starts in a state that serves SDO.
    serves_when_started: bool,
    /// The first unanswered request of each phase.
    unanswered: Vec<Asked>,
    wrong: Option<Breach>,
}

impl Dialogue {
    const fn new(node: NodeId, patience: Duration) -> Self {
        Self {
            node,
            patience,
            turn: Turn::Unknown,
            phase: Phase::Unknown,
            given_up: Vec::new(),
            serves_when_started: false,
            unanswered: Vec::new(),
            wrong: None,
        }
    }

    /// The first breach.
    fn breach(self) -> Option<Breach> {
        let is_owed = |asked: &&Asked| asked.phase == Phase::Serving || self.serves_when_started;
        let unanswered = self.unanswered.iter().find(is_owed).map(|asked| {
            let duty = format!("a request for {} is answered in each state that serves SDO", asked.multiplexer);
            let breach = Breach::new(asked.multiplexer, duty).expected("a response").found(Observation::Silence);
            Breach { seen: Some(asked.at), ..breach }
        });
        let first = |breach: &Breach| breach.seen;
        self.wrong.into_iter().chain(unanswered).min_by_key(first)
    }

    fn observe(&mut self, record: &Record) {
        let Some(id) = record.frame.cob_id() else { return };
        let (node, is_own) = (u16::from(self.node.raw()), record.direction == Direction::Tx);
        let data = record.frame.data();
        if id == nmt::CAN_ID {
            self.on_command(data);
        } else if id == sdo::REQUEST_BASE + node {
            let request = Request::read(data).ok().filter(|_| is_own && record.frame.len() == 8);
            self.on_request(record.timestamp, request);
        } else if id == sdo::RESPONSE_BASE + node && !is_own {
            self.on_response(record);
        } else if id == CAN_ID_BASE + node && ErrorControl::read(data).is_ok_and(ErrorControl::is_boot_up) {
            self.phase = Phase::Started;
        }
    }

    fn on_command(&mut self, data: &[u8]) {
        let Ok(Nmt { command, node }) = Nmt::read(data) else { return };
        if node == 0 || node == self.node.raw() {
            let serves = matches!(command, Command::ENTER_PRE_OPERATIONAL | Command::START);
            self.phase = if serves { Phase::Serving } else { Phase::Unknown };
            self.turn = Turn::Unknown;
        }
    }

    fn on_request(&mut self, at: Timestamp, request: Option<Request>) {
        if let Turn::Server { asked } = self.turn {
            self.given_up.push(asked);
            if asked.phase != Phase::Unknown && asked.phase == self.phase && at.since(asked.at) >= self.patience {
                self.unanswered.push(asked);
            }
        }
        let (multiplexer, is_upload) = match request {
            Some(Request::InitiateUpload { multiplexer }) => (multiplexer, true),
            Some(Request::InitiateDownload { multiplexer, .. }) => (multiplexer, false),
            _ => {
                self.turn = Turn::Unknown;
                return;
            }
        };
        self.turn = Turn::Server { asked: Asked { at, multiplexer, is_upload, phase: self.phase } };
    }

    fn on_response(&mut self, record: &Record) {
        let response = Response::read(record.frame.data()).ok();
        // The server may end an earlier transfer at any time.
        if matches!(response, Some(Response::Abort(abort)) if abort.code == AbortCode::TIMEOUT) {
            return;
        }
        let turn = self.turn;
        match turn {
            Turn::Unknown => {}
            Turn::Server { asked } if asked.is_answered_by(response) => {
                self.serves_when_started |= asked.phase == Phase::Started;
                self.turn = Turn::Client { answered: asked };
            }
            Turn::Server { .. } | Turn::Client { .. } if self.is_late(response) => {}
            Turn::Server { asked } => {
                let duty = format!("the answer to a request for {0} is about {0}", asked.multiplexer);
                self.found(asked, duty, record, response);
            }
            Turn::Client { answered } => {
                let duty = format!("a request for {} is answered once", answered.multiplexer);
                self.found(answered, duty, record, response);
            }
        }
    }

    /// Whether the response is the late answer to a request that the tester has given up.
    fn is_late(&mut self, response: Option<Response>) -> bool {
        let late = self.given_up.iter().position(|asked| asked.is_answered_by(response));
        late.is_some_and(|place| self.given_up.drain(..=place).next().is_some())
    }

    fn found(&mut self, asked: Asked, duty: String, record: &Record, response: Option<Response>) {
        if self.wrong.is_some() {
            return;
        }
        let what = response.as_ref().map_or("an unreadable response", name);
        let breach = Breach::new(asked.multiplexer, duty).expected("no other response");
        let breach = breach.found(Observation::Frame(record.frame));
        let told = format!("{what} ({})", Bytes(record.frame.data()));
        self.wrong = Some(Breach { seen: Some(record.timestamp), ..breach.told(told) });
    }
}

impl Asked {
    fn is_answered_by(self, response: Option<Response>) -> bool {
        match response {
            Some(Response::InitiateUpload { multiplexer, .. }) => self.is_upload && multiplexer == self.multiplexer,
            Some(Response::InitiateDownload { multiplexer }) => !self.is_upload && multiplexer == self.multiplexer,
            // Another case judges the object that an abort names.
            Some(Response::Abort(_)) => true,
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scripted::{NODE, frame};
    use canvass_traces::ChannelId;

    /// The breach in a dialogue of these frames. Each frame has its time in milliseconds; `>` marks a frame of the
    /// tester.
    fn found(frames: &[(u64, &str)]) -> Option<String> {
        let mut dialogue = Dialogue::new(NodeId::new(NODE).unwrap(), Duration::from_millis(1_000));
        for (at, text) in frames {
            let direction = if text.starts_with('>') { Direction::Tx } else { Direction::Rx };
            let record = Record::new(Timestamp(at * 1_000_000), ChannelId(0), frame(&text[1..]));
            dialogue.observe(&record.with_direction(direction));
        }
        dialogue.breach().map(|breach| breach.to_string())
    }

    const ASKED: &str = ">63F#4000100000000000";
    const ANSWERED: &str = "<5BF#4300100091010200";

    #[test]
    fn a_response_is_about_the_object_of_the_request_before() {
        assert_eq!(found(&[(0, ASKED), (1, ANSWERED), (2, ASKED), (3, ANSWERED)]), None);
        assert_eq!(found(&[(0, ASKED), (1, "<5BF#8000100000000206")]), None, "a refusal");
        for wrong in ["4300110091010200", "4300100191010200", "6000100000000000", "0091010200000000", "4000"] {
            let told = found(&[(0, ASKED), (1, &format!("<5BF#{wrong}"))]).unwrap();
            assert!(told.starts_with("the answer to a request for 1000h:00 is about 1000h:00"), "{told}");
        }
        let segment = [(2, ">63F#6000000000000000"), (3, "<5BF#0091010200000000")];
        assert_eq!(found(&[&[(0, ASKED), (1, "<5BF#4100100007000000")], &segment[..]].concat()), None);
    }

    #[test]
    fn a_request_is_answered_once() {
        let told = found(&[(0, ASKED), (1, ANSWERED), (2, ANSWERED)]).unwrap();
        assert!(told.starts_with("a request for 1000h:00 is answered once"), "{told}");
        assert_eq!(found(&[(1, ANSWERED), (2, ANSWERED)]), None, "the tester asked for nothing");
        let timeout = "<5BF#8000100000000405";
        assert_eq!(found(&[(0, ASKED), (1, ANSWERED), (2, timeout), (3, timeout)]), None);
        assert_eq!(found(&[(0, ASKED), (1, "<63F#4000100000000000"), (2, "<5BF#4300110000000000")]), None, "of others");
        assert_eq!(found(&[(0, ASKED), (1, "<5BE#4300110000000000"), (2, ANSWERED)]), None, "another server");
    }

    /// A late answer belongs to the request that the tester has given up.
    #[test]
    fn a_late_answer_is_no_other_answer() {
        let (other, third) = (">63F#4001100000000000", ">63F#4018100000000000");
        let aborted = ">63F#8000100000000405";
        let both = [(0, ASKED), (1_000, aborted), (1_001, other), (2_001, third), (2_002, ANSWERED)];
        assert_eq!(found(&[&both[..], &[(2_003, "<5BF#4F01100000000000")]].concat()), None);
        let late = [(0, ASKED), (1_000, other), (1_500, ANSWERED), (2_000, "<5BF#4F01100000000000")];
        assert_eq!(found(&late), None);
        assert_eq!(found(&[(0, ASKED), (1_000, other), (1_100, "<5BF#4F01100000000000"), (1_500, ANSWERED)]), None);
    }

    /// A server owes an answer after a command to a state that serves SDO, and after a start without a command if it
    /// has answered after another such start.
    #[test]
    fn silence_is_judged_where_the_device_serves() {
        let (boot_up, reset, preoperational) = ("<73F#00", ">000#813F", ">000#803F");
        let silent = |frames: &[(u64, &str)]| found(frames).is_some_and(|told| told.contains("no answer"));
        assert!(silent(&[(0, preoperational), (1, ASKED), (1_001, ASKED), (1_002, ANSWERED)]));
        assert!(!silent(&[(0, preoperational), (1, ASKED), (500, ASKED), (501, ANSWERED)]), "not waited for");
        assert!(!silent(&[(0, ">000#023F"), (1, ASKED), (1_001, ASKED)]), "stopped");
        assert!(!silent(&[(0, ">000#803E"), (1, ASKED), (1_001, ASKED)]), "a command to another node");
        let lost = [(0, reset), (10, boot_up), (20, ASKED), (1_020, ASKED)];
        assert!(!silent(&lost), "it may have stopped itself");
        let served = [(2_000, reset), (2_010, boot_up), (2_020, ASKED), (2_021, ANSWERED)];
        assert!(silent(&[&lost[..], &served].concat()));
        assert!(!silent(&[&[(0, reset), (20, ASKED), (1_020, ASKED)], &served[..]].concat()), "it has not started");
    }
}
