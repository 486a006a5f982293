//! CiA 406: encoders. The profile is not public: the sections are unknown, the objects are what manuals agree on.
//!
//! The shaft must be at rest: cases that depend on it see that first. Those about speed need one that turns.

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

/// A number that an object shows.
fn number(value: impl Into<u64>) -> Observation {
    Observation::Number(value.into())
}
