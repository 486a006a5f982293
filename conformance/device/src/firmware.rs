//! The firmware of a simulated device, in addition to its model.

use crate::{Fault, Faults, Liberties, Liberty};

/// The firmware of a simulated device: its differences from the plain firmware of the model.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default, Debug)]
pub struct Firmware {
    /// The faults of the firmware, against the standard.
    pub faults: Faults,
    /// The liberties of the firmware, which the standard allows.
    pub liberties: Liberties,
}

impl Firmware {
    /// A firmware without faults and liberties.
    pub const PLAIN: Self = Self { faults: Faults::NONE, liberties: Liberties::NONE };

    /// Whether the firmware has this fault.
    pub const fn has(&self, fault: Fault) -> bool {
        self.faults.has(fault)
    }

    /// Whether the firmware takes this liberty.
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
