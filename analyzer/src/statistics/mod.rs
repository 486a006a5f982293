//! Figures of a bus and its nodes: who was there, in which state, how much they sent, how quickly they answered.
//!
//! Everything is collected in constant memory: what could grow with the capture is folded or bounded, and says so.

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
