//! CiA DS-205: layer management (LMT), the forerunner of LSS. The standard is withdrawn and not public: what is demanded
//! here is what the manuals of such devices agree on, so no section is cited.
//!
//! All of it addresses every LMT slave on the bus, so the device must be alone.

mod configuration;
mod dialogue;
mod inquiry;
mod mode;
pub(crate) mod needs;
