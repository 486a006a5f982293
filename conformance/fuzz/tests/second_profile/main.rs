//! A second device profile, added without changing a file of the core: CiA 401 with eight digital inputs that are wired
//! to eight digital outputs. In each crate it has the parts of a profile: object names and the meaning of an EMCY code,
//! the application of a simulated device, a case, and a property.
#![cfg(test)]

mod analyzer;
mod device;
mod fuzzer;
mod suite;

use canvass_analyzer::{Multiplexer, NodeId};
use canvass_device::models::Model;

/// The number of the profile.
const NUMBER: u16 = 401;
/// The first eight inputs.
const INPUTS: Multiplexer = Multiplexer::new(0x6000, 1);
/// The first eight outputs.
const OUTPUTS: Multiplexer = Multiplexer::new(0x6200, 1);
/// The error code of outputs that carry too much current.
const OVERLOAD: u16 = 0x2320;
/// The name of a device whose inputs don't follow its outputs.
const STUCK: &str = "stuck";

fn node() -> NodeId {
    NodeId::new(9).unwrap()
}

/// The device with this name, made from its description alone.
fn model(name: &str) -> &'static Model {
    let model = Model::generic(name, include_bytes!("digital-io.eds")).unwrap();
    Box::leak(Box::new(model))
}
