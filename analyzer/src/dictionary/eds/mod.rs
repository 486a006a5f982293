//! Electronic data sheets (EDS) and device configuration files (DCF), CiA 306.
//!
//! The reader accepts the variants that occur in the field and reports every deviation from the standard: a
//! description with errors is still useful.

mod compact;
mod fields;
mod header;
mod lists;
mod modules;
pub(super) mod number;
mod objects;
mod unkept;
mod write;

use crate::object;
pub(super) use fields::setting;
pub(super) use lists::list_of;
pub(super) use objects::access_of_habit;
pub(super) use unkept::unkept;
pub(super) use write::text_of;
pub use write::write;

use super::description::{DeviceDescription, DeviceInfo, FileInfo};
use super::problem::Problems;
use super::rules;
pub use super::source::{DescriptionError, LARGEST_FILE};
use super::source::{FieldName, Format, SectionName, Source};

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
    describe(&Source::read_as(Format::Ini, bytes)?)
}

/// The content of an EDS or DCF.
pub(super) fn describe(source: &Source<'_>) -> Result<DeviceDescription, DescriptionError> {
    if source.sections().all(|section| section.about() == SectionName::Unknown) {
        return Err(DescriptionError::NoSections);
    }
    let mut problems = source.problems();
    let mut description = described(source, &mut problems);
    description.problems = problems.into_sorted();
    Ok(description)
}

fn described(source: &Source<'_>, problems: &mut Problems) -> DeviceDescription {
    let mut description = DeviceDescription {
        file: FileInfo { eds_version: "3.0".to_owned(), ..FileInfo::default() },
        ..DeviceDescription::default()
    };
    header::check_sections(source, problems);
    for section in source.sections() {
        match section.about() {
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
                problems.report(section.place(), &rules::section::UNKNOWN, expected, section.name());
            }
            _ => {}
        }
    }
    description.dictionary = objects::read(source, problems);
    description.lists = lists::read(source, &description.dictionary, problems);
    lists::check_links(source, &description.dictionary, problems);
    header::check_last_eds(source, &description, problems);
    description.modules = modules::read(source, problems);
    description.connected_modules = modules::connected(source, problems);
    compact::add_pdos(&description.device, &mut description.dictionary);
    check_pdo_counts(source, &description, problems);
    description
}

/// `NrOfRXPDO` and `NrOfTXPDO` are the numbers of 14xxh and 18xxh objects.
fn check_pdo_counts(source: &Source<'_>, description: &DeviceDescription, problems: &mut Problems) {
    let Some(section) = source.section("DeviceInfo") else { return };
    let DeviceInfo { rpdos, tpdos, .. } = description.device;
    for (field, first, announced) in [
        (FieldName::NrOfRxPdo, object::RPDO_COMMUNICATION_PARAMETER, rpdos),
        (FieldName::NrOfTxPdo, object::TPDO_COMMUNICATION_PARAMETER, tpdos),
    ] {
        let range = first..first + 0x200;
        let objects = description.dictionary.objects().iter().filter(|object| range.contains(&object.index.0)).count();
        if objects != usize::from(announced) {
            let found = format!("{objects} PDOs described");
            let expected = "the number of described PDOs";
            problems.report(section.place_of(field), &rules::file::PDO_COUNT, expected, &found);
        }
    }
}
