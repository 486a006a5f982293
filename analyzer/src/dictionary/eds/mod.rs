//! Electronic data sheets (EDS) and device configuration files (DCF), CiA 306.
//!
//! The reader takes what the field has and names everything that the standard has otherwise: a description with
//! errors is worth more than none.

mod compact;
mod field_name;
mod fields;
mod header;
mod lexer;
mod lines;
mod lists;
mod modules;
pub(super) mod number;
mod objects;
mod section_name;
mod text;
mod unkept;
mod write;

use crate::object;
use field_name::FieldName;
pub(super) use fields::setting;
pub(super) use lexer::is_same;
pub(super) use lists::list_of;
pub(super) use objects::access_of_habit;
use section_name::SectionName;
pub(super) use section_name::{address_of_section, standard_section_name};
pub(super) use text::decode as decode_text;
pub(super) use unkept::unkept;
pub(super) use write::text_of;
pub use write::write;

use super::description::{DeviceDescription, DeviceInfo, FileInfo};
use super::problem::Problems;
use super::rules;

/// A file with more bytes is no device description: the largest ones of modular devices have some megabytes.
pub const LARGEST_FILE: usize = 16 << 20;

/// Why a file could not be read at all.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DescriptionError {
    /// The file is larger than [`LARGEST_FILE`].
    #[error("expected a device description of at most {LARGEST_FILE} bytes, found {found}")]
    TooLarge {
        /// Its length in bytes.
        found: usize,
    },
    /// There is no section at all.
    #[error("expected the sections of an EDS such as [FileInfo] or [1000], found none")]
    NoSections,
    /// The file is XML, but not a CANopen device description.
    #[error("expected a CANopen XDD with a CANopenObjectList, found {found}")]
    NotCanopen {
        /// What was found.
        found: String,
    },
    /// The file is XML that ends, because of an error in it, before its first object.
    #[error("line {line}: expected well-formed XML with a CANopenObjectList, found {found}")]
    Malformed {
        /// The line, from 1.
        line: u32,
        /// What the reader of XML says of it.
        found: String,
    },
}

/// Reads an EDS or DCF.
///
/// ```
/// use canvass_analyzer::Multiplexer;
/// use canvass_analyzer::dictionary::{DataType, eds};
///
/// let text = "[OptionalObjects]\nSupportedObjects=1\n1=0x1017\n\
///             [1017]\nParameterName=Producer heartbeat time\nDataType=0x0006\nAccessType=rw\nDefaultValue=500\n";
/// let description = eds::read(text.as_bytes())?;
/// let entry = description.dictionary.entry(Multiplexer::new(0x1017, 0)).unwrap();
/// assert_eq!((entry.name.as_ref(), entry.data_type), ("Producer heartbeat time", DataType::UNSIGNED16));
/// assert!(!description.problems.is_empty(), "objects that every device has are missing");
/// # Ok::<(), eds::DescriptionError>(())
/// ```
pub fn read(bytes: &[u8]) -> Result<DeviceDescription, DescriptionError> {
    if bytes.len() > LARGEST_FILE {
        return Err(DescriptionError::TooLarge { found: bytes.len() });
    }
    let mut problems = Problems::default();
    let text = text::decode(bytes, &mut problems);
    let document = lexer::read(&text, &mut problems);
    if document.sections.iter().all(|section| section.about == SectionName::Unknown) {
        return Err(DescriptionError::NoSections);
    }
    let mut description = describe(&document, &mut problems);
    description.problems = problems.into_sorted();
    Ok(description)
}

fn describe(document: &lexer::Document<'_>, problems: &mut Problems) -> DeviceDescription {
    let mut description = DeviceDescription {
        file: FileInfo { eds_version: "3.0".to_owned(), ..FileInfo::default() },
        ..DeviceDescription::default()
    };
    header::check_sections(document, problems);
    for section in &document.sections {
        match section.about {
            SectionName::FileInfo => description.file = header::file_info(section, problems),
            SectionName::DeviceInfo => description.device = header::device_info(section, problems),
            SectionName::DummyUsage => description.dummy_usage = header::dummy_usage(section, problems),
            SectionName::Comments => description.comments = header::comments(section, problems),
            SectionName::DeviceCommissioning => {
                description.commissioning = Some(header::commissioning(section, problems));
                header::check_spelling(section, problems);
            }
            SectionName::Unknown => {
                let expected = "a section that CiA 306 defines";
                problems.report(section.place(), &rules::section::UNKNOWN, expected, section.name);
            }
            _ => {}
        }
    }
    description.dictionary = objects::read(document, problems);
    description.lists = lists::read(document, &description.dictionary, problems);
    lists::check_links(document, &description.dictionary, problems);
    header::check_last_eds(document, &description, problems);
    description.modules = modules::read(document, problems);
    description.connected_modules = modules::connected(document, problems);
    compact::add_pdos(&description.device, &mut description.dictionary);
    check_pdo_counts(document, &description, problems);
    description
}

/// `NrOfRXPDO` and `NrOfTXPDO` are the numbers of 14xxh and 18xxh objects.
fn check_pdo_counts(document: &lexer::Document<'_>, description: &DeviceDescription, problems: &mut Problems) {
    let Some(section) = document.section("DeviceInfo") else { return };
    let DeviceInfo { rpdos, tpdos, .. } = description.device;
    for (field, first, announced) in [
        (FieldName::NrOfRxPdo, object::RPDO_COMMUNICATION_PARAMETER, rpdos),
        (FieldName::NrOfTxPdo, object::TPDO_COMMUNICATION_PARAMETER, tpdos),
    ] {
        let range = first..first + 0x200;
        let objects = description.dictionary.objects().iter().filter(|object| range.contains(&object.index.0)).count();
        if objects != usize::from(announced) {
            let found = format!("{objects} PDOs described");
            let expected = "the number of PDOs that are described";
            problems.report(section.place_of(field), &rules::file::PDO_COUNT, expected, &found);
        }
    }
}
