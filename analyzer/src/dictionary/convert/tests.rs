//! A written description reads as the original one, in the same format and through the other one.

use super::{ConvertError, Form, convert, prepare, write};
use crate::dictionary::check::check;
use crate::dictionary::description::{DeviceDescription, ObjectLists};
use crate::dictionary::loss::LossKind;
use crate::dictionary::moment::{eds_date, eds_time};
use crate::dictionary::object::{Access, Object, ObjectDictionary};
use crate::dictionary::{ProblemKind, Severity};
use crate::identity::Multiplexer;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

mod generated;

/// Every description of the repository, with its name.
fn files() -> Vec<(PathBuf, Vec<u8>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let folders = [
        "analyzer/tests/eds",
        "analyzer/tests/xdd",
        "analyzer/tests/difference",
        "conformance/device/models",
        "conformance/suite/tests/published",
        "tests/stacks",
    ];
    let mut files = Vec::new();
    for folder in folders {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let ending = path.extension().unwrap_or_default().to_string_lossy().into_owned();
            if Form::ALL.iter().any(|form| form.name() == ending) {
                files.push((path.clone(), std::fs::read(&path).unwrap()));
            }
        }
    }
    assert!(files.len() > 90, "{}", files.len());
    files
}

/// Normalises a description for a comparison: removes line numbers, problems and the parts that a writer generates, and
/// fills in the numbers of `DeviceInfo` from 1018h.
fn meaning(mut description: DeviceDescription) -> DeviceDescription {
    prepare::expand(&mut description);
    description.problems.clear();
    description.lists = ObjectLists::default();
    description.file.eds_version.clear();
    for (date, time) in [&mut description.file.created, &mut description.file.modified] {
        *date = eds_date(date).unwrap_or_else(|| date.clone());
        *time = eds_time(time).unwrap_or_else(|| time.clone());
    }
    // CiA 306: these numbers of `DeviceInfo` are the defaults of 1018h.
    let identity = |sub| {
        let entry = description.dictionary.entry(Multiplexer::new(0x1018, sub)).ok()?;
        u32::try_from(entry.default.as_ref()?.fixed()?.to_raw()?).ok()
    };
    let [vendor, product, revision] = [1, 2, 3].map(identity);
    let device = &mut description.device;
    device.vendor_number = device.vendor_number.or(vendor);
    device.product_number = device.product_number.or(product);
    device.revision_number = device.revision_number.or(revision);
    description.dictionary = description.dictionary.objects().iter().map(without_lines).collect::<ObjectDictionary>();
    for module in &mut description.modules {
        module.fixed_objects.iter_mut().for_each(|object| *object = without_lines(object));
        module.extensions.iter_mut().for_each(|extension| extension.template = without_lines(&extension.template));
    }
    description
}

fn without_lines(object: &Object) -> Object {
    let mut plain = object.clone();
    (plain.line, plain.section) = (0, None);
    for entry in object.entries() {
        let mut entry = entry.clone();
        (entry.line, entry.section) = (0, None);
        entry.denotation = entry.denotation.filter(|text| !text.is_empty());
        plain.insert(entry);
    }
    plain
}

/// Reduces a description to the parts that an XDD can express.
fn in_xdd(mut description: DeviceDescription) -> DeviceDescription {
    let file = &mut description.file;
    (file.revision, file.description, file.last_eds) = (String::new(), String::new(), None);
    description.comments.clear();
    description.modules.clear();
    description.connected_modules.clear();
    description.device.revision_number = None;
    if let Some(commissioning) = &mut description.commissioning {
        commissioning.lss_serial_number = None;
    }
    let objects: Vec<Object> = description.dictionary.objects().to_vec();
    for mut object in objects {
        for mut entry in object.entries().to_vec() {
            if !entry.pdo_mappable && matches!(entry.access, Access::Rwr | Access::Rww) {
                entry.access = Access::Rw;
            }
            object.insert(entry);
        }
        description.dictionary.insert(object);
    }
    meaning(description)
}

/// Descriptions are large: a failure shows only the first difference.
#[track_caller]
fn assert_same(name: &str, old: &DeviceDescription, new: &DeviceDescription) {
    let text = |description: &DeviceDescription| {
        // A data type that `DummyUsage` does not list is not usable.
        let dummies: Vec<u16> =
            description.dummy_usage.iter().filter(|(_, usable)| **usable).map(|(&index, _)| index).collect();
        // NaN is not equal to itself, but its text is.
        format!(
            "{:#?}",
            (
                &description.file,
                &description.device,
                &description.commissioning,
                &dummies,
                &description.comments,
                description.dictionary.objects(),
                &description.modules,
                &description.connected_modules
            )
        )
    };
    let (old, new) = (text(old), text(new));
    if let Some((before, after)) = old.lines().zip(new.lines()).find(|(old, new)| old != new) {
        panic!("{name}: {before} became {after}");
    }
    assert_eq!(old.lines().count(), new.lines().count(), "{name}");
}

fn read(text: &str) -> DeviceDescription {
    DeviceDescription::read(text.as_bytes()).unwrap()
}

fn form_of(description: &DeviceDescription, xml: bool) -> Form {
    match (description.is_configuration(), xml) {
        (false, false) => Form::Eds,
        (true, false) => Form::Dcf,
        (false, true) => Form::Xdd,
        (true, true) => Form::Xdc,
    }
}

/// Whether writing the description changes a value.
fn is_changed(description: &DeviceDescription, form: Form) -> bool {
    let (_, losses) = write(description.clone(), form).unwrap();
    losses.iter().any(|loss| matches!(loss.kind, LossKind::Changed(_)))
}

#[test]
fn files_keep_their_meaning_in_cia_306_and_through_cia_311() {
    for (path, bytes) in files() {
        let name = path.display().to_string();
        let Ok(description) = DeviceDescription::read(&bytes) else { continue };
        let (eds, xdd) = (form_of(&description, false), form_of(&description, true));
        let written = read(&write(description.clone(), eds).unwrap().0);
        let before = meaning(description.clone());
        // Neither format can hold control characters; an object with an unknown object code becomes a VAR in an XDD.
        if ["escape-sequence.eds", "unknown-object-type.eds"].iter().any(|file| name.ends_with(file)) {
            assert!(is_changed(&description, xdd), "{name}");
            continue;
        }
        assert_same(&name, &before, &meaning(written));
        let there = read(&write(description.clone(), xdd).unwrap().0);
        let back = read(&write(there, eds).unwrap().0);
        assert_same(&name, &in_xdd(before), &in_xdd(meaning(back)));
    }
}

#[test]
fn what_is_written_has_no_errors_that_were_not_there() {
    for (path, bytes) in files() {
        let Ok(description) = DeviceDescription::read(&bytes) else { continue };
        let errors = |bytes: &[u8]| {
            let mut errors: BTreeMap<String, usize> = BTreeMap::new();
            for finding in check(bytes, None).unwrap().findings {
                if finding.severity() == Severity::Error {
                    let kind = finding.problem.rule.kind;
                    // A missing part is a field in CiA 306 and an attribute in CiA 311, so kinds of problems are
                    // compared, not rules.
                    assert_ne!(kind, ProblemKind::TooMuch);
                    *errors.entry(format!("{kind:?}")).or_default() += 1;
                }
            }
            errors
        };
        let before = errors(&bytes);
        for form in [form_of(&description, false), form_of(&description, true)] {
            let converted = convert(&bytes, form, Some("new.eds")).unwrap();
            for (kind, number) in errors(converted.text.as_bytes()) {
                let known = before.get(&kind).copied().unwrap_or(0);
                assert!(number <= known, "{} as {form}: {number} {kind}, {known} before", path.display());
            }
        }
    }
}

#[test]
fn a_type_of_device_is_no_configuration() {
    let eds = include_bytes!("../../../tests/eds/plain.eds");
    for form in [Form::Dcf, Form::Xdc] {
        assert_eq!(convert(eds, form, None).unwrap_err(), ConvertError::NotConfigured(form));
    }
    assert!(matches!(convert(b"nothing", Form::Xdd, None), Err(ConvertError::Description(_))));
}

#[test]
fn what_is_lost_is_said_with_its_place() {
    let dcf = include_str!("../../../tests/eds/dcf.eds");
    let dcf = dcf
        .replace("ParameterValue=77", "ParameterValue=77\nUploadFile=a.bin")
        .replace("[2000]", "; a comment\n[2000]")
        .replace("LSS_Supported=0", "LSS_Supported=0\nExtendedBootUpSlave=1")
        .replace("DefaultValue=0x196", "DefaultValue=never");
    let losses = |form| -> Vec<String> {
        convert(dcf.as_bytes(), form, None).unwrap().losses.iter().map(ToString::to_string).collect()
    };
    let always = [
        "line 32, [DeviceInfo] ExtendedBootUpSlave \"1\": is not kept",
        "line 51, [1000] DefaultValue \"never\": can't be read",
        "line 107, a comment \"; a comment\": is not kept",
        "line 117, [2000] UploadFile \"a.bin\": is not kept",
    ];
    assert_eq!(losses(Form::Dcf), always);
    let of_xdc = [
        "[FileInfo] FileRevision \"0\": the format has no place for it",
        "[FileInfo] Description \"corpus\": the format has no place for it",
        "[FileInfo] LastEDS \"plain.eds\": the format has no place for it",
        "[DeviceInfo] RevisionNumber \"0x3\": the format has no place for it",
        "[Comments] of 1 lines \"one\": the format has no place for it",
        "[DeviceComissioning] LSS_SerialNumber \"0x7\": the format has no place for it",
    ];
    assert_eq!(losses(Form::Xdc), [&always[..], &of_xdc[..]].concat());
    let of_eds = [
        "[DeviceComissioning] \"node-ID, bit rate and names\": the format has no place for it",
        "[FileInfo] LastEDS \"plain.eds\": the format has no place for it",
        "line 108, 2000h:00 ParameterValue \"77\": the format has no place for it",
        "line 108, 2000h:00 Denotation \"Limit of the door\": the format has no place for it",
    ];
    assert_eq!(losses(Form::Eds), [&always[..], &of_eds[..]].concat());
}

#[test]
fn what_an_xdd_has_beyond_is_said_once_for_each_kind() {
    let xdd = include_str!("../../../tests/xdd/parameters.xdd");
    let xdd = xdd
        .replace(
            "<co:label lang=\"en\">Setting</co:label>",
            "<co:label lang=\"en\">Setting</co:label><co:unit multiplier=\"1\"/><co:unit multiplier=\"2\"/>",
        )
        .replace("<co:parameterList>", "<co:dataTypeList><co:array name=\"a\"/></co:dataTypeList><co:parameterList>")
        .replace("name=\"Identity\"", "name=\"Identity\" edseditor_extenstion=\"x\"");
    let losses: Vec<String> =
        convert(xdd.as_bytes(), Form::Eds, None).unwrap().losses.iter().map(ToString::to_string).collect();
    assert_eq!(
        losses,
        [
            "line 9, CANopenObject edseditor_extenstion \"x\": is not kept",
            "line 21, dataTypeList: is not kept",
            "line 28, unit: is not kept, nor 1 more",
        ]
    );
}

#[test]
fn files_of_the_writer_lose_nothing_when_they_are_read_again() {
    for (path, bytes) in files() {
        let Ok(description) = DeviceDescription::read(&bytes) else { continue };
        for form in [form_of(&description, false), form_of(&description, true)] {
            let once = convert(&bytes, form, None).unwrap().text;
            let again = convert(once.as_bytes(), form, None).unwrap();
            assert_eq!(again.losses, [], "{} as {form}", path.display());
            assert_eq!(again.text, once, "{} as {form}", path.display());
        }
    }
}
