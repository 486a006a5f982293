//! The kind of a node's encoder, and the layout of its PDOs.

use crate::dictionary::names::ENCODER_PROFILE;
use crate::findings::Context;
use crate::message::Message;
use crate::network::Layout;
use crate::object;
use crate::{Multiplexer, NodeId};

/// The layout of the PDO in a frame.
pub fn layout<'a>(context: &Context<'a>) -> Option<&'a Layout> {
    let Message::Pdo(number) = context.message() else { return None };
    context.scene.bus.node(context.decoded.node?)?.known_layout(*number)
}

/// Whether the node is known to be an encoder.
pub fn is_encoder(context: &Context<'_>, node: NodeId) -> bool {
    context.scene.bus.node(node).and_then(|known| known.profile(node)) == Some(ENCODER_PROFILE)
}

/// The motion of an encoder's shaft or rod, by the upper word of 1000h.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum EncoderKind {
    /// 01h to 05h of CiA 406, and 0Bh of newer devices.
    Rotary,
    /// 08h and 09h.
    Linear,
}

/// The kind of a node's encoder; `None` if 1000h is unknown or has another value.
pub fn kind(context: &Context<'_>, node: NodeId) -> Option<EncoderKind> {
    let device_type = context.scene.bus.node(node)?.parameter(node, Multiplexer::new(object::DEVICE_TYPE, 0))?;
    match device_type >> 16 {
        0x01..=0x05 | 0x0B => Some(EncoderKind::Rotary),
        0x08 | 0x09 => Some(EncoderKind::Linear),
        _ => None,
    }
}
