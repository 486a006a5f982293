//! CiA 406: encoders. The profile is not public: the sections are unknown, and the objects are those on which manuals
//! agree.
//!
//! The shaft must be at rest: cases that depend on it check that first. Cases on speed need a turning shaft.

mod alarms;
mod cams;
mod consistency;
mod draw_wire;
mod error_behaviour;
mod identification;
mod limit_switch;
mod needs;
mod operating;
mod pdo;
mod position;
mod preset;
mod profile;
mod raw;
mod scaling;
mod scaling_off;
mod speed;
mod timer;
mod work_area;
mod zero_point;

use canvass_bus::observation::Observation;

/// A number as an observation.
fn number(value: impl Into<u64>) -> Observation {
    Observation::Number(value.into())
}
