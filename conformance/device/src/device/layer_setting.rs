//! What the slaves of LSS and LMT have in common: the two states, and what has to come in order.

use canvass_analyzer::wire::layer_setting::{Dialect, Limit, Numbered};

/// Where a slave is.
#[derive(Clone, Debug)]
pub(super) struct LayerSetting {
    /// In configuration, and not in waiting (LSS) or operation (LMT).
    pub configuring: bool,
    /// The parts of the address.
    pub selected: InOrder,
    /// The bounds of "identify remote slave".
    pub identified: InOrder,
}

/// How many of several values have come in their order and fitted; a first one begins anew.
#[derive(Clone, Debug)]
pub(super) struct InOrder(usize);

impl LayerSetting {
    /// Waiting, or in operation.
    pub const fn new() -> Self {
        Self { configuring: false, selected: InOrder(0), identified: InOrder(0) }
    }

    /// "Switch global"; `reserved` is what a faulty firmware takes a reserved mode for. Whether it was obeyed.
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
    /// One has come: whether it was the last of all.
    pub fn takes<N: Numbered>(&mut self, which: N, fits: bool) -> bool {
        let position = which.position();
        let in_order = position == 0 || position == self.0;
        self.reach(if fits && in_order { position + 1 } else { 0 }, N::ALL)
    }

    /// One has come, and a faulty firmware only counts those that fit.
    pub fn counts<N: Numbered>(&mut self, fits: bool) -> bool {
        self.reach(if fits { self.0 + 1 } else { 0 }, N::ALL)
    }

    const fn reach<N>(&mut self, reached: usize, all: &[N]) -> bool {
        let complete = reached >= all.len();
        self.0 = if complete { 0 } else { reached };
        complete
    }
}

/// Whether a part of the own address is within a bound of "identify remote slave".
pub(super) fn is_within<D: Dialect>(limit: Limit, value: D::Value, own: D::Value) -> bool {
    match limit {
        Limit::Equal => value == own,
        Limit::Lowest => value <= own,
        Limit::Highest => value >= own,
    }
}
