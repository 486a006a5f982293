//! Liberties in the text of an EDS: the device itself is the same.

use super::{Liberties, Liberty};
use canvass_analyzer::object;

/// The liberties that change only the text of the EDS.
const OF_TEXT: [Liberty; 7] = [
    Liberty::EdsWithoutLimits,
    Liberty::EdsObjFlags,
    Liberty::EdsCompactSubObj,
    Liberty::EdsOneDigitHour,
    Liberty::EdsListsOutOfOrder,
    Liberty::EdsInlineComments,
    Liberty::EdsLatin1,
];

/// Whether one of the liberties changes the text of the EDS.
pub(crate) fn changes_text(liberties: Liberties) -> bool {
    OF_TEXT.iter().any(|&liberty| liberties.has(liberty))
}

/// Rewrites the text of an EDS as a maker whose devices take these liberties would write it.
pub(crate) fn rewrite(text: &str, liberties: Liberties) -> Vec<u8> {
    let has = |liberty| liberties.has(liberty);
    let mut text = text.to_owned();
    if has(Liberty::EdsCompactSubObj) {
        text = [object::PREDEFINED_ERROR_FIELD, object::CONSUMER_HEARTBEAT_TIME]
            .into_iter()
            .fold(text, |text, index| compact(&text, index));
    }
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    if has(Liberty::EdsWithoutLimits) {
        lines.retain(|line| !line.starts_with("LowLimit=") && !line.starts_with("HighLimit="));
    }
    if has(Liberty::EdsListsOutOfOrder) {
        swap_first_keys(&mut lines);
    }
    let mut section = String::new();
    for line in &mut lines {
        if line.starts_with('[') {
            section.clone_from(line);
        }
        if has(Liberty::EdsOneDigitHour) && line.contains("Time=0") {
            *line = line.replacen("Time=0", "Time=", 1);
        }
        let is_command = section.starts_with("[1010sub") || section.starts_with("[1011sub");
        if has(Liberty::EdsObjFlags) && is_command && line.starts_with("AccessType=rw") {
            line.push_str("\nObjFlags=0x1");
        }
        if has(Liberty::EdsInlineComments) && line.starts_with("ObjectType=0x7") {
            line.push_str(" # VAR");
        }
    }
    let mut bytes = (lines.join("\n") + "\n").into_bytes();
    if has(Liberty::EdsLatin1) {
        insert_after(&mut bytes, b"VendorName=", b"M\xFCller ");
    }
    bytes
}

/// Replaces the sections of an array's sub-indexes by `CompactSubObj` in the section of the array.
fn compact(text: &str, index: u16) -> String {
    let own = |section: &str| section.starts_with(&format!("[{index:04X}sub"));
    let mut compacted = String::new();
    let mut in_own = false;
    let count = text.lines().filter(|line| own(line)).count().saturating_sub(1);
    let entry = format!("[{index:04X}sub1]");
    let field = |name: &str| {
        let section = text.lines().skip_while(|line| *line != entry).skip(1);
        section.take_while(|line| !line.starts_with('[')).find(|line| line.starts_with(name)).unwrap_or_default()
    };
    for line in text.lines() {
        if line.starts_with('[') {
            in_own = own(line);
        }
        let is_object = line == format!("[{index:04X}]");
        if !in_own {
            compacted.push_str(line);
            compacted.push('\n');
        }
        if is_object {
            for line in [&format!("CompactSubObj={count}"), field("DataType="), field("AccessType="), "PDOMapping=0"] {
                compacted.push_str(line);
                compacted.push('\n');
            }
        }
    }
    // SubNumber and CompactSubObj exclude each other.
    let object = format!("[{index:04X}]\n");
    let Some(begin) = compacted.find(&object) else { return compacted };
    let end = compacted.get(begin + 1..).and_then(|rest| rest.find("\n[")).map_or(compacted.len(), |at| begin + 1 + at);
    let (head, rest) = compacted.split_at(begin);
    let (section, tail) = rest.split_at(end - begin);
    let kept: String =
        section.lines().filter(|line| !line.starts_with("SubNumber=")).map(|line| format!("{line}\n")).collect();
    format!("{head}{kept}{}", tail.trim_start_matches('\n').replacen('[', "\n[", 1))
}

/// Swaps the first two keys of each list of objects.
fn swap_first_keys(lines: &mut [String]) {
    let firsts: Vec<usize> = lines
        .windows(2)
        .enumerate()
        .filter(|(_, pair)| matches!(pair, [one, two] if one.starts_with("1=0x") && two.starts_with("2=0x")))
        .map(|(at, _)| at)
        .collect();
    firsts.into_iter().for_each(|at| lines.swap(at, at + 1));
}

fn insert_after(bytes: &mut Vec<u8>, mark: &[u8], inserted: &[u8]) {
    if let Some(at) = bytes.windows(mark.len()).position(|window| window == mark) {
        let at = at + mark.len();
        bytes.splice(at..at, inserted.iter().copied());
    }
}
