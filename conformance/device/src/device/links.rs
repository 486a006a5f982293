//! Objects with linked values, as the model's sheet lists them.

use super::objects::Objects;
use super::store::Groups;
use crate::models::LinkKind;
use canvass_analyzer::Multiplexer;

impl Objects {
    /// Handles a written number: linked objects get the same value, with all effects of a write of their own.
    pub(super) fn write_through(&mut self, at: Multiplexer, value: u64) {
        if self.breaks_link(at, Some(value)) {
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

    /// Makes linked objects equal after groups were loaded. All get the value of the loaded object that differs from
    /// its default or, if no loaded object differs, of the first loaded object.
    pub(super) fn settle_links(&mut self, groups: Groups) {
        let Self { model, application, parameters, .. } = self;
        let sheet = model.sheet();
        let is_torn =
            |at: &Multiplexer| application.as_ref().is_some_and(|application| application.breaks_link(*at, None));
        let links = sheet.links.iter().filter(|link| link.kind == LinkKind::Same && !link.objects.iter().any(is_torn));
        for link in links {
            let loaded = || link.objects.iter().filter(|&&at| groups.has(at, &sheet.storage));
            let changed = loaded().find(|&&at| parameters.entry(at).is_ok_and(|entry| entry.is_changed()));
            let Some(&source) = changed.or_else(|| loaded().next()) else { continue };
            let Some(value) = parameters.number(source.index.0, source.sub.0) else { continue };
            for other in link.objects.iter().filter(|&&other| other != source) {
                parameters.set_number(other.index.0, other.sub.0, value);
            }
        }
    }

    /// The object whose value this object shows; `None` if it shows its own.
    pub(super) fn followed(&self, at: Multiplexer) -> Option<Multiplexer> {
        if self.breaks_link(at, None) {
            return None;
        }
        let mut links = self.model.sheet().links.iter().filter(|link| link.kind == LinkKind::Follows);
        links.find(|link| link.objects.first() == Some(&at)).and_then(|link| link.objects.get(1)).copied()
    }

    fn breaks_link(&self, at: Multiplexer, value: Option<u64>) -> bool {
        self.application.as_ref().is_some_and(|application| application.breaks_link(at, value))
    }
}
