//! Whole SDO transfers as text.

use super::object::Object;
use super::signal::Name;
use crate::NodeId;
use crate::network::Bus;
use crate::network::sdo::Transfer;
use std::fmt;

/// The object of a transfer and its value, as text. Text from the bus is escaped.
pub struct TransferText<'a> {
    object: Object<'a>,
    transfer: &'a Transfer,
}

impl<'a> TransferText<'a> {
    /// The text of a transfer with the server `server`.
    pub fn new(bus: &'a Bus, server: NodeId, transfer: &'a Transfer) -> Self {
        Self { object: Object::new(Some(server), bus.node(server), transfer.multiplexer), transfer }
    }

    /// The object's address and name: `1018h:01 Identity object, Vendor-ID`.
    pub fn object(&self) -> impl fmt::Display {
        fmt::from_fn(|f| write!(f, "{}", self.object))
    }

    /// The object's name, if it has one.
    pub fn name(&self) -> Option<Name<'a>> {
        self.object.is_named().then_some(Name(self.object))
    }

    /// The value as text, as far as it was transferred.
    pub fn value(&self) -> impl fmt::Display {
        fmt::from_fn(|f| write!(f, "{}", self.object.value(self.transfer.data())))
    }
}
