//! Compares `DeviceInfo` with 1018h, if 1018h itself is described without values.

use super::{Comparison, MismatchKind, Side, Weight};
use crate::dictionary::difference::{Fact, Subject};
use crate::identity::Multiplexer;
use crate::object;

pub(super) fn compare(comparison: &mut Comparison<'_>) {
    let device = &comparison.description.device;
    let fields = [
        (MismatchKind::Identity, "VendorNumber", device.vendor_number, 1),
        (MismatchKind::Identity, "ProductNumber", device.product_number, 2),
        (MismatchKind::Release, "RevisionNumber", device.revision_number, 3),
    ];
    for (kind, field, described, sub) in fields {
        let at = Multiplexer::new(object::IDENTITY, sub);
        let entry = comparison.description.dictionary.entry(at).ok();
        let is_told = entry.is_some_and(|entry| entry.configured.is_some() || entry.default.is_some());
        let (Some(described), Some(found)) = (described, comparison.survey.number(at)) else { continue };
        // A file that leaves a number open has 0.
        if !is_told && described != 0 && u64::from(described) != found {
            let found = u32::try_from(found).unwrap_or(u32::MAX);
            let [described, found] = [described, found].map(|code| Side::Fact(Fact::Code(code)));
            comparison.report(kind, Weight::Differs, Subject::Field(field), described, found);
        }
    }
}
