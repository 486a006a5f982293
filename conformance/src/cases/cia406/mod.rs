//! CiA 406: encoders. The profile is not public: the sections are unknown, the objects are what manuals agree on.
//!
//! The shaft must be at rest: cases that depend on it see that first.

mod limit_switch;
mod position;
mod scaling_off;
mod timer;
