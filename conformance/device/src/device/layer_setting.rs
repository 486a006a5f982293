//! The part that LSS and LMT slaves share: their two states, and sequences of messages.

use canvass_analyzer::wire::layer_setting::{Dialect, Limit, Numbered};

/// The state of a slave.
#[derive(Clone, Debug)]
pub(super) struct LayerSetting {
    /// Whether the slave is in configuration; otherwise it is in waiting (LSS) or in operation (LMT).
    pub configuring: bool,
    /// Progress of "switch mode selective" in the parts of the address.
    pub selected: InOrder,
    /// Progress of "identify remote slave" in its bounds.
    pub identified: InOrder,
}

/// Number of consecutive values that matched; the first value of a sequence restarts it.
#[derive(Clone, Debug)]
pub(super) struct InOrder(usize);

impl LayerSetting {
    /// The state waiting (LSS) or operation (LMT).
    pub const fn new() -> Self {
        Self { configuring: false, selected: InOrder(0), identified: InOrder(0) }
    }

    /// Handles "switch global"; `reserved` is the meaning of a reserved mode in a faulty firmware. Returns whether the
    /// slave obeyed.
    pub const fn switch(&mut self, mode: u8, reserved: Option<bool>) -> bool {
        let configuring = match mode {
            0 => Some(false),
            1 => Some(true),
            _ => reserved,
        };
        let Some(configuring) = configuring else { return false };
        self.configuring = configuring;
        self.selected = InOrder(0);
        true
    }
}

impl InOrder {
    /// Handles a message of a sequence; `fits` tells whether its value matches. Returns whether the message completed
    /// the sequence.
    pub fn takes<N: Numbered>(&mut self, which: N, fits: bool) -> bool {
        let position = which.position();
        let in_order = position == 0 || position == self.0;
        self.reach(if fits && in_order { position + 1 } else { 0 }, N::ALL)
    }

    /// Handles a message like [`InOrder::takes`], in a faulty firmware that ignores the order of the messages.
    pub fn counts<N: Numbered>(&mut self, fits: bool) -> bool {
        self.reach(if fits { self.0 + 1 } else { 0 }, N::ALL)
    }

    const fn reach<N>(&mut self, reached: usize, all: &[N]) -> bool {
        let complete = reached >= all.len();
        self.0 = if complete { 0 } else { reached };
        complete
    }
}

/// Whether `own`, a part of the slave's address, is within the bound `value` of "identify remote slave".
pub(super) fn is_within<D: Dialect>(limit: Limit, value: D::Value, own: D::Value) -> bool {
    match limit {
        Limit::Equal => value == own,
        Limit::Lowest => value <= own,
        Limit::Highest => value >= own,
    }
}
