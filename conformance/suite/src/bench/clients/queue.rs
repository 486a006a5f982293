//! The requests of all clients that the device's SDO server has not answered yet; they decide to whom the next answer
//! belongs.

use canvass_analyzer::wire::sdo::{Request, Response};
use canvass_traces::{Duration, Timestamp};
use std::collections::VecDeque;

/// Time after which an unanswered request counts as lost.
const FORGOTTEN: Duration = Duration::from_secs(1);

/// Maximum pause of a client between two messages of a transfer.
const PAUSE: Duration = Duration::from_millis(100);

/// Maximum number of requests that wait at a server.
const KEPT: usize = 32;

/// Requests that clients sent to a server of the device, oldest first.
#[derive(Debug, Default)]
pub(crate) struct ServerQueue {
    asked: VecDeque<Asked>,
    /// The end of the time in which another client's transfer may go on.
    busy_until: Option<Timestamp>,
    /// Number of requests of other clients.
    foreign: u64,
    /// The times of the last two requests of other clients.
    latest: [Option<Timestamp>; 2],
}

#[derive(Clone, Copy, Debug)]
struct Asked {
    request: Request,
    is_foreign: bool,
    at: Timestamp,
}

impl ServerQueue {
    /// Adds a request of a client.
    pub fn ask(&mut self, request: Request, is_foreign: bool, at: Timestamp) {
        if is_foreign {
            self.foreign += 1;
            self.latest = [self.latest[1], Some(at)];
        }
        self.asked.retain(|asked| at.since(asked.at) < FORGOTTEN);
        if matches!(request, Request::Abort(_) | Request::EndBlockUpload) {
            self.busy_until = self.busy_until.filter(|_| !is_foreign);
            return;
        }
        // The segments of a block look like requests, too, so the queue is limited.
        if self.asked.len() == KEPT {
            self.asked.pop_front();
        }
        self.asked.push_back(Asked { request, is_foreign, at });
    }

    /// Takes an answer of the server. Returns whether the answer is for others: the oldest request that it fits comes
    /// from them.
    pub fn answer(&mut self, response: Option<&Response>, at: Timestamp) -> bool {
        self.asked.retain(|asked| at.since(asked.at) < FORGOTTEN);
        if self.asked.iter().all(|asked| !asked.is_foreign) {
            self.asked.pop_front();
            return false;
        }
        let fitting = response.and_then(|response| self.asked.iter().position(|asked| fits(&asked.request, response)));
        let Some(asked) = fitting.and_then(|place| self.asked.remove(place)) else { return false };
        if asked.is_foreign {
            // A client has one request at a time, so the older requests of others are lost. An older request of the
            // tester stays, because a request of others may have overtaken it.
            let (passed_over, mut place) = (fitting.unwrap_or_default(), 0);
            self.asked.retain(|asked| {
                place += 1;
                place > passed_over || !asked.is_foreign
            });
            let goes_on = response.is_some_and(|response| goes_on(&asked.request, response));
            self.busy_until = goes_on.then(|| at + PAUSE);
        }
        asked.is_foreign
    }

    /// Forgets all requests: the device has restarted, and will not answer them.
    pub fn reset(&mut self) {
        self.asked.clear();
        self.busy_until = None;
    }

    /// Number of requests of other clients.
    pub const fn foreign(&self) -> u64 {
        self.foreign
    }

    /// The period of the others' requests and the time of the next one, estimated from their last two requests.
    pub(crate) fn next_foreign(&self) -> Option<(Duration, Timestamp)> {
        let [Some(before), Some(last)] = self.latest else { return None };
        let period = last.since(before);
        Some((period, last + period))
    }

    /// The time until which the server is busy with others, if it answers each request within `patience`.
    pub(crate) fn busy_until(&self, now: Timestamp, patience: Duration) -> Option<Timestamp> {
        let foreign = self.asked.iter().filter(|asked| asked.is_foreign).map(|asked| asked.at + patience);
        foreign.chain(self.busy_until).max().filter(|&until| until > now)
    }
}

/// Whether a response may answer a request.
fn fits(request: &Request, response: &Response) -> bool {
    let names_it = |multiplexer| request.multiplexer() == Some(multiplexer);
    match (request, response) {
        (request, Response::Abort(abort)) => request.multiplexer().is_none_or(|asked| asked == abort.multiplexer),
        (
            Request::InitiateUpload { .. } | Request::InitiateBlockUpload { .. },
            Response::InitiateUpload { multiplexer, .. },
        )
        | (Request::InitiateDownload { .. }, Response::InitiateDownload { multiplexer })
        | (Request::InitiateBlockUpload { .. }, Response::InitiateBlockUpload { multiplexer, .. })
        | (Request::InitiateBlockDownload { .. }, Response::InitiateBlockDownload { multiplexer, .. }) => {
            names_it(*multiplexer)
        }
        (Request::UploadSegment { .. }, Response::UploadSegment(_))
        | (Request::DownloadSegment(_), Response::DownloadSegment { .. })
        | (Request::EndBlockDownload { .. }, Response::EndBlockDownload) => true,
        _ => false,
    }
}

/// Whether the transfer continues after this response.
fn goes_on(request: &Request, response: &Response) -> bool {
    match (request, response) {
        (_, Response::InitiateUpload { payload, .. }) => payload.value().is_none(),
        (Request::InitiateDownload { payload, .. }, Response::InitiateDownload { .. }) => payload.value().is_none(),
        (_, Response::UploadSegment(segment)) => !segment.last,
        (Request::DownloadSegment(segment), _) => !segment.last,
        (_, Response::InitiateBlockUpload { .. } | Response::InitiateBlockDownload { .. }) => true,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scripted::frame;
    use canvass_analyzer::wire::Wire;

    const AT: fn(u64) -> Timestamp = |ms| Timestamp(ms * 1_000_000);
    const PATIENCE: Duration = Duration::from_millis(20);

    fn request(text: &str) -> Request {
        Request::read(frame(&format!("63F#{text}")).data()).unwrap()
    }

    fn response(text: &str) -> Response {
        Response::read(frame(&format!("5BF#{text}")).data()).unwrap()
    }

    /// Who gets each answer: `x` marks requests of others, `o` requests of the tester. Returns for each answer whether
    /// it is for others.
    fn whose(asked: &[(char, &str)], answers: &[&str]) -> Vec<bool> {
        let mut queue = ServerQueue::default();
        for (n, (who, text)) in asked.iter().enumerate() {
            queue.ask(request(text), *who == 'x', AT(n as u64));
        }
        answers.iter().map(|text| queue.answer(Some(&response(text)), AT(10))).collect()
    }

    const READ: &str = "4000100000000000";
    const VALUE: &str = "4300100096010200";

    #[test]
    fn an_answer_is_that_of_the_oldest_request_that_it_fits() {
        assert_eq!(whose(&[('o', READ), ('x', READ)], &[VALUE, VALUE]), [false, true]);
        assert_eq!(whose(&[('x', READ), ('o', READ)], &[VALUE, VALUE]), [true, false]);
        let (other, other_value) = ("4001100000000000", "4F01100000000000");
        assert_eq!(whose(&[('x', other), ('o', READ)], &[VALUE, other_value]), [false, true]);
        assert_eq!(whose(&[('x', other), ('o', READ)], &["8001100000000206", "8000100000000206"]), [true, false]);
        assert_eq!(
            whose(&[('x', other), ('o', "2300100001000000")], &["6000100000000000", other_value]),
            [false, true]
        );
    }

    /// If nobody else sends requests, every answer is for the tester, however wrong it is.
    #[test]
    fn without_others_no_answer_is_theirs() {
        assert_eq!(whose(&[('o', READ)], &["4F01100000000000", "8002100000000206"]), [false, false]);
        assert_eq!(whose(&[], &[VALUE]), [false]);
        assert_eq!(whose(&[('x', READ), ('o', READ)], &["0041424300000000"]), [false], "it fits no request");
        let mut queue = ServerQueue::default();
        queue.ask(request(READ), true, AT(0));
        assert!(!queue.answer(Some(&response(VALUE)), AT(1_000)), "nobody waits for it any more");
        assert!(!queue.answer(None, AT(1_001)));
    }

    #[test]
    fn segments_are_told_apart_by_their_kind() {
        let toggled = [('x', "6000000000000000"), ('o', "0041000000000000")];
        assert_eq!(whose(&toggled, &["2000000000000000", "0041424344454647"]), [false, true]);
        let blocks = [('x', "A400100010000000"), ('o', "C600100008000000")];
        assert_eq!(whose(&blocks, &["A40010007F000000", "C600100008000000"]), [false, true]);
        assert_eq!(whose(&[('x', "A400100010080000"), ('o', READ)], &["4100100008000000"]), [true]);
    }

    #[test]
    fn the_server_is_busy_until_others_have_their_answers() {
        let mut queue = ServerQueue::default();
        assert_eq!(queue.busy_until(AT(0), PATIENCE), None);
        queue.ask(request(READ), false, AT(0));
        assert_eq!(queue.busy_until(AT(1), PATIENCE), None, "the tester's own");
        queue.ask(request("4008100000000000"), true, AT(5));
        assert_eq!((queue.busy_until(AT(6), PATIENCE), queue.busy_until(AT(25), PATIENCE)), (Some(AT(25)), None));
        assert!(queue.answer(Some(&response("410810000E000000")), AT(7)));
        assert_eq!(queue.busy_until(AT(8), PATIENCE), Some(AT(107)), "segments follow");
        queue.ask(request("6000000000000000"), true, AT(9));
        assert!(!queue.answer(Some(&response(VALUE)), AT(9)), "the tester's answer is late");
        assert!(queue.answer(Some(&response("0043414E6F706E73")), AT(10)));
        assert_eq!(queue.busy_until(AT(11), PATIENCE), Some(AT(110)));
        queue.ask(request("7000000000000000"), true, AT(12));
        assert!(queue.answer(Some(&response("1143414E6F706E73")), AT(13)));
        assert_eq!((queue.busy_until(AT(14), PATIENCE), queue.foreign()), (None, 3));
    }

    /// The server does not go back to a request that it has passed over.
    #[test]
    fn answers_come_in_order() {
        let (other, other_value) = ("4001100000000000", "4F01100000000000");
        let asked = [('x', READ), ('x', other), ('o', READ)];
        assert_eq!(whose(&asked, &[other_value, VALUE]), [true, false], "the first was lost");
        let mut queue = ServerQueue::default();
        queue.ask(request(READ), true, AT(0));
        queue.reset();
        assert!(!queue.answer(Some(&response(VALUE)), AT(1)), "a device that has started anew");
    }

    #[test]
    fn the_next_poll_is_foreseen() {
        let mut queue = ServerQueue::default();
        for at in [0, 20, 40] {
            queue.ask(request(READ), false, AT(at));
        }
        assert_eq!(queue.next_foreign(), None);
        queue.ask(request(READ), true, AT(100));
        assert_eq!(queue.next_foreign(), None);
        queue.ask(request(READ), true, AT(120));
        assert_eq!(queue.next_foreign(), Some((Duration::from_millis(20), AT(140))));
    }

    /// A client that gives up its transfer leaves the server to others.
    #[test]
    fn an_abort_ends_the_transfer_of_others() {
        let mut queue = ServerQueue::default();
        queue.ask(request("4008100000000000"), true, AT(5));
        queue.answer(Some(&response("410810000E000000")), AT(7));
        queue.ask(request("8008100000000405"), false, AT(8));
        assert!(queue.busy_until(AT(9), PATIENCE).is_some(), "that was the tester's");
        queue.ask(request("8008100000000405"), true, AT(9));
        assert_eq!(queue.busy_until(AT(10), PATIENCE), None);
    }
}
