//! Series of requests by which the master addresses one slave, or a range of slaves.

use super::exchange::own_command;
use crate::findings::Context;
use crate::message::Message;
use crate::wire::{lmt, lss};

/// The series that the master sends now.
#[derive(Clone, Copy, Default)]
pub struct Series {
    open: Option<Open>,
    /// Whether a request came before.
    began: bool,
}

/// A series that has begun.
#[derive(Clone, Copy)]
struct Open {
    /// The command specifier of the first request.
    first: u8,
    /// Number of requests.
    count: u8,
    /// The place, from 0, of the next request.
    next: u8,
    /// The value of the last request.
    value: [u8; 7],
    /// Whether the lowest and the highest value of each bound are equal so far.
    is_exact: bool,
}

/// The place of a request in the series.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Step {
    /// The request belongs to no series, or is in its place.
    Regular,
    /// The request completes a series.
    Complete {
        /// Whether the series identifies a single address.
        is_exact: bool,
    },
    /// The request repeats the request before it with another value.
    Again,
    /// The request comes in the place of the request with this command specifier.
    Misplaced(u8),
    /// The series before this request is incomplete: it lacks the request with this command specifier.
    CutShort(u8),
}

/// The series of a request: its first command specifier, the place of the request from 0, and the number of requests.
fn place(message: &Message, command: u8) -> Option<(u8, u8, u8)> {
    use crate::wire::layer_setting::Request::{IdentifyRemote, SwitchSelective};
    let of = |first: u8, count: usize| Some((first, command - first, count as u8));
    match message {
        Message::LssRequest(SwitchSelective { .. }) => of(0x40, lss::Part::ALL.len()),
        Message::LssRequest(IdentifyRemote { .. }) => of(0x46, lss::Bound::ALL.len()),
        Message::LmtRequest(SwitchSelective { .. }) => of(0x01, lmt::Part::ALL.len()),
        Message::LmtRequest(IdentifyRemote { .. }) => of(0x05, lmt::Bound::ALL.len()),
        _ => None,
    }
}

/// Whether a request of this command specifier has the upper bound of the one before it.
const fn is_upper_bound(command: u8) -> bool {
    matches!(command, 0x49 | 0x4B | 0x08)
}

impl Series {
    /// Handles a request of the master. `is_early` tells that the requests before it may have preceded the capture.
    pub fn see(&mut self, context: &Context<'_>, is_early: bool) -> Step {
        let is_early = is_early && !std::mem::replace(&mut self.began, true);
        let command = own_command(context);
        let Some((first, at, count)) = place(context.message(), command) else {
            return self.end();
        };
        let mut value = [0; 7];
        let sent = context.record.frame.data().get(1..8).unwrap_or(&[]);
        value[..sent.len()].copy_from_slice(sent);
        let same = self.open.filter(|open| open.first == first && (at > 0 || open.next == 1));
        let Some(open) = same else {
            let cut = self.end();
            self.open = Some(Open { first, count, next: at + 1, value, is_exact: at == 0 });
            return match (cut, at) {
                (Step::CutShort(_), _) => cut,
                (_, 0) => Step::Regular,
                _ if is_early => Step::Regular,
                _ => Step::Misplaced(first),
            };
        };
        let differs = is_upper_bound(command) && open.value != value;
        self.open = Some(Open { next: at + 1, value, is_exact: open.is_exact && !differs, ..open });
        if at + 1 == open.next {
            return if open.value == value { Step::Regular } else { Step::Again };
        }
        if at != open.next {
            return Step::Misplaced(first + open.next.min(count - 1));
        }
        let is_exact = open.is_exact && !differs && first != 0x40 && first != 0x01;
        if at + 1 == count { Step::Complete { is_exact } } else { Step::Regular }
    }

    /// Ends the series; returns whether it was cut short.
    fn end(&mut self) -> Step {
        let open = self.open.take();
        let missing = open.filter(|open| open.next < open.count);
        missing.map_or(Step::Regular, |open| Step::CutShort(open.first + open.next))
    }

    /// Tells that requests may be missing here.
    pub fn interrupted(&mut self) {
        *self = Self::default();
    }
}
