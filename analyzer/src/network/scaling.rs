//! Physical values in the current configuration of a device, by its device profile.

use super::node::Node;
use crate::dictionary::Unit;
use crate::dictionary::names::{self, Configured, Role};
use crate::object;
use crate::{Multiplexer, NodeId};

/// Whether the values of other objects depend on this object.
pub(crate) fn is_scaling_parameter(object: Multiplexer) -> bool {
    object.index.0 == object::DEVICE_TYPE || is_of_profile(object) && names::has_role(object.index, Role::Scaling)
}

/// The physical unit of an object that the device's configuration determines; `None` if there is none or too little
/// is known.
pub fn scale(node: &Node, id: NodeId, object: Multiplexer) -> Option<Unit> {
    if !is_of_profile(object) {
        return None;
    }
    names::known_profile(node.profile(id)?)?.scale(object, &Configuration { node, id })
}

const fn is_of_profile(object: Multiplexer) -> bool {
    matches!(object.index.0, 0x6000..=0x9FFF)
}

/// The configuration of a node by its trace and description.
struct Configuration<'a> {
    node: &'a Node,
    id: NodeId,
}

impl Configured for Configuration<'_> {
    fn parameter(&self, at: Multiplexer) -> Option<u32> {
        self.node.parameter(self.id, at)
    }

    fn state_of_bit(&self, at: Multiplexer, name: &str) -> Option<&str> {
        let value = self.parameter(at)?;
        let annotation = self.node.device.as_ref()?.manual.annotations.get(at)?;
        let bit = annotation.bits.iter().find(|bit| bit.name.starts_with(name))?;
        if value >> bit.bit.min(31) & 1 != 0 { Some(&bit.name) } else { bit.clear.as_deref() }
    }
}
