//! Requests and answers of LSS and LMT, whose messages on 7E5h and 7E4h have the command specifier in byte 0.

use crate::findings::{Context, Seen};
use crate::message::Message;
use crate::wire::layer_setting::ConfigureCommand;
use crate::wire::{lmt, lss};

/// The sender of a message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Sender {
    /// The master, on 7E5h.
    Master,
    /// A slave, on 7E4h.
    Slave,
}

/// The sender of a message; `None` if the message is neither LSS nor LMT.
pub const fn sender(message: &Message) -> Option<Sender> {
    match message {
        Message::LssRequest(_) | Message::LmtRequest(_) => Some(Sender::Master),
        Message::LssResponse(_) | Message::LmtResponse(_) => Some(Sender::Slave),
        _ => None,
    }
}

/// Whether exactly one slave must answer a request.
pub(crate) fn wants_answer(message: &Message) -> bool {
    match message {
        Message::LssRequest(request) => request.wants_answer(),
        Message::LmtRequest(request) => request.wants_answer(),
        _ => false,
    }
}

/// Whether a request stores the configuration.
pub const fn is_store(message: &Message) -> bool {
    matches!(
        message,
        Message::LssRequest(lss::Request::StoreConfiguration) | Message::LmtRequest(lmt::Request::StoreConfiguration)
    )
}

/// Whether a request switches all slaves back to waiting (LSS) or operation (LMT).
pub(crate) const fn is_leave(message: &Message) -> bool {
    matches!(
        message,
        Message::LssRequest(lss::Request::SwitchGlobal { mode: 0 })
            | Message::LmtRequest(lmt::Request::SwitchGlobal { mode: 0 })
    )
}

/// The command and the error code in an answer to a configure command.
pub const fn configured(message: &Message) -> Option<(ConfigureCommand, u8)> {
    match message {
        Message::LssResponse(lss::Response::Configured { command, error, .. })
        | Message::LmtResponse(lmt::Response::Configured { command, error, .. }) => Some((*command, *error)),
        _ => None,
    }
}

/// The text of a message.
pub fn words(message: &Message) -> String {
    match message {
        Message::LssRequest(request) => request.to_string(),
        Message::LssResponse(response) => response.to_string(),
        Message::LmtRequest(request) => request.to_string(),
        Message::LmtResponse(response) => response.to_string(),
        _ => String::new(),
    }
}

/// The command specifier of a frame.
pub fn command(seen: &Seen) -> u8 {
    seen.record.frame.bytes()[0]
}

/// The command specifier of the current frame.
pub(crate) fn own_command(context: &Context<'_>) -> u8 {
    context.record.frame.bytes()[0]
}

/// The command specifier of the answer to a request; `None` for requests without answer.
pub const fn answer_to(command: u8) -> Option<u8> {
    match command {
        0x11 | 0x13 | 0x17 | 0x24..=0x26 | 0x5A..=0x5E => Some(command),
        // In LMT the identification of remote slaves is answered after its last bound.
        0x08 => Some(0x09),
        0x43 => Some(0x44),
        0x46..=0x4B | 0x51 => Some(0x4F),
        0x4C => Some(0x50),
        _ => None,
    }
}
