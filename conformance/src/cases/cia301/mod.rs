//! CiA 301: application layer and communication profile.

mod boot_up;
mod dictionary;
mod heartbeat;
mod identity;
mod nmt;
mod sdo;
mod state;
mod tpdo;
