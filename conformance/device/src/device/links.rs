//! Objects with linked values, from the model's sheet.

use super::objects::Objects;
use super::store::Groups;
use crate::Fault;
use crate::models::LinkKind;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::object::encoder;

impl Objects {
    /// Handles a written number: linked objects get the same value, with all effects of a write.
    pub(super) fn write_through(&mut self, at: Multiplexer, value: u64) {
        let unlinked = match at.index.0 {
            encoder::CYCLIC_TIMER if value == 0 && self.firmware.has(Fault::CyclicTimerNotStopped) => true,
            encoder::CYCLIC_TIMER => self.firmware.has(Fault::CyclicTimerNotLinked),
            object::TPDO_COMMUNICATION_PARAMETER => self.firmware.has(Fault::EventTimerNotInCyclicTimer),
            _ => false,
        };
        if unlinked {
            return;
        }
        let links = self.model.sheet().links.iter().filter(|link| link.kind == LinkKind::Same);
        for link in links.filter(|link| link.objects.contains(&at)) {
            for &other in link.objects.iter().filter(|&&other| other != at) {
                self.parameters.set_number(other.index.0, other.sub.0, value);
                self.written.push((other, value));
            }
        }
    }

    /// Handles the loading of groups: among linked objects, one with another value than its default decides, else the
    /// first loaded one.
    pub(super) fn settle_links(&mut self, groups: Groups) {
        let sheet = self.model.sheet();
        let is_torn =
            |at: &Multiplexer| at.index.0 == encoder::SERIAL_NUMBER && self.firmware.has(Fault::SerialNumberDiffers);
        let links = sheet.links.iter().filter(|link| link.kind == LinkKind::Same && !link.objects.iter().any(is_torn));
        for link in links {
            let loaded = || link.objects.iter().filter(|&&at| groups.has(at, &sheet.storage));
            let changed = loaded().find(|&&at| self.parameters.entry(at).is_ok_and(|entry| entry.is_changed()));
            let Some(&source) = changed.or_else(|| loaded().next()) else { continue };
            let Some(value) = self.parameters.number(source.index.0, source.sub.0) else { continue };
            for other in link.objects.iter().filter(|&&other| other != source) {
                self.parameters.set_number(other.index.0, other.sub.0, value);
            }
        }
    }

    /// The object whose value the given one shows, if there is one.
    pub(super) fn followed(&self, at: Multiplexer) -> Option<Multiplexer> {
        if at.index.0 == encoder::OPERATING_STATUS && self.firmware.has(Fault::OperatingStatusStuck) {
            return None;
        }
        let mut links = self.model.sheet().links.iter().filter(|link| link.kind == LinkKind::Follows);
        links.find(|link| link.objects.first() == Some(&at)).and_then(|link| link.objects.get(1)).copied()
    }
}
