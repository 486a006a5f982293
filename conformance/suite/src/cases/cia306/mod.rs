//! CiA 306: the device description (EDS, DCF, XDD) in itself, and compared with the device.
//!
//! Problems of a description are found when it is read; each case judges one kind of problem, and every kind belongs to
//! one case. A manufacturer delivers both device and description, so both are tested.

mod device;
pub(crate) mod needs;

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Breach, Judged, Reason, Stop};
use canvass_analyzer::dictionary::{EdsProblem, ProblemKind, Severity, consistency};
use canvass_bus::observation::{Observation, Subject};

/// The subject of a problem in a description.
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

/// The sections about the file or the device as a whole.
const HEADER: [&str; 5] = ["FileInfo", "DeviceInfo", "DummyUsage", "Comments", "DeviceComissioning"];

impl Area {
    fn of(problem: &EdsProblem) -> Self {
        let is_header = HEADER.iter().any(|name| problem.section.eq_ignore_ascii_case(name));
        match problem.kind() {
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

/// Requires that the description has no problem in this area. Each problem is a breach of its own; mere remarks are
/// noted.
fn sound(bench: &mut Bench<'_>, area: Area, duty: &'static str) -> Judged {
    const NOTED: usize = 3;
    const JUDGED: usize = 64;
    let Some(description) = &bench.target().description else {
        let reason = Reason::new("the device is described", "an EDS or a built-in model", "none");
        return Err(Stop::NotApplicable(reason));
    };
    let mut found: Vec<EdsProblem> = description.problems.clone();
    found.extend(consistency::check(description));
    found.retain(|problem| Area::of(problem) == area);
    let (notes, wrong): (Vec<_>, Vec<_>) = found.into_iter().partition(|problem| problem.severity() == Severity::Hint);
    for problem in notes.iter().take(NOTED) {
        bench.note(format!("description: {problem}"));
    }
    let more = wrong.len().saturating_sub(JUDGED);
    for problem in wrong.iter().take(JUDGED) {
        bench.check(Err(Box::new(breach(problem, duty))))?;
    }
    if more > 0 {
        let breach = Breach::new(Subject::Description, duty).expected("no more than these");
        let found = Observation::named("more problems of this kind");
        bench.check(Err(Box::new(breach.found(found).told(format!("{more} more")))))?;
    }
    Ok(())
}

/// A problem as a breach: its subject is the object of its section, otherwise the file.
fn breach(problem: &EdsProblem, duty: &'static str) -> Breach {
    let object = problem.section.to_ascii_lowercase().replace("sub", ":");
    // A section name such as `[1018sub1]` has one digit for the sub-index.
    let object = match object.split_once(':') {
        Some((index, sub)) => format!("{index}:{sub:0>2}"),
        None => object,
    };
    let subject = match object.parse::<Subject>() {
        Ok(subject @ (Subject::Entry(_) | Subject::Object(_))) => subject,
        _ => Subject::Description,
    };
    // The names come from the file: they may hold anything.
    let place: String = format!("[{}] {}", problem.section, problem.field).escape_debug().take(80).collect();
    let found = Observation::Named(format!("problem in {}: {}", place.trim_end(), word(problem.kind())).into());
    Breach::new(subject, duty).expected(problem.expected).found(found).told(problem.to_string())
}

/// The kind of a problem in a word.
const fn word(kind: ProblemKind) -> &'static str {
    match kind {
        ProblemKind::Encoding => "encoding",
        ProblemKind::Line => "line",
        ProblemKind::TooMuch => "too much",
        ProblemKind::DuplicateSection => "section twice",
        ProblemKind::MissingSection => "section missing",
        ProblemKind::UnknownSection => "section unknown",
        ProblemKind::DuplicateField => "field twice",
        ProblemKind::MissingField => "field missing",
        ProblemKind::UnknownField => "field unknown",
        ProblemKind::Number => "number",
        ProblemKind::Count => "count",
        ProblemKind::List => "list",
        ProblemKind::Value => "value",
        ProblemKind::Range => "range",
        ProblemKind::Mapping => "mapping",
        ProblemKind::CobId => "COB-ID",
        ProblemKind::Standard => "differs from the standard",
    }
}

/// A device description consists of lines of text (sections, fields and comments) of no more than 255 characters each.
#[case(id = "306/file/text", clause = "CiA 306", confidence = Unknown, level = Should, needs = [Description],
       catches = [EdsLineWithoutSense])]
fn text(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Text, "every line of the description can be read")
}

/// Every section that CiA 306 requires is present, and no section occurs twice.
#[case(id = "306/file/sections", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsSectionTwice, EdsSubIndexMissing])]
fn sections(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Sections, "the sections of the description are complete")
}

/// Every field that CiA 306 requires is present, and no field occurs twice in its section.
#[case(id = "306/file/fields", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsFieldTwice, EdsDataTypeMissing])]
fn fields(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Fields, "the fields of the description are complete")
}

/// Numbers are decimal, hexadecimal with 0x, or octal with a leading 0; the node-ID precedes a number: `$NODEID+0x180`.
#[case(id = "306/file/numbers", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsNumberUnreadable, EdsFloatDefault])]
fn numbers(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Numbers, "the numbers of the description can be read")
}

/// The counts of list entries, PDOs, sub-indexes and comment lines are correct.
#[case(id = "306/file/counts", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsSubNumberWrong, EdsPdoCountWrong])]
fn counts(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Counts, "the counts in the description are correct")
}

/// The information about the description itself and about the whole device has the format of CiA 306.
#[case(id = "306/file/header", clause = "CiA 306", confidence = Unknown, level = Should, needs = [Description],
       catches = [EdsDateWrong, EdsBooleanWrong])]
fn header(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Header, "FileInfo, DeviceInfo and DummyUsage hold what CiA 306 allows")
}

/// Every described object is listed and every listed object is described: once, in the list of its kind.
#[case(id = "306/objects/lists", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsObjectListedTwice])]
fn lists(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Lists, "the lists of objects and their descriptions agree")
}

/// All object types, data types and access types are defined by CiA 301 or CiA 306.
#[case(id = "306/objects/entries", clause = "CiA 306 4.6.3.2", confidence = Attested, level = Must,
       needs = [Description], catches = [EdsAccessTypeUnknown, EdsVendorNumberDiffers])]
fn entries(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Entries, "object types, data types and access types are defined by the standards")
}

/// Defaults lie within their limits, and limits within their data type.
#[case(id = "306/objects/limits", clause = "CiA 306 4.6.3.2", confidence = Attested, level = Must,
       needs = [Description], catches = [EdsDefaultBeyondLimit])]
fn limits(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Limits, "defaults lie within their limits, and limits within their data type")
}

/// The default mapping is valid: its objects exist, can be mapped in that direction, have the given length and fit into
/// 64 bits, and every PDO has both its parameters.
#[case(id = "306/objects/mapping", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsMappingWrong])]
fn mapping(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Mapping, "the described mapping is valid")
}

/// No default COB-ID is restricted or used twice.
#[case(id = "306/objects/cob-ids", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsCobIdTwice])]
fn cob_ids(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::CobIds, "every default COB-ID is allowed and unique")
}

/// Objects that CiA 301 or the device profile defines have the data type and the access of the standard.
#[case(id = "306/objects/standard", clause = "CiA 306", confidence = Unknown, level = Must, needs = [Description],
       catches = [EdsDataTypeWrong])]
fn standard(bench: &mut Bench<'_>) -> Judged {
    sound(bench, Area::Standard, "standard objects are described as their standard defines them")
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::dictionary::{Rule, Spot, rules};

    fn problem(section: &str, field: &str, rule: &'static Rule) -> EdsProblem {
        let (section, field) = (section.to_owned(), field.to_owned());
        EdsProblem { rule, line: 7, section, field, spot: Spot::Line, expected: "a number", found: "x".to_owned() }
    }

    fn rule(id: &str) -> &'static Rule {
        rules::find(id).unwrap()
    }

    #[test]
    fn a_problem_is_about_its_object_and_about_nothing_else() {
        let of = |section, field, id| {
            let breach = breach(&problem(section, field, rule(id)), "it is right");
            (breach.subject.to_string(), breach.actual.to_string())
        };
        let number = |section| of(section, "DefaultValue", "eds/number/unreadable");
        assert_eq!(
            number("1018sub1"),
            ("1018h:01".to_owned(), "problem in [1018sub1] DefaultValue: number".to_owned())
        );
        assert_eq!(number("1A00subA").0, "1A00h:0A");
        assert_eq!(number("1017").0, "1017h");
        assert_eq!(number("FileInfo").0, "description");
        assert_ne!(number("1017").1, of("1017", "LowLimit", "eds/number/unreadable").1);
    }

    /// A waiver can name the observation of a problem.
    #[test]
    fn a_problem_can_be_waived() {
        use canvass_bus::observation::Pattern;
        let actual = breach(&problem("1017", "LowLimit", rule("eds/entry/limits")), "it is right").actual;
        assert!(actual.to_string().parse::<Pattern>().is_ok_and(|pattern| pattern.accepts(&actual)));
    }
}
