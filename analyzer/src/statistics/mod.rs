//! Statistics of a bus and its nodes: presence, states, traffic, response times.
//!
//! Memory is constant: lists that could grow with the capture are folded or limited, and say so.

mod bit_rate;
mod bus;
mod histogram;
mod load;
mod node;
mod peak;
mod test_run;

pub use bit_rate::{BitRate, RATES};
pub use bus::{BusStatistics, Statistics};
pub use histogram::Histogram;
pub use load::{Extremes, Load};
pub use node::{EmcyCount, ErrorEnd, ErrorEpisode, IdentityText, NodeStatistics, StateChange};
pub use peak::Peak;
pub use test_run::{CaseName, TestCase, TestRun};
