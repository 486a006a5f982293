//! The effects of liberties on descriptions: on the EDS alone, or on the device with it.

use canvass_analyzer::dictionary::Severity;
use canvass_analyzer::dictionary::{DeviceDescription, Missing, Setting};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_device::Liberty::{self, *};
use canvass_device::models::Model;
use canvass_device::{Device, Firmware, Liberties};

/// Liberties that only the description shows.
pub const SHOWN: [Liberty; 8] = [
    EdsWithoutLimits,
    EdsObjFlags,
    EdsCompactSubObj,
    EdsOneDigitHour,
    EdsListsOutOfOrder,
    EdsInlineComments,
    EdsLatin1,
    EdsIdentityWithoutDefaults,
];

fn model() -> &'static Model {
    Model::by_id("reference-301").unwrap()
}

fn described(liberty: Liberty) -> DeviceDescription {
    model().description_with(liberty)
}

fn default_of(description: &DeviceDescription, index: u16, sub: u8) -> Option<&Setting> {
    description.dictionary.entry(Multiplexer::new(index, sub)).unwrap().default.as_ref()
}

#[test]
fn the_eds_is_written_in_another_way() {
    let plain = model().description();
    let limits = |description: &DeviceDescription| {
        description
            .dictionary
            .entries()
            .filter(|(_, entry)| entry.low_limit.is_some() || entry.high_limit.is_some())
            .count()
    };
    assert!(limits(plain) > 0);
    assert_eq!(limits(&described(EdsWithoutLimits)), 0);

    let refuses = |description: &DeviceDescription| {
        let commands = description.dictionary.entries().filter(|(at, _)| matches!(at.index.0, 0x1010 | 0x1011));
        commands.filter(|(_, entry)| entry.flags.refuses_write_on_download()).count()
    };
    assert_eq!(refuses(plain), 0);
    assert!(refuses(&described(EdsObjFlags)) >= 2);

    let compact = described(EdsCompactSubObj);
    for at in [Multiplexer::new(0x1003, 8), Multiplexer::new(0x1016, 2)] {
        let (entry, own) = (compact.dictionary.entry(at).unwrap(), plain.dictionary.entry(at).unwrap());
        assert_eq!((entry.data_type, entry.access), (own.data_type, own.access), "{at:?}");
        // The entry is described in the section of the object; it has no section of its own.
        let object = |description: &DeviceDescription| description.dictionary.object(at.index).unwrap().line;
        assert_eq!(entry.line, object(&compact));
        assert_ne!(own.line, object(plain));
    }
    assert_eq!(compact.dictionary.entries().count(), plain.dictionary.entries().count());

    assert_eq!(
        (plain.file.created.1.as_str(), described(EdsOneDigitHour).file.created.1.as_str()),
        ("02:00PM", "2:00PM")
    );
    let listed = |description: &DeviceDescription| {
        let mandatory = description.lists.mandatory.iter().map(|(index, line)| (index.0, *line));
        mandatory.unzip::<u16, u32, Vec<_>, Vec<_>>()
    };
    let ((all, lines), (swapped, swapped_lines)) = (listed(plain), listed(&described(EdsListsOutOfOrder)));
    assert_eq!((all, lines.is_sorted()), (swapped, true));
    assert!(!swapped_lines.is_sorted());
    assert_eq!(described(EdsLatin1).device.vendor_name, "M\u{FC}ller canvass");
    assert_eq!(described(EdsInlineComments).dictionary.objects().len(), plain.dictionary.objects().len());

    assert!(default_of(plain, 0x1018, 1).is_some());
    let without = described(EdsIdentityWithoutDefaults);
    assert_eq!((default_of(&without, 0x1018, 1), without.device.vendor_number), (None, Some(0x7FFF_FFFF)));
    assert_eq!(crate::steps::result("reference-301", EdsIdentityWithoutDefaults, &["200", "r 1018:01"]), "=FFFFFF7F");
}

/// A description with a liberty has no errors, as the plain description has none.
#[test]
fn what_is_free_is_no_error_of_the_eds() {
    let errors = |description: DeviceDescription| {
        description.problems.into_iter().filter(|problem| problem.severity() == Severity::Error).collect::<Vec<_>>()
    };
    assert_eq!(errors(model().description().clone()), []);
    for &liberty in Liberty::ALL {
        assert_eq!(errors(described(liberty)), [], "{liberty}");
    }
}

/// A liberty removes the same entries from the description and from the device.
#[test]
fn description_and_device_change_together() {
    let everything = model().description();
    for &liberty in Liberty::ALL {
        let description = described(liberty);
        for (at, _) in everything.dictionary.entries().filter(|(at, _)| at.sub.0 <= 3 && at.index.0 != 0x1003) {
            let expected = match description.dictionary.entry(at) {
                Err(Missing::Object) => Some("06020000"),
                Err(Missing::SubIndex) => Some("06090011"),
                Ok(_) => None,
            };
            if expected.is_none() && at.index.0 & 0xF != 0 {
                // For entries that exist, a sample is enough.
                continue;
            }
            let address = format!("r {:04X}:{:02X}", at.index.0, at.sub.0);
            let found = crate::steps::result("reference-301", liberty, &["5200", &address]);
            match expected {
                Some(code) => assert_eq!(found, code, "{liberty}, {address}"),
                None => assert!(found.starts_with('=') || found == "06010001", "{liberty}, {address}: {found}"),
            }
        }
    }
}

/// Any five liberties can be combined: the device starts and answers.
#[test]
fn liberties_can_be_combined() {
    let all = Liberty::ALL;
    for n in 0..all.len() {
        let five: Liberties = (0..5).map(|k| all[(n * 7 + k * 13) % all.len()]).collect();
        let found = crate::steps::result("reference-301", five, &["5200", "after 60A#40001000"]);
        assert_ne!(found, "never", "{five:?}");
    }
    // No liberty adds an object, and all liberties together still make a valid description.
    let taken = model().taking(all.iter().copied().collect());
    assert!(taken.description().dictionary.objects().len() < model().description().dictionary.objects().len());
    let device = Device::new(model(), NodeId::new(10), Firmware::from(all.iter().copied().collect::<Liberties>()), 0);
    assert_eq!(device.node(), NodeId::new(10));
}

/// Every model can take every liberty: a device still starts and answers, even if the liberty has no effect on it.
#[test]
fn every_model_takes_every_liberty() {
    for model in Model::all() {
        for &liberty in Liberty::ALL {
            let found = crate::steps::result(model.id(), liberty, &["5200", "after 60A#40001000"]);
            assert_ne!(found, "never", "{} with {liberty}", model.id());
        }
    }
}
