//! What is in a simulated device beside its model: a firmware, right or wrong.

use crate::{Fault, Faults};

/// The firmware of a simulated device, by what distinguishes it from the plain one of its model.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default, Debug)]
pub struct Firmware {
    /// What it does wrong.
    pub faults: Faults,
}

impl Firmware {
    /// Without any fault.
    pub const PLAIN: Self = Self { faults: Faults::NONE };

    /// Whether it has that fault.
    pub const fn has(&self, fault: Fault) -> bool {
        self.faults.has(fault)
    }
}

impl From<Faults> for Firmware {
    fn from(faults: Faults) -> Self {
        Self { faults }
    }
}

impl From<Fault> for Firmware {
    fn from(fault: Fault) -> Self {
        Faults::from(fault).into()
    }
}
