use super::hooks;
use crate::{Fault, Firmware};

hooks! {
    stores unless StoreWithoutEffect,
    restores unless RestoreWithoutEffect,
    stores_by_group unless StoreGroupIgnored,
    restores_by_group unless RestoreGroupIgnored,
    checks_first_signature_only with StoreSignatureFirstOnly,
    loses_application_group with StoreLosesGroup,
    restores_at_once with RestoreAtOnce,
    keeps_configuration_date with ConfigurationDateKept,
    stores_later_values with LaterValuesStored,
    checks_save_signature unless StoreSignatureUnchecked,
}

impl Firmware {
    /// Whether 1011h takes no value but its signature.
    pub(in crate::device) const fn checks_load_signature(&self) -> bool {
        // One function checks both signatures.
        !self.has(Fault::RestoreSignatureUnchecked) && !self.has(Fault::StoreSignatureUnchecked)
    }
}
