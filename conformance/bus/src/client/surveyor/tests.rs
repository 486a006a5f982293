//! Surveys of devices that answer, refuse, fall silent and never stop sending.

use super::*;
use crate::Bus;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{Abort, Payload, Request, Response};
use canvass_traces::{ChannelId, Direction, Frame, Record, Timestamp};
use std::collections::VecDeque;

/// A bus with one device, whose answers come from a function; time passes only while the tester waits.
struct Device<F> {
    now: Timestamp,
    sent: VecDeque<Record>,
    asked: Vec<Multiplexer>,
    answer: F,
}

impl<F: FnMut(&Request) -> Option<Response>> Bus for Device<F> {
    fn now(&self) -> Timestamp {
        self.now
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        let request = Request::read(frame.data()).unwrap();
        if let Request::InitiateUpload { multiplexer } = request {
            self.asked.push(multiplexer);
        }
        if let Some(response) = (self.answer)(&request) {
            let record = Record::new(self.now, ChannelId(0), response.to_frame(0x585));
            self.sent.push_back(record.with_direction(Direction::Rx));
        }
        Ok(())
    }

    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        let record = self.sent.pop_front();
        if record.is_none() {
            self.now = self.now.max(deadline);
        }
        Ok(record)
    }

    fn bit_rate(&self) -> Option<u32> {
        None
    }
}

/// Runs a survey of a device; returns the answers, the result of the survey, and the requested entries.
fn survey<T>(
    answer: impl FnMut(&Request) -> Option<Response>,
    read: impl FnOnce(&mut Surveyor<'_, '_>) -> Result<T, SurveyError>,
) -> (Survey, Result<T, SurveyError>, Vec<Multiplexer>) {
    let mut bus = Device { now: Timestamp(0), sent: VecDeque::new(), asked: Vec::new(), answer };
    let mut observe = |_: &Record| {};
    let mut exchange = Exchange { bus: &mut bus, observe: &mut observe, ends: Timestamp::MAX };
    let mut watch = |_| true;
    let node = NodeId::new(5).unwrap();
    let mut surveyor = Surveyor::new(&mut exchange, node, Duration::from_millis(10), &mut watch);
    let done = read(&mut surveyor);
    let (survey, _) = surveyor.into_survey();
    (survey, done, bus.asked)
}

fn asked(request: &Request) -> Option<Multiplexer> {
    match request {
        Request::InitiateUpload { multiplexer } => Some(*multiplexer),
        _ => None,
    }
}

fn value(multiplexer: Multiplexer, bytes: &[u8]) -> Option<Response> {
    Some(Response::InitiateUpload { multiplexer, payload: Payload::of(bytes) })
}

fn refused(multiplexer: Multiplexer, code: AbortCode) -> Option<Response> {
    Some(Response::Abort(Abort { multiplexer, code }))
}

/// A device with a device type, and with a list in 1003h: sub-index 0 counts one entry, but two exist.
fn small(request: &Request) -> Option<Response> {
    let at = asked(request)?;
    match (at.index.0, at.sub.0) {
        (0x1000, 0) => value(at, &[0, 0, 0, 0]),
        (0x1003, 0..=2) => value(at, &[1]),
        (0x1000 | 0x1003, _) => refused(at, AbortCode::NO_SUB_INDEX),
        _ => refused(at, AbortCode::NO_OBJECT),
    }
}

#[test]
fn an_area_is_read_with_the_sub_indexes_that_there_are() {
    let (survey, done, asked) = survey(small, |surveyor| surveyor.area(0x1000..=0x1005));
    assert!(matches!(done, Ok(None)));
    let existing: Vec<String> =
        survey.answers().filter(|it| it.1.exists() == Some(true)).map(|it| it.0.to_string()).collect();
    assert_eq!(existing, ["1000h:00", "1003h:00", "1003h:01", "1003h:02"]);
    // Each entry is read once, and of each object the first sub-index that does not exist.
    assert_eq!(asked.len(), 10, "{asked:?}");
}

#[test]
fn described_entries_are_read_with_the_gaps_between_them() {
    let text = "[1003]\nParameterName=E\nObjectType=8\nSubNumber=2\n[1003sub0]\nParameterName=C\nDataType=5\nAccessType=ro\n\
                [1003sub2]\nParameterName=S\nDataType=5\nAccessType=ro\n\
                [1004]\nParameterName=N\nObjectType=7\nDataType=5\nAccessType=ro\n\
                [1005]\nParameterName=K\nObjectType=7\nDataType=5\nAccessType=ro\nObjFlags=2\n";
    let description = DeviceDescription::read(text.as_bytes()).unwrap();
    let (_, done, asked) = survey(small, |surveyor| surveyor.described(&description));
    assert!(done.is_ok());
    let asked: Vec<String> = asked.iter().map(ToString::to_string).collect();
    assert_eq!(
        asked,
        ["1003h:00", "1003h:02", "1003h:01", "1003h:03", "1004h:00"],
        "and what a scan must not read, not at all"
    );
}

#[test]
fn one_that_never_answers_and_one_that_falls_silent_are_told_apart() {
    let (_, done, all) = survey(|_| None, |surveyor| surveyor.area(0x1000..=0x1FFF));
    assert_eq!(
        done.unwrap_err().to_string(),
        "node 5 does not answer: does it exist, and does the bus have its bit rate?"
    );
    assert!(all.len() < 6, "{all:?}");
    let mut left = 4;
    let falls_silent = |request: &Request| {
        left -= i32::from(asked(request).is_some());
        if left > 0 { small(request) } else { None }
    };
    let (_, done, _) = survey(falls_silent, |surveyor| surveyor.area(0x1000..=0x1FFF));
    assert_eq!(done.unwrap_err().to_string(), "node 5 no longer answers, from 1002h:00 on");
}

fn asked_of(request: &Request, index: u16) -> bool {
    asked(request).is_some_and(|at| at.index.0 == index)
}

#[test]
fn silence_where_nothing_is_ends_an_area_and_not_the_survey() {
    let only_what_there_is = |request: &Request| if asked_of(request, 0x1000) { small(request) } else { None };
    let (survey, done, _) = survey(only_what_there_is, |surveyor| surveyor.area(0x1000..=0x1FFF));
    assert_eq!(done.unwrap(), Some(Index(0x1000 + 16)));
    assert_eq!(survey.get(Multiplexer::new(0x1001, 0)), Some(&Answer::Silent));
    // The surveyor repeats a request whose frame was lost.
    let mut lost = true;
    let loses_one = |request: &Request| if std::mem::take(&mut lost) { None } else { small(request) };
    let (survey, done, _) = self::survey(loses_one, |surveyor| surveyor.area(0x1000..=0x1000));
    assert!(done.is_ok() && survey.number(Multiplexer::new(0x1000, 0)) == Some(0));
}

#[test]
fn an_upload_without_end_is_left() {
    let endless = |request: &Request| match request {
        Request::InitiateUpload { multiplexer } => {
            Some(Response::InitiateUpload { multiplexer: *multiplexer, payload: Payload::Segmented(1 << 30) })
        }
        Request::UploadSegment { toggle } => {
            canvass_analyzer::wire::sdo::Segment::new(*toggle, &[7; 7], false).map(Response::UploadSegment)
        }
        _ => None,
    };
    let at = Multiplexer::new(0x1021, 0);
    let (survey, ..) = survey(endless, |surveyor| surveyor.read(at).cloned());
    assert_eq!(survey.get(at), Some(&Answer::Long(64 << 10)));
}

/// A reserved area is asked by samples, and read as a whole if one of them exists.
#[test]
fn reserved_areas_are_sampled() {
    let absent = |multiplexer| Response::Abort(Abort { multiplexer, code: AbortCode::NO_OBJECT });
    let answer = |request: &Request| match *request {
        Request::InitiateUpload { multiplexer } => Some(absent(multiplexer)),
        _ => None,
    };
    let (_, done, asked) = survey(answer, |surveyor| surveyor.reserved(0xC000..=0xFFFF));
    assert_eq!((done.unwrap(), asked.len()), (None, 256));
    let with_one = |request: &Request| match *request {
        Request::InitiateUpload { multiplexer } if multiplexer == Multiplexer::new(0xC080, 0) => {
            Some(Response::InitiateUpload { multiplexer, payload: Payload::of(&[7]) })
        }
        Request::InitiateUpload { multiplexer } => Some(absent(multiplexer)),
        _ => None,
    };
    let (survey, done, asked) = survey(with_one, |surveyor| surveyor.reserved(0xC000..=0xC0FF));
    assert_eq!(done.unwrap(), None);
    assert!(asked.len() > 256 && survey.counts().1 == 1, "{}", asked.len());
}
