//! The simulated devices on the simulated bus.

mod encoder;
mod errors;
mod faults;
mod manual;
mod nmt;
mod pdo;
mod rig;
mod robustness;
mod sdo;
mod services;
mod timing;
