//! Differences of a modular device's modules, and of the modules that a DCF plugs in.

use super::kind::kinds;
use super::{Comparison, Fact, Subject};
use crate::dictionary::description::Module;
use crate::dictionary::object::Object;
use std::collections::BTreeSet;

kinds! {
    /// the module is gone
    ///
    /// A DCF that plugs it in (ConnectedModules) names an unknown module.
    REMOVED: Breaking "module/removed";

    /// the module is new
    ///
    /// DCFs that don't plug it in stay as they are.
    ADDED: Harmless "module/added";

    /// the number stands for another module
    ///
    /// ConnectedModules names modules by their numbers: a DCF now plugs in another one.
    PRODUCT: Breaking "module/product";

    /// the module adds other objects to the object dictionary
    ///
    /// Entries that a DCF sets may have moved or disappeared.
    CONTENT: Notable "module/content";

    /// other modules are plugged in
    ///
    /// The device has other objects; master and tools see another configuration.
    CONNECTED: Breaking "module/connected";
}

pub(super) fn compare(comparison: &mut Comparison<'_>) {
    let (old, new) = (comparison.old, comparison.new);
    let of = |modules: &[Module], number| modules.iter().find(|module| module.number == number).cloned();
    let numbers: BTreeSet<u16> = old.modules.iter().chain(&new.modules).map(|module| module.number).collect();
    for number in numbers {
        let subject = Subject::Module(number);
        let name = |module: &Module| Some(Fact::Text(module.product_name.clone()));
        match (of(&old.modules, number), of(&new.modules, number)) {
            (Some(before), Some(after)) => {
                let product = |module: &Module| (module.product_name.clone(), module.order_code.clone());
                if product(&before) != product(&after) {
                    comparison.report(&PRODUCT, subject, name(&before), name(&after));
                } else if content(before.clone()) != content(after.clone()) {
                    comparison.report(&CONTENT, subject, name(&before), name(&after));
                }
            }
            (Some(before), None) => comparison.report(&REMOVED, subject, name(&before), None),
            (None, Some(after)) => comparison.report(&ADDED, subject, None, name(&after)),
            (None, None) => {}
        }
    }
    // Only a configured device has plugged-in modules.
    if old.is_configuration() && new.is_configuration() {
        let list = |numbers: &[u16]| {
            let words: Vec<String> = numbers.iter().map(u16::to_string).collect();
            Some(Fact::Text(words.join(", ")))
        };
        let subject = Subject::Field("ConnectedModules");
        comparison.changed(&CONNECTED, subject, list(&old.connected_modules), list(&new.connected_modules));
    }
}

/// The module without its line numbers.
fn content(mut module: Module) -> Module {
    module.fixed_objects.iter_mut().for_each(without_lines);
    module.extensions.iter_mut().for_each(|extension| without_lines(&mut extension.template));
    module
}

fn without_lines(object: &mut Object) {
    (object.line, object.section) = (0, None);
    let entries: Vec<_> = object.entries().to_vec();
    for mut entry in entries {
        (entry.line, entry.section) = (0, None);
        object.insert(entry);
    }
}
