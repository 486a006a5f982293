//! Round trips of randomly generated descriptions.

use super::{assert_same, form_of, in_xdd, meaning, read};
use crate::dictionary::convert::write;
use crate::dictionary::data_type::{DataClass, DataType};
use crate::dictionary::description::{Commissioning, DeviceDescription, DeviceInfo, FileInfo, Module, SubExtension};
use crate::dictionary::object::{Access, Entry, Object, ObjectCode, ObjectFlags, Setting};
use crate::dictionary::value::Value;
use crate::identity::{NodeId, SubIndex};
use proptest::prelude::*;

/// A text that stays the same when it is written into a line.
fn text() -> impl Strategy<Value = String> {
    "([!-~\u{A1}-\u{17F}][ -~\u{20AC}]{0,20}[!-~\u{E9}])?".prop_map(|text| text.trim().to_owned())
}

/// Any text, also with control characters and markup.
fn hostile() -> impl Strategy<Value = String> {
    prop_oneof![text(), "\\PC{0,8}", "[\u{0}-\u{20}=;\\[\\]\"<>&\u{2028}\u{85}\u{FEFF}]{0,8}"]
}

fn value(data_type: DataType, raw: u64, text: &str) -> Option<Value> {
    // An empty text, or a comment, is not read back as a string.
    let string = Some(text).filter(|text| !text.is_empty() && !text.starts_with(';'));
    Some(match data_type.class()? {
        DataClass::VisibleString => {
            let latin_1: Vec<u8> = string?.chars().filter_map(|letter| u8::try_from(letter).ok()).collect();
            let stays = |bytes: &[u8]| !matches!(bytes, [] | [b';', ..]) && bytes.trim_ascii() == bytes;
            Value::VisibleString(Some(latin_1).filter(|bytes| stays(bytes))?)
        }
        DataClass::UnicodeString => Value::UnicodeString(string?.encode_utf16().collect()),
        DataClass::OctetString => Value::OctetString(raw.to_le_bytes().to_vec()),
        DataClass::Domain => Value::Domain(raw.to_le_bytes().to_vec()),
        _ => Value::from_raw(data_type, raw)?,
    })
}

fn setting(data_type: DataType, seed: (u8, u64, String)) -> Option<Setting> {
    let (choice, raw, text) = seed;
    match choice {
        0 => None,
        1 if data_type == DataType::UNSIGNED32 => Some(Setting::NodeIdPlus((raw % 0xFFFF_FF00) as u32)),
        _ => value(data_type, raw, &text).map(Setting::Fixed),
    }
}

fn entry(sub: u8, name: String, text: BoxedStrategy<String>) -> impl Strategy<Value = Entry> {
    let seeds = prop::array::uniform4((0u8..4, any::<u64>(), text.clone()));
    let data_type = prop::sample::select(DataType::ALL.to_vec());
    let access = prop::sample::select(Access::ALL.to_vec());
    (data_type, access, any::<bool>(), seeds, 0u32..4, prop::option::of(text)).prop_map(
        move |(data_type, access, pdo_mappable, [default, low, high, configured], flags, denotation)| Entry {
            pdo_mappable,
            default: setting(data_type, default),
            low_limit: setting(data_type, low),
            high_limit: setting(data_type, high),
            configured: setting(data_type, configured),
            denotation,
            flags: ObjectFlags(flags),
            ..Entry::new(sub, name.clone(), data_type, access)
        },
    )
}

fn object(text: BoxedStrategy<String>) -> impl Strategy<Value = Object> {
    let code = prop::sample::select(vec![ObjectCode::VAR, ObjectCode::ARRAY, ObjectCode::RECORD, ObjectCode::DOMAIN]);
    let head = (0x1000u16..0x7000, code, text.clone(), prop::collection::btree_map(any::<u8>(), text.clone(), 1..4));
    head.prop_flat_map(move |(index, code, name, subs)| {
        let subs = if code.is_single() { [(0, name.clone())].into() } else { subs };
        let entries: Vec<_> = subs.into_iter().map(|(sub, name)| entry(sub, name, text.clone()).boxed()).collect();
        entries.prop_map(move |entries| {
            let mut object = Object::new(index, name.clone(), code);
            entries.into_iter().for_each(|entry| drop(object.insert(entry)));
            object
        })
    })
}

fn module(text: BoxedStrategy<String>) -> impl Strategy<Value = Module> {
    let extension = (object(text.clone()), 0u32..256, 0u32..256).prop_map(|(object, count, object_extend)| {
        let entry = Entry { sub: SubIndex(1), name: object.name.clone(), ..object.entries()[0].clone() };
        let mut template = Object::new(object.index.0, object.name, ObjectCode::ARRAY);
        template.insert(entry);
        SubExtension { template, count, object_extend }
    });
    (text.clone(), any::<Option<u32>>(), prop::option::of(object(text)), prop::option::of(extension)).prop_map(
        |(product_name, product_version, fixed, extension)| Module {
            number: 1,
            product_name,
            product_version,
            fixed_objects: fixed.into_iter().collect(),
            extensions: extension.into_iter().collect(),
            ..Module::default()
        },
    )
}

fn description(text: BoxedStrategy<String>) -> impl Strategy<Value = DeviceDescription> {
    let device =
        (any::<[Option<u32>; 3]>(), any::<[bool; 5]>(), 0u8..65, 0u16..512, prop::array::uniform3(text.clone()));
    let device =
        device.prop_map(|(numbers, flags, granularity, pdos, [vendor_name, product_name, order_code])| DeviceInfo {
            vendor_name,
            product_name,
            order_code,
            vendor_number: numbers[0],
            product_number: numbers[1],
            revision_number: numbers[2],
            bit_rates: if flags[0] { vec![20, 1000] } else { Vec::new() },
            simple_boot_up_master: flags[1],
            dynamic_channels: flags[2],
            group_messaging: flags[3],
            lss_supported: flags[4],
            granularity,
            rpdos: pdos,
            tpdos: 511 - pdos,
            ..DeviceInfo::default()
        });
    let file = prop::array::uniform4(text.clone()).prop_map(|[name, version, created_by, revision]| FileInfo {
        name,
        version,
        created_by,
        revision,
        created: ("11-21-2026".to_owned(), "09:00PM".to_owned()),
        ..FileInfo::default()
    });
    let commissioning = (1u8..128, prop::array::uniform2(text.clone()), any::<Option<u32>>(), any::<bool>());
    let commissioning =
        commissioning.prop_map(|(id, [node_name, network_name], net_number, is_manager)| Commissioning {
            node_id: NodeId::new(id),
            node_name,
            network_name,
            bit_rate: Some(250),
            net_number,
            is_manager,
            lss_serial_number: net_number,
        });
    let objects = prop::collection::vec(object(text.clone()), 0..6);
    let modules = prop::collection::vec(module(text.clone()), 0..2);
    let comments = prop::collection::vec(text, 0..3);
    (device, file, prop::option::of(commissioning), objects, modules, comments).prop_map(
        |(device, file, commissioning, objects, modules, comments)| DeviceDescription {
            device,
            file,
            dictionary: objects.into_iter().map(|object| configured(object, commissioning.is_some())).collect(),
            commissioning,
            modules,
            comments,
            dummy_usage: [(5, true), (6, false)].into(),
            ..DeviceDescription::default()
        },
    )
}

/// Only the description of a configured device has configured values.
fn configured(mut object: Object, is_configured: bool) -> Object {
    let subs: Vec<SubIndex> = object.entries().iter().map(|entry| entry.sub).collect();
    for sub in subs {
        if let Some(entry) = object.entry_mut(sub).filter(|_| !is_configured) {
            entry.configured = None;
        }
    }
    object
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn descriptions_stay_the_same(description in description(text().boxed())) {
        let (eds, xdd) = (form_of(&description, false), form_of(&description, true));
        let before = meaning(description.clone());
        let written = read(&write(description.clone(), eds).unwrap().0);
        assert_same("in CiA 306", &before, &meaning(written));
        if !description.dictionary.objects().is_empty() {
            let there = read(&write(description, xdd).unwrap().0);
            let back = read(&write(there, eds).unwrap().0);
            assert_same("through CiA 311", &in_xdd(before), &in_xdd(meaning(back)));
        }
    }

    /// Converting a description with arbitrary texts reports every value that changes.
    #[test]
    fn what_changes_is_told(description in description(hostile().boxed())) {
        for xml in [false, true] {
            let form = form_of(&description, xml);
            let (text, losses) = write(description.clone(), form).unwrap();
            let back = read(&text);
            let (before, after) = if xml {
                (in_xdd(meaning(description.clone())), in_xdd(meaning(back)))
            } else {
                (meaning(description.clone()), meaning(back))
            };
            let same = std::panic::catch_unwind(|| assert_same("", &before, &after)).is_ok();
            prop_assert!(same || !losses.is_empty(), "{text}");
        }
    }
}
