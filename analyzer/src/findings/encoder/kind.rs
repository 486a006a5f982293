//! What kind of encoder a node is, and how its PDOs are laid out.

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

/// How the shaft or rod of an encoder moves, by the upper word of 1000h.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum EncoderKind {
    /// 01h to 05h of CiA 406, and 0Bh of newer devices.
    Rotary,
    /// 08h and 09h.
    Linear,
}

/// What kind of encoder a node is; `None` where 1000h is not known or says something else.
pub fn kind(context: &Context<'_>, node: NodeId) -> Option<EncoderKind> {
    let device_type = context.scene.bus.node(node)?.parameter(node, Multiplexer::new(object::DEVICE_TYPE, 0))?;
    match device_type >> 16 {
        0x01..=0x05 | 0x0B => Some(EncoderKind::Rotary),
        0x08 | 0x09 => Some(EncoderKind::Linear),
        _ => None,
    }
}
