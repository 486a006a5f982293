//! The requests that wait for an answer, on each SDO channel.

use crate::Multiplexer;
use crate::findings::{Context, Seen};
use crate::message::{Message, Service};
use crate::network::sdo::ChannelIndex;
use crate::wire::nmt::Command;
use crate::wire::sdo::Request;
use canvass_traces::{Duration, Timestamp};

/// The services that requests are followed by.
pub const SERVICES: &[Service] = &[Service::Sdo, Service::BootUp, Service::Nmt];

/// The requests that wait for an answer.
#[derive(Default)]
pub struct Requests {
    channels: Vec<Option<Pending>>,
}

/// A request that waits for its answer.
pub struct Pending {
    /// The request.
    pub request: Seen,
    /// When it was sent.
    pub since: Timestamp,
    /// The object that the transfer is about.
    pub object: Option<Multiplexer>,
    /// Whether it was reported already.
    pub told: bool,
}

/// What a frame did to the requests.
pub enum Step {
    /// Nothing that counts.
    None,
    /// An answer came.
    Answered(Pending),
    /// The client sent something else: it does not wait any more.
    GivenUp(Pending),
    /// The client sent the same request again.
    Repeated,
}

impl Requests {
    /// Copies that an interface loops back come within this time.
    const COPY: Duration = Duration::from_millis(1);

    /// Takes a frame.
    pub fn frame(&mut self, context: &Context<'_>) -> Step {
        let Some(channel) = context.decoded.channel else {
            self.forget_node(context);
            return Step::None;
        };
        match context.message() {
            Message::SdoRequest(Request::Abort(_)) => match self.slot(channel).take() {
                Some(pending) => Step::GivenUp(pending),
                None => Step::None,
            },
            // The server does not answer the end of a block upload, nor segments of a block one by one.
            Message::SdoRequest(Request::EndBlockUpload) | Message::SdoBlockDownload(_) => {
                *self.slot(channel) = None;
                Step::None
            }
            Message::SdoRequest(_) => self.request(channel, context),
            Message::SdoResponse(_) | Message::SdoBlockUpload(_) => {
                self.slot(channel).take().map_or(Step::None, Step::Answered)
            }
            _ => Step::None,
        }
    }

    fn request(&mut self, channel: ChannelIndex, context: &Context<'_>) -> Step {
        let pending =
            Pending { request: context.seen(), since: context.now(), object: context.decoded.object, told: false };
        let slot = self.slot(channel);
        let Some(open) = slot.as_mut() else {
            *slot = Some(pending);
            return Step::None;
        };
        let same = open.request.record.frame == context.record.frame;
        let elapsed = context.now().since(open.since);
        match same {
            true if elapsed <= Self::COPY => Step::None,
            true => {
                open.since = context.now();
                Step::Repeated
            }
            false => slot.replace(pending).map_or(Step::None, Step::GivenUp),
        }
    }

    /// A node that restarts has forgotten what it was asked.
    fn forget_node(&mut self, context: &Context<'_>) {
        let named = match context.message() {
            // Going to operational or pre-operational does not disturb a transfer.
            Message::Nmt(nmt) if matches!(nmt.command, Command::START | Command::ENTER_PRE_OPERATIONAL) => return,
            Message::Nmt(nmt) => nmt.node,
            _ => context.node().map_or(0, |node| node.raw()),
        };
        for slot in &mut self.channels {
            let server = slot.as_ref().and_then(|pending| pending.request.decoded.node);
            if named == 0 || server.is_some_and(|server| server.raw() == named) {
                *slot = None;
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

    /// All requests that wait.
    pub fn open(&mut self) -> impl Iterator<Item = &mut Pending> {
        self.channels.iter_mut().flatten()
    }

    /// Answers may have come unseen.
    pub fn interrupted(&mut self) {
        self.channels.fill_with(|| None);
    }
}

impl Pending {
    /// Whether it stores or restores parameters, which takes some devices seconds.
    pub fn is_store(&self) -> bool {
        self.object.is_some_and(|object| matches!(object.index.0, 0x1010 | 0x1011 | 0x1F50 | 0x1F51))
    }

    /// ` for 6004h:00`, where the object is known.
    pub fn about(&self) -> String {
        self.object.map(|object| format!(" for {object}")).unwrap_or_default()
    }

    /// The object as a number, to tell findings apart.
    pub fn detail(&self) -> u64 {
        self.object.map_or(0, |object| u64::from(object.index.0) << 8 | u64::from(object.sub.0))
    }
}
