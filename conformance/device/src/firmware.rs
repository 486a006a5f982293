//! What is in a simulated device beside its model: a firmware, right or wrong.

use crate::{Fault, Faults, Liberties, Liberty};

/// The firmware of a simulated device, by what distinguishes it from the plain one of its model.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default, Debug)]
pub struct Firmware {
    /// What it does wrong.
    pub faults: Faults,
    /// What it does in its own way, as the standard lets it.
    pub liberties: Liberties,
}

impl Firmware {
    /// Without any fault or liberty.
    pub const PLAIN: Self = Self { faults: Faults::NONE, liberties: Liberties::NONE };

    /// Whether it has that fault.
    pub const fn has(&self, fault: Fault) -> bool {
        self.faults.has(fault)
    }

    /// Whether it takes that liberty.
    pub const fn takes(&self, liberty: Liberty) -> bool {
        self.liberties.has(liberty)
    }
}

impl From<Faults> for Firmware {
    fn from(faults: Faults) -> Self {
        Self { faults, liberties: Liberties::NONE }
    }
}

impl From<Fault> for Firmware {
    fn from(fault: Fault) -> Self {
        Faults::from(fault).into()
    }
}

impl From<Liberties> for Firmware {
    fn from(liberties: Liberties) -> Self {
        Self { faults: Faults::NONE, liberties }
    }
}

impl From<Liberty> for Firmware {
    fn from(liberty: Liberty) -> Self {
        Liberties::from(liberty).into()
    }
}
