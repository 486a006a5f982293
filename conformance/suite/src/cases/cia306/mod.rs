//! CiA 306: the device description (EDS, DCF, XDD) in itself, and against the device.
//!
//! What is wrong in a description was found when it was read; each case judges one kind of problem, and every kind
//! belongs to one case. A maker of devices delivers both, so both are tested.

mod device;
pub(crate) mod needs;

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::dictionary::{EdsProblem, ProblemKind, Severity, consistency};

/// What a problem of a description is about.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Area {
    Text,
    Sections,
    Fields,
    Numbers,
    Counts,
    Header,
    Lists,
    Entries,
    Limits,
    Mapping,
    CobIds,
    Standard,
}

/// The sections that say something about the file or the device as a whole.
const HEADER: [&str; 5] = ["FileInfo", "DeviceInfo", "DummyUsage", "Comments", "DeviceComissioning"];

impl Area {
    fn of(problem: &EdsProblem) -> Self {
        let is_header = HEADER.iter().any(|name| problem.section.eq_ignore_ascii_case(name));
        match problem.kind {
            ProblemKind::Encoding | ProblemKind::Line | ProblemKind::TooMuch => Self::Text,
            ProblemKind::DuplicateSection | ProblemKind::MissingSection | ProblemKind::UnknownSection => Self::Sections,
            ProblemKind::DuplicateField | ProblemKind::MissingField | ProblemKind::UnknownField => Self::Fields,
            ProblemKind::Number => Self::Numbers,
            ProblemKind::Count => Self::Counts,
            ProblemKind::List => Self::Lists,
            ProblemKind::Value if is_header => Self::Header,
            ProblemKind::Value => Self::Entries,
            ProblemKind::Range => Self::Limits,
            ProblemKind::Mapping => Self::Mapping,
            ProblemKind::CobId => Self::CobIds,
            ProblemKind::Standard => Self::Standard,
        }
    }
}

/// Demands that the description has no problem of that area. What is only worth knowing is noted.
fn sound(bench: &mut Bench<'_>, area: Area, duty: &str) -> Judged {
    const SHOWN: usize = 3;
    let Some(description) = &bench.target().description else {
        let reason = Reason::new("the device is described", "an EDS or a built-in model", "none");
        return Err(Stop::NotApplicable(reason));
    };
    let mut found: Vec<EdsProblem> = description.problems.clone();
    found.extend(consistency::check(description));
    found.retain(|problem| Area::of(problem) == area);
    let (notes, wrong): (Vec<_>, Vec<_>) = found.into_iter().partition(|problem| problem.severity == Severity::Info);
    for problem in notes.iter().take(SHOWN) {
        bench.note(format!("description: {problem}"));
    }
    bench.check(demand(wrong.is_empty(), || {
        let shown: Vec<String> = wrong.iter().take(SHOWN).map(ToString::to_string).collect();
        let more = match wrong.len().saturating_sub(SHOWN) {
            0 => String::new(),
            more => format!("; and {more} more"),
        };
        let expected = wrong.first().map_or("", |problem| problem.expected);
        Reason::new(duty, expected, format!("{}{more}", shown.join("; ")))
    }))
}

/// A device description is lines of text: sections, fields and comments, of no more than 255 characters each.
#[case(id = "306/file/text", clause = "CiA 306", confidence = Unknown, level = Should, needs = [Description],
       catches = [EdsLineWithoutSense])]
fn text(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Text, "every line of the description can be read")
}

/// Every section that CiA 306 asks for is there, and none is there twice.
#[case(id = "306/file/sections", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsSectionTwice, EdsSubIndexMissing])]
fn sections(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Sections, "the sections of the description are complete")
}

/// Every field that CiA 306 asks for is there, and none is there twice in its section.
#[case(id = "306/file/fields", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsFieldTwice, EdsDataTypeMissing])]
fn fields(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Fields, "the fields of the description are complete")
}

/// Numbers are decimal, hexadecimal with 0x, or octal with a leading 0; the node-ID stands in front: `$NODEID+0x180`.
#[case(id = "306/file/numbers", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsNumberUnreadable, EdsFloatDefault])]
fn numbers(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Numbers, "the numbers of the description can be read")
}

/// Counts are right: of the entries of a list, of the PDOs, of the sub-indexes, of the lines of comments.
#[case(id = "306/file/counts", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsSubNumberWrong, EdsPdoCountWrong])]
fn counts(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Counts, "what the description counts is there")
}

/// What the description says about itself and about the device as a whole has the form that CiA 306 gives it.
#[case(id = "306/file/header", clause = "CiA 306", confidence = Unknown, level = Should, needs = [Description],
       catches = [EdsDateWrong, EdsBooleanWrong])]
fn header(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Header, "FileInfo, DeviceInfo and DummyUsage hold what CiA 306 allows")
}

/// Every object that is described is listed, and every one that is listed is described: once, in the list of its kind.
#[case(id = "306/objects/lists", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsObjectListedTwice])]
fn lists(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Lists, "the lists of objects and their descriptions agree")
}

/// Object types, data types and access types are those that CiA 301 and CiA 306 define.
#[case(id = "306/objects/entries", clause = "CiA 306 4.6.3.2", confidence = Attested, level = Must,
       needs = [Description], catches = [EdsAccessTypeUnknown, EdsVendorNumberDiffers])]
fn entries(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Entries, "every object is described by what the standards define")
}

/// Defaults lie within their limits, and limits within their data type.
#[case(id = "306/objects/limits", clause = "CiA 306 4.6.3.2", confidence = Attested, level = Must,
       needs = [Description], catches = [EdsDefaultBeyondLimit])]
fn limits(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Limits, "defaults and limits go together")
}

/// The mapping as delivered can work: objects that exist, can be mapped in that direction, have that length, and fit
/// into 64 bits; every PDO has both its parameters.
#[case(id = "306/objects/mapping", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsMappingWrong])]
fn mapping(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Mapping, "the described mapping can work")
}

/// No default COB-ID is restricted or used twice.
#[case(id = "306/objects/cob-ids", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsCobIdTwice])]
fn cob_ids(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::CobIds, "every default COB-ID is allowed and its own")
}

/// Objects that CiA 301 or the device profile defines are described with the standard's type and access.
#[case(id = "306/objects/standard", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsDataTypeWrong])]
fn standard(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Standard, "standard objects are described as their standard defines them")
}
