//! Rules about safety-relevant data.

mod ended;
mod halves;
