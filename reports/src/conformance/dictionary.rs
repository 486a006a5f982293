//! The object dictionary before and after a run, in the words that all reports for people share.

use super::Run;
use crate::page_text::capitalised;
use canvass_analyzer::dictionary::Value;
use canvass_bus::client::sdo::Bytes;
use canvass_suite::comparison::{Change, Comparison};

/// The text before the commands that repair a device that has changed.
pub(super) const REPAIR: &str = "These commands put it back:";

/// The whole comparison, line by line.
pub fn lines(comparison: &Comparison) -> Vec<String> {
    let mut lines = vec![sentence(comparison)];
    lines.extend(rows(comparison).map(|row| format!("  {}", row.join("  "))));
    if !comparison.commands.is_empty() {
        lines.push(REPAIR.to_owned());
        lines.extend(comparison.commands.iter().map(|command| format!("  {command}")));
    }
    lines
}

/// The comparison in one or two sentences.
pub fn sentence(comparison: &Comparison) -> String {
    let Comparison { is_complete, objects, .. } = comparison;
    if !is_complete {
        return "The device does not answer after the run: whether its objects are as they were is not known."
            .to_owned();
    }
    let left = comparison.left().count();
    let others = own(comparison) + &acting(comparison);
    let in_use = match left {
        0 if comparison.is_as_found() => {
            format!("The device is as it was before the run ({objects} objects were read).{others}")
        }
        0 => format!("The {objects} objects are as they were before the run, but the device is not.{others}"),
        1 => format!("1 of {objects} objects is not as it was before the run.{others}"),
        _ => format!("{left} of {objects} objects are not as they were before the run.{others}"),
    };
    let stored = match comparison.stored.len() {
        0 => None,
        1 => Some("1 setting is stored with another value than before: the next start brings it.".to_owned()),
        many => Some(format!("{many} settings are stored with other values than before: the next start brings them.")),
    };
    let sentence = |text: String| capitalised(&text) + ".";
    let zero_points = comparison.zero_points.iter().map(|moved| sentence(moved.to_string()));
    let behaviour = comparison.behaviour.iter().map(|changed| sentence(changed.to_string()));
    [in_use].into_iter().chain(stored).chain(zero_points).chain(behaviour).collect::<Vec<_>>().join(" ")
}

/// The sentence about changed values that the device sets itself; empty if there are none.
fn own(comparison: &Comparison) -> String {
    let own: Vec<&Change> = comparison.own().collect();
    match own.len() {
        0 => String::new(),
        1 => format!(" {}, which the device sets itself, differs.", names(&own)),
        many => format!(" {many} values that the device sets itself differ: {}.", names(&own)),
    }
}

/// The sentence about objects that act when they are written, whose earlier values are not written again; empty if
/// there are none.
fn acting(comparison: &Comparison) -> String {
    let acting: Vec<&Change> = comparison.acting().collect();
    match acting.len() {
        0 => String::new(),
        1 => format!(" {} keeps the value of its last write: another write would act again.", names(&acting)),
        _ => format!(" {} keep the values of their last writes: another write would act again.", names(&acting)),
    }
}

fn names(changes: &[&Change]) -> String {
    const MOST: usize = 20;
    let mut names: Vec<String> = changes.iter().take(MOST).map(|change| change.multiplexer.to_string()).collect();
    let more = changes.len() - names.len();
    if more > 0 {
        names.push(format!("and {more} more"));
    }
    names.join(", ")
}

/// The changes that the run has left, each with its columns: object, name, before, after.
pub(super) fn rows(comparison: &Comparison) -> impl Iterator<Item = [String; 4]> {
    comparison.left().map(|change| row(change, "")).chain(comparison.stored.iter().map(|change| row(change, "stored ")))
}

fn row(change: &Change, place: &str) -> [String; 4] {
    let name = change.name.clone().unwrap_or_default();
    let [before, after] = [&change.before, &change.after].map(|value| shown(change, value.as_deref()));
    [change.multiplexer.to_string(), name, format!("{place}before: {before}"), format!("{place}after: {after}")]
}

/// A value by its type, and its bytes if they say more.
fn shown(change: &Change, value: Option<&[u8]>) -> String {
    let Some(bytes) = value else { return "can't be read".to_owned() };
    let typed = change.data_type.and_then(|data_type| Value::decode(data_type, bytes).ok());
    match typed {
        Some(value @ (Value::Unsigned(_) | Value::Integer(_))) => format!("{value} ({})", Bytes(bytes)),
        Some(value) => value.to_string(),
        None => Bytes(bytes).to_string(),
    }
}

/// The comparison, if the run has left changed values.
pub(super) fn left(run: &Run) -> Option<&Comparison> {
    run.comparison.as_ref().filter(|comparison| rows(comparison).next().is_some())
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::Multiplexer;
    use canvass_analyzer::dictionary::DataType;
    use canvass_analyzer::object;
    use canvass_suite::comparison::Nature;
    use canvass_suite::zero_point::Moved;

    fn change(index: u16, nature: Nature) -> Change {
        Change {
            multiplexer: Multiplexer::new(index, 0),
            name: Some("Producer heartbeat time".to_owned()),
            data_type: Some(DataType::UNSIGNED16),
            nature,
            before: Some(vec![0xE8, 3]),
            after: None,
        }
    }

    #[test]
    fn what_is_left_is_told_with_the_command_that_puts_it_back() {
        let comparison = Comparison {
            is_complete: true,
            objects: 9,
            changes: vec![
                change(object::ERROR_REGISTER, Nature::Own),
                change(object::PRODUCER_HEARTBEAT_TIME, Nature::Setting),
            ],
            commands: vec!["canvass sdo write can0 10 1017:00 E803 --type bytes".to_owned()],
            ..Comparison::default()
        };
        let expected = [
            "1 of 9 objects is not as it was before the run. 1001h:00, which the device sets itself, differs.",
            "  1017h:00  Producer heartbeat time  before: 1000 (E8 03)  after: can't be read",
            "These commands put it back:",
            "  canvass sdo write can0 10 1017:00 E803 --type bytes",
        ];
        assert_eq!(lines(&comparison), expected);
        assert!(!comparison.is_as_found());
    }

    /// The value of a preset is not written again: the user learns that it differs, and why.
    #[test]
    fn an_object_that_acts_is_named_though_the_device_is_as_it_was() {
        let changes = vec![change(0x6003, Nature::Acting)];
        let comparison = Comparison { is_complete: true, objects: 9, changes, ..Comparison::default() };
        assert!(comparison.is_as_found());
        let told = "The device is as it was before the run (9 objects were read). 6003h:00 keeps the value of its last write: \
                    another write would act again.";
        assert_eq!(sentence(&comparison), told);
    }

    /// Stored values, which the next start restores, and the zero point are reported, although neither shows in the
    /// current objects.
    #[test]
    fn what_is_stored_and_the_zero_point_are_told() {
        let stored = Change { after: Some(vec![50, 0]), ..change(object::PRODUCER_HEARTBEAT_TIME, Nature::Setting) };
        let zero_point = Moved {
            steps: 307,
            preset: Multiplexer::new(0x6003, 0),
            position: Multiplexer::new(0x6004, 0),
            range: 10_000,
            is_uncertain: false,
            is_denied: false,
            takes_position: true,
            is_stored: true,
        };
        let comparison = Comparison {
            is_complete: true,
            objects: 9,
            stored: vec![stored],
            zero_points: vec![zero_point],
            ..Comparison::default()
        };
        let expected = [
            "The 9 objects are as they were before the run, but the device is not. 1 setting is stored with another value than \
             before: the next start brings it. The stored zero point was moved by +307 steps. To set it right by hand, at rest: \
             read 6004h:00, and give 6003h:00 that value minus 307, modulo 10000; then store it.",
            "  1017h:00  Producer heartbeat time  stored before: 1000 (E8 03)  stored after: 50 (32 00)",
        ];
        assert_eq!(lines(&comparison), expected);
        assert!(!comparison.is_as_found());
    }

    #[test]
    fn a_device_that_does_not_answer_is_not_as_it_was() {
        let comparison = Comparison { objects: 9, ..Comparison::default() };
        assert!(!comparison.is_as_found() && lines(&comparison)[0].contains("does not answer"));
    }
}
