//! Runs of numbers in a message: the position of each number is known beforehand, so one check of the length is enough
//! for the whole run.

use super::fields::{Role, Values};
use super::plan::{Layout, McapStep, sign_extended};
use super::ros_definition::Count;
use std::borrow::Cow;
use std::ops::Range;

/// Numbers and arrays of fixed size, one after the other.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    /// Alignment of the first number. The other numbers need no larger alignment, so the distances do not depend on the
    /// beginning of the run.
    pub(crate) align: usize,
    /// The positions in CDR of both versions, which align numbers of up to four bytes in the same way.
    pub(crate) aligned: Extent,
    /// The positions in ROS 1.
    pub(crate) packed: Extent,
}

/// The positions of a run's values in one of the encodings.
#[derive(Clone, Default, Debug)]
pub(crate) struct Extent {
    /// Length in bytes.
    pub(crate) len: usize,
    /// The numbers with a role.
    values: Vec<Placed>,
    /// The position of the frame's data.
    data: Option<Range<usize>>,
}

/// A number with a role, and its position in the run.
#[derive(Clone, Copy, Debug)]
struct Placed {
    at: usize,
    size: usize,
    role: Role,
    signed: bool,
}

/// The part of a run that one step contributes.
struct Part {
    size: usize,
    count: usize,
    signed: bool,
    role: Option<Role>,
}

/// The largest size of a number in a run: the versions of CDR align numbers of eight bytes differently.
const WIDEST: usize = 4;
/// The maximum length of an array in a run.
const LONGEST: usize = 64;

impl Part {
    /// The step as a part of a run; `None` if it can't be one.
    fn of(step: &McapStep) -> Option<Self> {
        let part = match *step {
            McapStep::Number { size, signed, role } => Self { size, count: 1, signed, role },
            McapStep::Data(Count::Array(count)) => Self { size: 1, count, signed: false, role: Some(Role::Data) },
            McapStep::Numbers { size, count: Count::Array(count) } => Self { size, count, signed: false, role: None },
            _ => return None,
        };
        (part.size <= WIDEST && part.count <= LONGEST).then_some(part)
    }
}

/// Joins adjacent steps with numbers into runs.
pub(crate) fn joined(steps: Vec<McapStep>) -> Vec<McapStep> {
    let mut joined = Vec::with_capacity(steps.len());
    for step in steps {
        let Some(part) = Part::of(&step) else {
            joined.push(step);
            continue;
        };
        match joined.last_mut() {
            Some(McapStep::Run(run)) if part.size <= run.align => run.push(&part),
            _ => {
                let mut run = Run { align: part.size, aligned: Extent::default(), packed: Extent::default() };
                run.push(&part);
                joined.push(McapStep::Run(run));
            }
        }
    }
    joined
}

impl Run {
    fn push(&mut self, part: &Part) {
        self.aligned.len = self.aligned.len.next_multiple_of(part.size);
        self.aligned.push(part);
        self.packed.push(part);
    }

    /// Reads the values that have a role.
    #[inline]
    pub(crate) fn read<'a>(&self, layout: &mut impl Layout<'a>, values: &mut Values<'a>) -> Option<()> {
        let (bytes, extent) = layout.run(self)?;
        for &Placed { at, size, role, signed } in &extent.values {
            let number = layout.placed(bytes.get(at..)?, size)?;
            values.set(role, if signed { sign_extended(number, size) } else { number as i64 });
        }
        if let Some(data) = &extent.data {
            values.data = Cow::Borrowed(bytes.get(data.clone())?);
        }
        Some(())
    }
}

impl Extent {
    fn push(&mut self, part: &Part) {
        let end = self.len + part.size * part.count;
        match part.role {
            Some(Role::Data) => self.data = Some(self.len..end),
            Some(role) => self.values.push(Placed { at: self.len, size: part.size, role, signed: part.signed }),
            None => {}
        }
        self.len = end;
    }
}

#[cfg(test)]
mod tests {
    use super::super::cdr::Cdr;
    use super::super::ros1::Ros1;
    use super::*;
    use proptest::prelude::*;

    fn steps() -> impl Strategy<Value = Vec<McapStep>> {
        let roles = [Role::Id, Role::Dlc, Role::Extended, Role::Remote, Role::Seconds, Role::Nanoseconds];
        let sizes = prop::sample::select(vec![1_usize, 2, 4, 8]);
        let number = (sizes.clone(), any::<bool>(), prop::option::of(prop::sample::select(roles.to_vec())))
            .prop_map(|(size, signed, role)| McapStep::Number { size, signed, role });
        let numbers = (sizes, 1..5_usize).prop_map(|(size, n)| McapStep::Numbers { size, count: Count::Array(n) });
        let data = prop::sample::select(vec![Count::Array(8), Count::Array(64), Count::Sequence(None)]);
        let text = Just(McapStep::Text { wide: false });
        prop::collection::vec(
            prop_oneof![4 => number, 1 => numbers, 1 => data.prop_map(McapStep::Data), 1 => text],
            1..12,
        )
    }

    fn read<'a>(steps: &[McapStep], mut layout: impl Layout<'a>) -> Option<String> {
        let mut values = Values::default();
        steps.iter().try_for_each(|step| step.read(&mut layout, &mut values))?;
        Some(format!("{values:?}"))
    }

    proptest! {
        #[test]
        fn joined_or_not_the_values_are_the_same(
            steps in steps(),
            representation in prop::sample::select(vec![0_u8, 1, 6, 7]),
            body in prop::collection::vec(prop_oneof![3 => 0..3_u8, 1 => any::<u8>()], 0..200),
        ) {
            let runs = joined(steps.clone());
            let message = [&[0, representation, 0, 0][..], &body].concat();
            let cdr = || Cdr::new(&message).unwrap();
            prop_assert_eq!(read(&runs, cdr()), read(&steps, cdr()));
            prop_assert_eq!(read(&runs, Ros1(&body)), read(&steps, Ros1(&body)));
        }
    }

    #[test]
    fn a_frame_of_ros_is_two_runs_around_a_text() {
        let number = |size, role| McapStep::Number { size, signed: false, role: Some(role) };
        let steps = vec![
            number(4, Role::Seconds),
            number(4, Role::Nanoseconds),
            McapStep::Text { wide: false },
            number(4, Role::Id),
            number(1, Role::Remote),
            number(1, Role::Dlc),
            McapStep::Data(Count::Array(8)),
        ];
        let runs = joined(steps);
        assert!(matches!(&runs[..], [McapStep::Run(_), McapStep::Text { .. }, McapStep::Run(_)]), "{runs:?}");
    }
}
