//! CiA 305: layer setting services. All cases address every LSS slave on the bus, so the device must be alone.

mod bit_timing;
mod crowd;
mod dialogue;
mod fastscan;
mod identify;
pub(crate) mod needs;
mod node_id;
mod services;
mod store;
mod switch;
mod unconfigured;
