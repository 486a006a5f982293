//! The common parts of the LSS and LMT slave models: the two states, parts in their order, and one request at a time.

use super::{Violation, silence, violation};
use crate::coverage::{Coverage, LssCommand, LssState};
use crate::property::Property;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::layer_setting::{Dialect, Limit, Numbered, Request, Response, SLAVE_CAN_ID};
use canvass_traces::{Frame, Timestamp};
use std::fmt::Debug;

/// The effect of a request outside the slave.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Effect {
    Nothing,
    /// A device without node-ID gets one and boots.
    Boots,
    /// The request has an effect that the models don't follow.
    Lost,
}

/// The answers that are allowed.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Awaited<D: Dialect, O> {
    Nothing,
    /// The standard leaves the answer open.
    Anything,
    Exactly(Response<D>),
    /// One of several responses.
    OneOf(O),
}

/// Alternative correct responses of a dialect.
pub(super) trait Options<D: Dialect>: Copy + PartialEq + Debug {
    /// Whether the options contain the response. `is_clean`: its reserved bytes are 0.
    fn contain(self, response: Response<D>, is_clean: bool) -> bool;
    /// The options in words.
    fn text(self) -> String;
}

/// The state of the slave, as far as it is known.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Mode {
    /// Waiting state of LSS, or operation mode of LMT.
    Waiting,
    Configuration,
    /// Unknown, after a request that the standard leaves open.
    Unsure,
}

/// The progress of an address or of bounds whose parts have to come in order.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct InOrder {
    /// Number of parts that have matched in order. `None`: a part came out of order, so that the number is not known.
    strictly: Option<usize>,
    /// Number of parts that have matched if parts of other addresses are ignored. The standard leaves open whether such
    /// parts end an address. `None`: not known.
    with_others: Option<usize>,
}

/// The parts of a slave's model that LSS and LMT have in common.
#[derive(Clone, Debug)]
pub(super) struct LayerSetting<D: Dialect, O> {
    pub mode: Mode,
    /// The progress of selective addressing.
    pub selected: InOrder,
    /// The progress of "identify remote slave".
    pub identified: InOrder,
    pub awaited: Awaited<D, O>,
    /// The service of the last request.
    pub rule: &'static str,
    pub property: Property,
    due: Timestamp,
    asked: (LssState, LssCommand),
    /// The last requests that may still be answered, each with its service. The latest is first.
    lately: [Option<(Request<D>, &'static str, Property)>; LATELY],
    /// A request whose answer was still due when the next request came, and the time until which the answer may come.
    owed: Option<(Request<D>, Timestamp)>,
}

/// Maximum number of requests that wait for their answers.
const LATELY: usize = 8;

impl InOrder {
    pub const NONE: Self = Self { strictly: Some(0), with_others: Some(0) };
    pub const UNKNOWN: Self = Self { strictly: None, with_others: None };

    /// Records a part or bound that came. `fits`: it matches the slave's address.
    pub fn came(&mut self, which: impl Numbered, fits: bool) {
        let position = which.position();
        if fits && Some(position) == self.with_others {
            self.with_others = Some(position + 1);
        }
        self.strictly = match self.strictly {
            _ if position == 0 && fits => Some(1),
            Some(matched) if matched == position => Some(if fits { matched + 1 } else { 0 }),
            None => None,
            // A repeated part, or a part out of order, may count or begin an address anew.
            Some(matched) if fits && matched > 0 => None,
            Some(_) => Some(0),
        };
    }

    /// Records that the last part came. Returns whether all parts have matched; `None`: not known.
    pub fn end<N: Numbered>(&mut self) -> Option<bool> {
        let among_others = self.with_others.is_none_or(|matched| matched == N::ALL.len());
        if self.with_others == Some(N::ALL.len()) {
            self.with_others = Some(0);
        }
        match self.strictly.replace(0).map(|matched| matched == N::ALL.len()) {
            Some(false) if among_others => None,
            all => all,
        }
    }

    /// Whether some parts have matched since the last part that did not match.
    pub fn has_begun(self) -> bool {
        self.strictly.is_some_and(|matched| matched > 0)
    }
}

impl<D: Dialect, O: Options<D>> LayerSetting<D, O> {
    pub const fn new(mode: Mode) -> Self {
        Self {
            mode,
            lately: [None; LATELY],
            owed: None,
            selected: InOrder::NONE,
            identified: InOrder::NONE,
            awaited: Awaited::Nothing,
            rule: "",
            property: Property::LegalLss,
            due: Timestamp::MAX,
            asked: (LssState::Waiting, LssCommand::Unknown),
        }
    }

    /// The state of the slave for the coverage. States without node-ID are counted elsewhere.
    pub fn class(&self) -> LssState {
        match self.mode {
            Mode::Configuration => LssState::Configuration,
            _ if self.selected.has_begun() => LssState::Selecting,
            _ => LssState::Waiting,
        }
    }

    /// Whether any answer is allowed.
    pub fn is_open(&self) -> bool {
        self.awaited == Awaited::Anything
    }

    /// Whether the slave is in waiting state and owes no answer.
    pub fn is_at_rest(&self) -> bool {
        self.mode == Mode::Waiting && self.awaited == Awaited::Nothing
    }

    pub fn due(&self) -> Option<Timestamp> {
        (self.due < Timestamp::MAX).then_some(self.due)
    }

    /// Reads a request. The effect of any other frame is unknown: a slave may fill a short frame up and take it for a
    /// part of an address.
    pub fn read(&mut self, frame: &Frame) -> Option<Request<D>> {
        let request = Request::read(frame.data()).ok().filter(|_| frame.len() == 8);
        if request.is_none() {
            (self.mode, self.selected, self.identified) = (Mode::Unsure, InOrder::UNKNOWN, InOrder::UNKNOWN);
        }
        request
    }

    /// Applies "switch global".
    pub const fn switch(&mut self, mode: u8) {
        self.selected = InOrder::NONE;
        self.mode = match mode {
            0 => Mode::Waiting,
            1 => Mode::Configuration,
            // Reserved modes.
            _ => Mode::Unsure,
        };
    }

    /// Applies a bound of "identify remote slave". `fits`: the bound includes the slave's own value.
    pub fn identify(&mut self, bound: D::Bound, fits: bool) -> Awaited<D, O> {
        self.identified.came(bound, fits);
        if !bound.is_last() {
            return Awaited::Nothing;
        }
        match self.identified.end::<D::Bound>() {
            Some(true) => Awaited::Exactly(Response::Identified),
            Some(false) => Awaited::Nothing,
            None => Awaited::Anything,
        }
    }

    /// Records a request that came while the slave was in the state `class`. Its answer is overdue at `due`. If an
    /// answer was still due, nobody knows which of the two requests the next answer belongs to.
    pub fn asked(
        &mut self,
        (class, frame): (LssState, &Frame),
        awaited: Awaited<D, O>,
        due: Timestamp,
        coverage: &mut Coverage,
    ) {
        self.asked = (class, LssCommand::of::<D>(frame));
        self.awaited = awaited;
        if self.due < Timestamp::MAX {
            (self.awaited, self.mode) = (Awaited::Anything, Mode::Unsure);
            self.owe(self.due);
        }
        self.remember(frame);
        if self.is_open() && matches!(self.lately[0], Some((Request::StoreConfiguration, ..))) {
            // Storing takes longer than the required silence.
            self.owe(due);
        }
        let is_required = !matches!(self.awaited, Awaited::Nothing | Awaited::Anything);
        if !is_required {
            coverage.lss(self.asked.0, self.asked.1, false);
        }
        self.due = if is_required { due } else { Timestamp::MAX };
    }

    /// Allows an answer to the last request until the time `until`, even if other frames come meanwhile.
    fn owe(&mut self, until: Timestamp) {
        self.owed = self.lately[0].map(|(request, ..)| (request, until));
    }

    fn remember(&mut self, frame: &Frame) {
        self.lately.rotate_right(1);
        self.lately[0] = Request::read(frame.data()).ok().map(|request| (request, self.rule, self.property));
    }

    /// Handles the end of the required silence: the slave answers no earlier request any more, except one whose answer
    /// takes long.
    pub fn quiet(&mut self, now: Timestamp) {
        if self.owed.is_some_and(|(_, until)| now < until) {
            return;
        }
        self.owed = None;
        self.lately = [None; LATELY];
        if self.is_open() {
            self.awaited = Awaited::Nothing;
        }
    }

    /// The position of the latest request that the response answers.
    fn asked_lately(&self, response: Response<D>) -> Option<usize> {
        self.lately.iter().position(|asked| asked.is_some_and(|(request, ..)| response.answers(request)))
    }

    /// Checks a frame of the slave.
    ///
    /// # Errors
    /// [`Violation`] if the slave must not send it now.
    pub fn answered(&mut self, now: Timestamp, frame: &Frame, coverage: &mut Coverage) -> Result<(), Violation> {
        let response = Response::<D>::read(frame.data()).ok().filter(|_| frame.len() == 8);
        let awaited = self.awaited;
        let fits = response.is_some_and(|actual| {
            let is_clean = actual.to_frame(SLAVE_CAN_ID).bytes() == frame.bytes();
            match awaited {
                Awaited::Nothing => false,
                Awaited::Anything => true,
                Awaited::Exactly(expected) => same(expected, actual) && is_clean,
                Awaited::OneOf(options) => options.contain(actual, is_clean),
            }
        });
        coverage.lss(self.asked.0, self.asked.1, true);
        if awaited != Awaited::Anything {
            self.awaited = Awaited::Nothing;
        }
        self.due = Timestamp::MAX;
        let answered = response.and_then(|response| self.asked_lately(response));
        if let (Some((owed, _)), Some(response)) = (self.owed, response)
            && response.answers(owed)
        {
            self.owed = None;
        }
        if fits {
            // Requests before the answered request are not answered any more.
            self.lately[answered.unwrap_or(LATELY)..].fill(None);
            return Ok(());
        }
        let actual = response.map_or_else(|| format!("{frame}"), |response| format!("{response} ({frame})"));
        let earlier = answered.filter(|&at| at > 0).and_then(|at| self.lately[at]);
        Err(match earlier {
            Some((_, rule, property)) => violation(property, rule, unanswered::<D>(rule), actual, now),
            None => violation(self.property, self.rule, self.text(awaited), actual, now),
        })
    }

    fn text(&self, awaited: Awaited<D, O>) -> String {
        match awaited {
            Awaited::Nothing => unanswered::<D>(self.rule),
            Awaited::Anything => "an answer of eight bytes, or none".to_owned(),
            Awaited::Exactly(response) => format!("{response}, reserved bytes 0"),
            Awaited::OneOf(options) => options.text(),
        }
    }

    /// Checks whether an answer is overdue.
    ///
    /// # Errors
    /// [`Violation`] if an answer is due and has not come.
    pub fn expire(&mut self, now: Timestamp) -> Result<(), Violation> {
        if now < self.due {
            return Ok(());
        }
        self.due = Timestamp::MAX;
        let awaited = std::mem::replace(&mut self.awaited, Awaited::Nothing);
        Err(silence(self.property, self.rule, self.text(awaited), now))
    }
}

fn unanswered<D: Dialect>(rule: &str) -> String {
    format!("no answer to \"{rule}\" in this {}", D::STATE)
}

/// Whether a bound of "identify remote slave" includes the part of the own address.
pub(super) fn includes<D: Dialect>(limit: Limit, bound: D::Value, own: D::Value) -> bool {
    match limit {
        Limit::Equal => bound == own,
        Limit::Lowest => bound <= own,
        Limit::Highest => bound >= own,
    }
}

/// Whether the actual response is the expected response. A device may report an error by code 1, or by 255 with a code
/// of the manufacturer.
fn same<D: Dialect>(expected: Response<D>, actual: Response<D>) -> bool {
    match (expected, actual) {
        (
            Response::Configured { command, error: 1, .. },
            Response::Configured { command: actual, error: 1 | 255, .. },
        ) => command == actual,
        _ => expected == actual,
    }
}

#[cfg(test)]
mod tests {
    use super::super::lss::OneOf;
    use super::*;
    use canvass_analyzer::wire::layer_setting::MASTER_CAN_ID;
    use canvass_analyzer::wire::lss::{self, Lss, Part};

    const SELECT: Request<Lss> = Request::SwitchSelective { part: Part::SerialNumber, value: 7 };

    /// A slave that got both requests, one right after the other.
    fn asked(first: Awaited<Lss, OneOf>) -> LayerSetting<Lss, OneOf> {
        let mut at = LayerSetting::new(Mode::Waiting);
        for (rule, request, awaited) in
            [("switch state selective", SELECT, first), ("inquire node-ID", Request::InquireNodeId, Awaited::Nothing)]
        {
            at.rule = rule;
            let frame = request.to_frame(MASTER_CAN_ID);
            at.asked((LssState::Waiting, &frame), awaited, Timestamp::MAX, &mut Coverage::default());
        }
        at
    }

    fn rule_of(at: &mut LayerSetting<Lss, OneOf>, response: lss::Response) -> &'static str {
        let frame = response.to_frame(SLAVE_CAN_ID);
        at.answered(Timestamp::ZERO, &frame, &mut Coverage::default()).unwrap_err().rule
    }

    /// 43h is answered with 44h, and 5Eh with 5Eh (CiA 305).
    #[test]
    fn an_answer_counts_for_the_request_that_it_alone_answers() {
        let mut at = asked(Awaited::Nothing);
        assert_eq!(rule_of(&mut at, Response::Switched), "switch state selective");
        let mut at = asked(Awaited::Nothing);
        assert_eq!(rule_of(&mut at, Response::NodeId(5)), "inquire node-ID");
        let mut at = asked(Awaited::Nothing);
        at.quiet(Timestamp::ZERO);
        assert_eq!(rule_of(&mut at, Response::Switched), "inquire node-ID", "silence has lasted since");
    }

    #[test]
    fn what_was_answered_is_not_answered_again() {
        let mut at = LayerSetting::<Lss, OneOf>::new(Mode::Waiting);
        at.rule = "switch state selective";
        let (select, switched) = (SELECT.to_frame(MASTER_CAN_ID), Response::<Lss>::Switched.to_frame(SLAVE_CAN_ID));
        let awaited = Awaited::Exactly(Response::Switched);
        at.asked((LssState::Selecting, &select), awaited, Timestamp::MAX, &mut Coverage::default());
        at.answered(Timestamp::ZERO, &switched, &mut Coverage::default()).unwrap();
        at.rule = "inquire node-ID";
        let inquire = Request::<Lss>::InquireNodeId.to_frame(MASTER_CAN_ID);
        at.asked((LssState::Configuration, &inquire), Awaited::Nothing, Timestamp::MAX, &mut Coverage::default());
        assert_eq!(rule_of(&mut at, Response::Switched), "inquire node-ID");
    }

    /// Feeds parts of the slave's own address or of other addresses one after the other. Returns whether the slave is
    /// then addressed.
    #[test]
    fn parts_of_others_leave_open_whether_the_address_goes_on() {
        let end = |parts: &[(Part, bool)]| {
            let mut selected = InOrder::NONE;
            parts.iter().for_each(|&(part, fits)| selected.came(part, fits));
            selected.end::<Part>()
        };
        let own = Part::ALL.map(|part| (part, true));
        assert_eq!(end(&own), Some(true));
        for (at, part) in Part::ALL.into_iter().enumerate() {
            let mut wrong = own.to_vec();
            wrong[at] = (part, false);
            assert_eq!(end(&wrong), Some(false), "{part:?} of another one");
            let mut among = own.to_vec();
            among.insert(at, (part, false));
            let expected = if at == 0 { Some(true) } else { None };
            assert_eq!(end(&among), expected, "{part:?} of another one, then the own");
        }
        assert_eq!(end(&[own[0], (Part::SerialNumber, false), own[3]]), Some(false), "two parts never came");
        let mut unknown = InOrder::UNKNOWN;
        [(Part::SerialNumber, false), own[2]].iter().for_each(|&(part, fits)| unknown.came(part, fits));
        unknown.end::<Part>();
        unknown.came(Part::SerialNumber, true);
        assert_eq!(unknown.end::<Part>(), None, "the first two may have come before");
    }

    /// After silence an optional answer is not expected any more, except the answer to a store, which takes long. A
    /// required answer may still come after the next request, until its time is over.
    #[test]
    fn silence_ends_what_is_open_unless_an_answer_is_owed() {
        let open = |requests: &[(Request<Lss>, Awaited<Lss, OneOf>)], after: u64| {
            let mut at = LayerSetting::<Lss, OneOf>::new(Mode::Unsure);
            for (request, awaited) in requests {
                let frame = request.to_frame(MASTER_CAN_ID);
                at.asked((LssState::Waiting, &frame), *awaited, Timestamp(1_000), &mut Coverage::default());
            }
            at.quiet(Timestamp(after));
            at.is_open()
        };
        let inquire = (Request::InquireNodeId, Awaited::Anything);
        let store = (Request::StoreConfiguration, Awaited::Anything);
        let configure = (Request::ConfigureNodeId { node_id: 5 }, Awaited::OneOf(OneOf::Stored));
        for (requests, is_open) in [
            (&[inquire][..], false),
            (&[store], true),
            (&[store, inquire], true),
            (&[configure, inquire], true),
            (&[configure, inquire, inquire], true),
        ] {
            assert_eq!(open(requests, 999), is_open, "{requests:?}");
            assert!(!open(requests, 1_000), "{requests:?}");
        }
    }
}
