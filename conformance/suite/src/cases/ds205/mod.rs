//! CiA DS-205: layer management (LMT), the forerunner of LSS. The standard is withdrawn and not public: the
//! requirements here are those on which the manuals of such devices agree, so no section is cited.
//!
//! All cases address every LMT slave on the bus, so the device must be alone.

mod configuration;
mod dialogue;
mod inquiry;
mod mode;
pub(crate) mod needs;
