//! Requirements on every answer of the SDO server, whatever the case tests: an abort names the object of the request,
//! the frame has eight bytes, and reserved fields are 0.

use super::Bench;
use crate::verdict::{Breach, Judged};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{AbortCode, Payload, Response};
use canvass_analyzer::{Multiplexer, Service};
use canvass_bus::client::Violation;
use canvass_bus::client::sdo::{Bytes, name};
use canvass_bus::observation::Observation;
use canvass_traces::Frame;

impl Bench<'_> {
    /// Judges an answer to a request that names `asked`; `None` if the request names no object.
    ///
    /// An abort that names another object is a breach of every case in which it is seen. Reserved fields that are not 0
    /// are kept for [`Bench::expect_tidy`].
    pub(super) fn judge_answer(&mut self, asked: Option<Multiplexer>, frame: &Frame) {
        let Ok(response) = Response::read(frame.data()) else { return };
        if let (Some(asked), Response::Abort(abort)) = (asked, response)
            && abort.multiplexer != asked
            // The server may abort an earlier transfer after its timeout while the request is on its way.
            && abort.code != AbortCode::TIMEOUT
        {
            self.record_wrong_object(asked, abort.multiplexer, frame);
        }
        if let Some(breach) = untidy(&response, frame) {
            self.log.keep_untidy(breach);
        }
    }

    /// Records the breach once per case: a server that names a wrong object once does so again.
    fn record_wrong_object(&mut self, asked: Multiplexer, named: Multiplexer, frame: &Frame) {
        let is_wrong_object =
            |breach: &Breach| matches!(breach.actual, Observation::Violation(Violation::Multiplexer(_)));
        if self.log.breaches().iter().any(is_wrong_object) {
            return;
        }
        let breach = Breach::new(asked, "an abort names the object of the request that it refuses")
            .expected(format!("an abort that names {asked}"))
            .found(Observation::Violation(Violation::Multiplexer(named)))
            .told(format!("an abort that names {named} ({})", Bytes(frame.data())));
        self.record(breach);
    }

    /// Requires that all answers of the case so far have eight bytes, and 0 in all reserved bits and bytes.
    ///
    /// # Errors
    /// The errors of [`Bench::check`].
    pub fn expect_tidy(&mut self) -> Judged {
        for breach in self.log.take_untidy() {
            self.check(Err(Box::new(breach)))?;
        }
        Ok(())
    }

    /// Runs `act` without judging the answers: the tester only finds out which objects and features the device has.
    pub(crate) fn unjudged<T>(&mut self, act: impl FnOnce(&mut Self) -> T) -> T {
        let mark = self.log.mark();
        let result = act(self);
        self.log.forget_since(mark);
        result
    }
}

/// The breach in the form of an answer, if there is one.
fn untidy(response: &Response, frame: &Frame) -> Option<Breach> {
    let breach = |found: String| {
        Breach::new(Service::Sdo, "SDO responses have eight bytes, and their reserved bytes are 0")
            .found(Observation::Named(found.into()))
    };
    let what = name(response);
    if frame.len() != 8 {
        let breach = breach(format!("{what} has {} bytes", frame.len())).expected("8 bytes");
        return Some(breach.told(format!("{} ({} bytes)", Bytes(frame.data()), frame.len())));
    }
    // The understood answer, encoded again, differs from the frame exactly in the reserved fields.
    let clean = response.to_frame(frame.cob_id().unwrap_or_default());
    let judged = carried(response);
    if clean.data().get(..judged) == frame.data().get(..judged) {
        return None;
    }
    let breach = breach(format!("{what} has reserved fields that are not 0"));
    Some(breach.expected(Bytes(clean.data()).to_string()).told(Bytes(frame.data()).to_string()))
}

/// Number of bytes of an answer that the standard defines. Of the bytes after them it says only that they hold no data.
fn carried(response: &Response) -> usize {
    match response {
        Response::UploadSegment(segment) => 1 + segment.data().len(),
        Response::InitiateUpload { payload: Payload::Expedited(value), .. } => 4 + value.data().len(),
        Response::InitiateUpload { payload: Payload::SegmentedUnsized, .. } => 4,
        // An unknown response is encoded as it came.
        _ => 8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scripted::{frame, with_bench};
    use canvass_analyzer::object;
    use canvass_bus::observation::Subject;
    use canvass_traces::Duration;

    /// The breaches of a case that uploads 1000h:00 twice from a server that gives this answer.
    fn breaches(answer: &'static str, judge: fn(&mut Bench<'_>)) -> Vec<Breach> {
        let script = move |request: &Frame| match request.to_string().as_str() {
            "63F#4000100000000000" => vec![(Duration::from_millis(1), frame(answer))],
            _ => Vec::new(),
        };
        with_bench(script, |bench| {
            for _ in 0..2 {
                bench.upload(Multiplexer::new(object::DEVICE_TYPE, 0)).unwrap();
            }
            judge(bench);
            bench.take_breaches(None)
        })
    }

    #[test]
    fn an_abort_that_names_another_object_is_a_breach_of_the_case_once() {
        let found = breaches("5BF#8001100000000206", |_| {});
        let [breach] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!(breach.subject, Subject::from(Multiplexer::new(object::DEVICE_TYPE, 0)));
        assert_eq!(
            breach.actual,
            Observation::Violation(Violation::Multiplexer(Multiplexer::new(object::ERROR_REGISTER, 0)))
        );
        assert_eq!(breaches("5BF#8000100000000206", |_| {}), []);
        assert_eq!(breaches("5BF#8001100000000405", |_| {}), [], "the time-out of an earlier transfer");
        let unjudged = |bench: &mut Bench<'_>| {
            bench.take_breaches(None);
            bench.unjudged(|bench| bench.upload(Multiplexer::new(object::DEVICE_TYPE, 0)).unwrap());
        };
        assert_eq!(breaches("5BF#8001100000000206", unjudged), []);
    }

    #[test]
    fn reserved_bits_and_bytes_are_judged_and_bytes_without_data_are_not() {
        let wrong = ["5BF#8100100000000206", "5BF#6000100000000001", "5BF#5300100000000000", "5BF#4F00100000"];
        for answer in wrong {
            let tidy = |bench: &mut Bench<'_>| bench.expect_tidy().unwrap();
            assert_eq!(breaches(answer, tidy).len(), 1, "{answer}");
        }
        for answer in [
            "5BF#4B001000010055AA",
            "5BF#4200100001020304",
            "5BF#4000100055AA55AA",
            "5BF#8000100000000206",
            "5BF#0D41AABBCCDDEEFF",
            "5BF#EEAABBCCDDEEFF01",
        ] {
            assert!(untidy(&Response::read(frame(answer).data()).unwrap(), &frame(answer)).is_none(), "{answer}");
        }
    }

    /// An answer is judged in the case that got it, not in the next case, and not while the tester finds out the
    /// features of the device.
    #[test]
    fn answers_are_judged_in_their_case() {
        const UNTIDY: &str = "5BF#8100100000000206";
        let tidy = |bench: &mut Bench<'_>| bench.expect_tidy().unwrap();
        assert_eq!(breaches(UNTIDY, tidy).len(), 1);
        assert_eq!(
            breaches(UNTIDY, |bench| {
                bench.begin();
                bench.expect_tidy().unwrap();
            }),
            []
        );
        let only_found_out = |bench: &mut Bench<'_>| {
            bench.begin();
            bench.unjudged(|bench| bench.upload(Multiplexer::new(object::DEVICE_TYPE, 0)).unwrap());
            bench.expect_tidy().unwrap();
        };
        assert_eq!(breaches(UNTIDY, only_found_out), []);
    }

    /// The first segment of a block may look like a wrong answer.
    #[test]
    fn a_segment_of_a_block_is_no_answer() {
        use canvass_analyzer::wire::sdo::Request;
        let judged = |request: Request, asked: &'static str| {
            let script = move |sent: &Frame| match sent.to_string().starts_with(asked) {
                true => vec![(Duration::from_millis(1), frame("5BF#60800000000000FF"))],
                false => Vec::new(),
            };
            with_bench(script, |bench| {
                bench.exchange(&request, "a message").unwrap();
                bench.expect_tidy().unwrap();
                bench.take_breaches(None).len()
            })
        };
        let upload = Request::upload(Multiplexer::new(object::DEVICE_TYPE, 0));
        assert_eq!((judged(Request::StartBlockUpload, "63F#A3"), judged(upload, "63F#40")), (0, 1));
    }

    /// Each reserved bit and byte of each answer, one at a time.
    #[test]
    fn every_reserved_field_is_judged() {
        let answers: [(&str, [u8; 8]); 11] = [
            ("4000100000000000", [0x1C, 0, 0, 0, 0, 0, 0, 0]),
            ("4100100005000000", [0x1C, 0, 0, 0, 0, 0, 0, 0]),
            ("6000100000000000", [0x1F, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF]),
            ("2000000000000000", [0x0F, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF]),
            ("4300100000000000", [0x10, 0, 0, 0, 0, 0, 0, 0]),
            ("8000100000000206", [0x1F, 0, 0, 0, 0, 0, 0, 0]),
            ("A40010007F000000", [0x18, 0, 0, 0, 0, 0xFF, 0xFF, 0xFF]),
            ("A2017F0000000000", [0x1C, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF]),
            ("A100000000000000", [0x1C, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF]),
            ("C400100000000000", [0x18, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF]),
            ("C100000000000000", [0x02, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF]),
        ];
        for (answer, reserved) in answers {
            let clean = frame(&format!("5BF#{answer}"));
            assert!(untidy(&Response::read(clean.data()).unwrap(), &clean).is_none(), "{answer}");
            for bit in (0..64).filter(|bit| reserved[bit / 8] & 1 << (bit % 8) != 0) {
                let mut bytes = clean.bytes();
                bytes[bit / 8] |= 1 << (bit % 8);
                let dirty = Frame::new(clean.id(), &bytes).unwrap();
                assert!(untidy(&Response::read(dirty.data()).unwrap(), &dirty).is_some(), "{answer}, bit {bit}");
            }
        }
    }
}
