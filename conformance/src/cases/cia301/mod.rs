//! CiA 301: application layer and communication profile.

mod boot_up;
mod dictionary;
mod emcy;
mod guarding;
mod heartbeat;
mod heartbeat_consumer;
mod identity;
mod life_guarding;
mod nmt;
mod pdo_communication;
mod pdo_mapping;
mod sdo;
mod state;
mod store;
mod tpdo;
mod tpdo_remote;
mod version_3;
