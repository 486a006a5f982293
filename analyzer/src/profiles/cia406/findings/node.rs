//! The kind of the encoder that a frame concerns, and the layout of its PDOs.

use crate::findings::{Context, Operand};
use crate::message::Message;
use crate::network::Layout;
use crate::object;
use crate::profiles::cia406::NUMBER;
use crate::profiles::cia406::kind::Kind;
use crate::{Multiplexer, NodeId};

/// The layout of the PDO in a frame.
pub fn layout<'a>(context: &Context<'a>) -> Option<&'a Layout> {
    let Message::Pdo(number) = context.message() else { return None };
    context.scene.bus.node(context.decoded.node?)?.known_layout(*number)
}

/// Whether the node is known to be an encoder.
pub(crate) fn is_encoder(context: &Context<'_>, node: NodeId) -> bool {
    context.scene.bus.node(node).and_then(|known| known.profile(node)) == Some(NUMBER)
}

/// The kind of a node's encoder; `None` if 1000h is unknown or has another value.
pub fn kind(context: &Context<'_>, node: NodeId) -> Option<Kind> {
    Kind::of(context.scene.bus.node(node)?.parameter(node, Multiplexer::new(object::DEVICE_TYPE, 0))?)
}

/// The values of an encoder's objects in a frame; none if the device has another profile.
pub fn operands<'a>(context: &Context<'a>) -> &'a [Operand] {
    let news = context.news();
    if news.profile == Some(NUMBER) { &news.operands } else { &[] }
}
