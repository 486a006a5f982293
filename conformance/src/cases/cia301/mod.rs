//! CiA 301: application layer and communication profile.

mod boot_up;
mod dictionary;
mod emcy;
mod emcy_object;
mod error_behaviour;
mod error_history;
mod guarding;
mod heartbeat;
mod heartbeat_consumer;
mod identity;
mod life_guarding;
mod nmt;
mod pdo_communication;
mod pdo_mapping;
mod pdo_mapping_rules;
mod pdo_parameters;
mod rpdo;
mod sdo;
mod state;
mod store;
mod sync;
mod time;
mod tpdo;
mod tpdo_events;
mod tpdo_remote;
mod version_3;
