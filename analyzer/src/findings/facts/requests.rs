//! The unanswered requests on each SDO channel.

use crate::Multiplexer;
use crate::findings::Seen;
use crate::message::{Message, Service};
use crate::network::Decoded;
use crate::network::sdo::ChannelIndex;
use crate::object;
use crate::wire::nmt::Command;
use crate::wire::sdo::Request;
use canvass_traces::{Duration, Record, Timestamp};

/// The unanswered requests.
#[derive(Default)]
pub struct Requests {
    channels: Vec<Option<Pending>>,
    /// The latest abandoned requests with their times: answers may still come.
    left: Vec<Left>,
}

/// An abandoned request.
struct Left {
    channel: ChannelIndex,
    pending: Pending,
    since: Timestamp,
    /// Whether the client has abandoned the request; else a restart of the node has ended it.
    by_client: bool,
}

/// An unanswered request.
#[derive(Clone)]
pub struct Pending {
    /// The request.
    pub request: Seen,
    /// Time at which the request was first sent.
    pub since: Timestamp,
    /// Number of times that the request was sent.
    pub times: u32,
    /// The object of the transfer.
    pub object: Option<Multiplexer>,
    /// Whether the node could not answer at that time: it was not seen yet, or was reset and had not booted yet.
    pub early: bool,
}

/// The effect of a frame on the requests.
#[derive(Default)]
pub enum RequestEvent {
    /// No effect.
    #[default]
    None,
    /// An answer came.
    Answered(Pending),
    /// The client sent another request, so it does not wait any more.
    GivenUp(Pending),
    /// The answer to an abandoned request came.
    AnsweredLate {
        /// The request.
        pending: Pending,
        /// Time at which it was abandoned.
        gave_up: Timestamp,
        /// Whether the client abandoned the request; else a restart of the node ended it.
        by_client: bool,
    },
    /// The client sent the same request again.
    Repeated,
}

impl RequestEvent {
    /// Whether a request was repeated or abandoned, or an abandoned request was answered.
    #[inline]
    pub(crate) const fn is_unusual(&self) -> bool {
        !matches!(self, Self::None | Self::Answered(_))
    }
}

impl Requests {
    /// Maximum number of abandoned requests that are remembered.
    const LEFT: usize = 32;
    const REMEMBERED: Duration = Duration::from_secs(10);
    /// Copies that an interface loops back come within this time.
    const COPY: Duration = Duration::from_millis(1);

    /// Handles an SDO frame, a boot-up or an NMT command. `absent`: the node of the frame can't answer.
    pub fn frame(&mut self, record: &Record, decoded: &Decoded, absent: bool) -> RequestEvent {
        let Some(channel) = decoded.channel.filter(|_| decoded.service == Service::Sdo) else {
            self.forget_node(record.timestamp, decoded);
            return RequestEvent::None;
        };
        match decoded.message {
            Message::SdoRequest(Request::Abort(_)) => match self.slot(channel).take() {
                Some(pending) => self.give_up(channel, pending, record.timestamp),
                None => RequestEvent::None,
            },
            // The server does not answer the end of a block upload, nor the segments of a block one by one.
            Message::SdoRequest(Request::EndBlockUpload) | Message::SdoBlockDownload(_) => {
                *self.slot(channel) = None;
                RequestEvent::None
            }
            Message::SdoRequest(_) => self.request(channel, record, decoded, absent),
            Message::SdoResponse(response) => match self.left(channel, response.multiplexer(), record.timestamp) {
                Some(late) => late,
                None => self.slot(channel).take().map_or(RequestEvent::None, RequestEvent::Answered),
            },
            Message::SdoBlockUpload(_) => self.slot(channel).take().map_or(RequestEvent::None, RequestEvent::Answered),
            _ => RequestEvent::None,
        }
    }

    fn request(&mut self, channel: ChannelIndex, record: &Record, decoded: &Decoded, early: bool) -> RequestEvent {
        let now = record.timestamp;
        let request = Seen { record: record.clone(), decoded: *decoded };
        let pending = Pending { request, since: now, times: 1, object: decoded.object, early };
        let slot = self.slot(channel);
        let Some(open) = slot.as_mut() else {
            *slot = Some(pending);
            return RequestEvent::None;
        };
        let same = open.request.record.frame == record.frame;
        let elapsed = now.since(open.since);
        match same {
            true if elapsed <= Self::COPY => RequestEvent::None,
            true => {
                (open.since, open.times) = (now, open.times.saturating_add(1));
                RequestEvent::Repeated
            }
            false => match slot.replace(pending) {
                Some(open) => self.give_up(channel, open, now),
                None => RequestEvent::None,
            },
        }
    }

    /// Handles a request whose client does not wait any more.
    #[cold]
    fn give_up(&mut self, channel: ChannelIndex, pending: Pending, now: Timestamp) -> RequestEvent {
        if self.left.len() >= Self::LEFT {
            self.left.remove(0);
        }
        self.left.push(Left { channel, pending: pending.clone(), since: now, by_client: true });
        RequestEvent::GivenUp(pending)
    }

    /// The event of an answer about `object`, if its request was abandoned and no waiting request concerns the same
    /// object.
    #[inline]
    fn left(&mut self, channel: ChannelIndex, object: Option<Multiplexer>, now: Timestamp) -> Option<RequestEvent> {
        if self.left.is_empty() {
            return None;
        }
        self.left.retain(|left| now.since(left.since) <= Self::REMEMBERED);
        let object = object?;
        let open = self.channels.get(usize::from(channel.0)).and_then(Option::as_ref);
        if open.is_some_and(|open| open.object == Some(object)) {
            return None;
        }
        let at = self.left.iter().position(|left| left.channel == channel && left.pending.object == Some(object))?;
        // Each sending of the request may get an answer.
        let left = self.left.get_mut(at)?;
        let (gave_up, by_client) = (left.since, left.by_client);
        let pending = left.pending.clone();
        left.pending.times = left.pending.times.saturating_sub(1);
        if left.pending.times == 0 {
            self.left.remove(at);
        }
        Some(RequestEvent::AnsweredLate { pending, gave_up, by_client })
    }

    /// A restarting node forgets its requests, unless they wait in a queue.
    fn forget_node(&mut self, now: Timestamp, decoded: &Decoded) {
        let named = match decoded.message {
            // A change to operational or pre-operational does not disturb a transfer.
            Message::Nmt(nmt) if matches!(nmt.command, Command::START | Command::ENTER_PRE_OPERATIONAL) => return,
            Message::Nmt(nmt) => nmt.node,
            _ => decoded.node.map_or(0, |node| node.raw()),
        };
        for (channel, slot) in (0..).map(ChannelIndex).zip(&mut self.channels) {
            let server = slot.as_ref().and_then(|pending| pending.request.decoded.node);
            let is_named = named == 0 || server.is_some_and(|server| server.raw() == named);
            if is_named
                && let Some(pending) = slot.take()
                && self.left.len() < Self::LEFT
            {
                self.left.push(Left { channel, pending, since: now, by_client: false });
            }
        }
    }

    fn slot(&mut self, channel: ChannelIndex) -> &mut Option<Pending> {
        let at = usize::from(channel.0);
        if self.channels.len() <= at {
            self.channels.resize_with(at + 1, || None);
        }
        &mut self.channels[at]
    }

    /// All unanswered requests, with their channels.
    pub fn open(&self) -> impl Iterator<Item = (ChannelIndex, &Pending)> {
        let channels = (0_u16..).map(ChannelIndex).zip(&self.channels);
        channels.filter_map(|(channel, pending)| Some((channel, pending.as_ref()?)))
    }

    /// Tells that answers may be missing in the capture.
    pub fn interrupted(&mut self) {
        self.channels.fill_with(|| None);
        self.left.clear();
    }
}

impl Pending {
    /// Whether the request stores or restores parameters, which takes some devices seconds.
    pub fn is_store(&self) -> bool {
        self.object.is_some_and(|object| {
            matches!(
                object.index.0,
                object::STORE_PARAMETERS
                    | object::RESTORE_DEFAULT_PARAMETERS
                    | object::PROGRAM_DATA
                    | object::PROGRAM_CONTROL
            )
        })
    }

    /// ` for 6004h:00`, if the object is known.
    pub fn about(&self) -> String {
        self.object.map(|object| format!(" for {object}")).unwrap_or_default()
    }

    /// The object as a number, to tell findings apart.
    pub fn detail(&self) -> u64 {
        self.object.map_or(0, |object| u64::from(object.index.0) << 8 | u64::from(object.sub.0))
    }
}
