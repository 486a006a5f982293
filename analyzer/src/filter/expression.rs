//! The tree of a filter, and its evaluation.

use super::parser::{self, FilterError};
use crate::message::{Message, Service};
use crate::network::{Decoded, Steady};
use crate::wire::sdo::{Request, Response};
use canvass_traces::{Direction, Record};
use std::ops::RangeInclusive;
use std::str::FromStr;

/// A filter for frames.
///
/// ```
/// use canvass_analyzer::filter::{Filter, Subject};
/// use canvass_analyzer::network::Network;
/// use canvass_traces::parse_frame;
///
/// let refusals: Filter = "service=sdo and node=5 and abort".parse()?;
/// let record = parse_frame("585#8018100411000906").unwrap();
/// let decoded = Network::new().handle(&record);
/// assert!(refusals.matches(&Subject { record: &record, decoded: &decoded, channel: "can0" }));
/// assert!("servce=sdo".parse::<Filter>().is_err());
/// # Ok::<(), canvass_analyzer::filter::FilterError>(())
/// ```
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Filter(pub(super) Expression);

#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Expression {
    Or(Vec<Expression>),
    And(Vec<Expression>),
    Not(Box<Expression>),
    Number { field: NumberField, ranges: Vec<RangeInclusive<u32>>, negated: bool },
    Service { services: Vec<Service>, negated: bool },
    Channel { names: Vec<String>, negated: bool },
    Flag(Flag),
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum NumberField {
    Node,
    Id,
    Index,
    Sub,
    Len,
    Abort,
    Emcy,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Flag {
    Abort,
    Emcy,
    Violation,
    Remote,
    Extended,
    Fd,
    Error,
    Tx,
    Rx,
}

/// The input of a filter.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// The frame.
    pub record: &'a Record,
    /// The decoded frame.
    pub decoded: &'a Decoded,
    /// The name of the frame's channel.
    pub channel: &'a str,
}

impl FromStr for Filter {
    type Err = FilterError;

    fn from_str(text: &str) -> Result<Self, FilterError> {
        parser::parse(text).map(Self)
    }
}

impl Filter {
    /// Whether the frame passes.
    pub fn matches(&self, subject: &Subject<'_>) -> bool {
        self.0.matches(subject)
    }

    /// Whether the filter rejects this frame and all frames like it.
    pub fn refuses_alike(&self, subject: &Subject<'_>, steady: Steady) -> bool {
        self.0.of_alike(subject, steady) == Some(false)
    }
}

impl Expression {
    fn matches(&self, subject: &Subject<'_>) -> bool {
        match self {
            Self::Or(terms) => terms.iter().any(|term| term.matches(subject)),
            Self::And(terms) => terms.iter().all(|term| term.matches(subject)),
            Self::Not(term) => !term.matches(subject),
            Self::Number { field, ranges, negated } => {
                field.of(subject).is_some_and(|value| ranges.iter().any(|range| range.contains(&value)) != *negated)
            }
            Self::Service { services, negated } => services.contains(&subject.decoded.service) != *negated,
            Self::Channel { names, negated } => names.iter().any(|name| name == subject.channel) != *negated,
            Self::Flag(flag) => flag.of(subject),
        }
    }
}

impl Expression {
    /// The result that holds for all frames like this one; `None` if their results differ.
    fn of_alike(&self, subject: &Subject<'_>, steady: Steady) -> Option<bool> {
        let decided = |terms: &[Self], by: bool| {
            let told: Vec<Option<bool>> = terms.iter().map(|term| term.of_alike(subject, steady)).collect();
            if told.contains(&Some(by)) { Some(by) } else { (!told.contains(&None)).then_some(!by) }
        };
        match self {
            Self::Or(terms) => decided(terms, true),
            Self::And(terms) => decided(terms, false),
            Self::Not(term) => term.of_alike(subject, steady).map(|told| !told),
            Self::Number { field: NumberField::Len, .. } | Self::Flag(Flag::Tx | Flag::Rx) => None,
            Self::Number { field: NumberField::Id, .. } if steady == Steady::Extended => None,
            Self::Number { .. } | Self::Service { .. } | Self::Channel { .. } | Self::Flag(_) => {
                Some(self.matches(subject))
            }
        }
    }
}

impl NumberField {
    pub(super) const NAMES: [(&'static str, Self); 7] = [
        ("node", Self::Node),
        ("id", Self::Id),
        ("index", Self::Index),
        ("sub", Self::Sub),
        ("len", Self::Len),
        ("abort", Self::Abort),
        ("emcy", Self::Emcy),
    ];

    fn of(self, subject: &Subject<'_>) -> Option<u32> {
        let Subject { record, decoded, .. } = subject;
        match self {
            Self::Node => decoded.node.map(|node| u32::from(node.raw())),
            Self::Id => (!record.frame.is_error()).then(|| record.frame.id().raw()),
            Self::Index => decoded.object.map(|object| u32::from(object.index.0)),
            Self::Sub => decoded.object.map(|object| u32::from(object.sub.0)),
            Self::Len => Some(record.frame.len() as u32),
            Self::Abort => abort_code(&decoded.message),
            Self::Emcy => match decoded.message {
                Message::Emcy(emcy) => emcy.code().map(|code| u32::from(code.0)),
                _ => None,
            },
        }
    }
}

impl Flag {
    pub(super) const NAMES: [(&'static str, Self); 9] = [
        ("abort", Self::Abort),
        ("emcy", Self::Emcy),
        ("violation", Self::Violation),
        ("remote", Self::Remote),
        ("extended", Self::Extended),
        ("fd", Self::Fd),
        ("error", Self::Error),
        ("tx", Self::Tx),
        ("rx", Self::Rx),
    ];

    fn of(self, subject: &Subject<'_>) -> bool {
        let Subject { record, decoded, .. } = subject;
        match self {
            Self::Abort => abort_code(&decoded.message).is_some(),
            Self::Emcy => matches!(decoded.message, Message::Emcy(_)),
            Self::Violation => decoded.violation.is_some(),
            Self::Remote => record.frame.is_remote(),
            Self::Extended => record.frame.id().is_extended() && !record.frame.is_error(),
            Self::Fd => record.frame.is_fd(),
            Self::Error => record.frame.is_error(),
            Self::Tx => record.direction == Direction::Tx,
            Self::Rx => record.direction == Direction::Rx,
        }
    }
}

fn abort_code(message: &Message) -> Option<u32> {
    match message {
        Message::SdoRequest(Request::Abort(abort)) | Message::SdoResponse(Response::Abort(abort)) => Some(abort.code.0),
        _ => None,
    }
}
