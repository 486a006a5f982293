//! Runs of numbers in a message: where each stands is known beforehand, so that a run costs one look at the bytes' end.

use super::fields::{Role, Values};
use super::plan::{Layout, Step, sign_extended};
use super::ros_definition::Count;
use std::borrow::Cow;

/// Numbers and arrays of fixed size, one behind the other.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    /// How many bytes its first number is aligned to. None of the others asks for more, so the distances between
    /// them don't depend on where the run begins.
    pub(crate) align: usize,
    /// In CDR up to version 2, which align numbers of up to four bytes in the same way.
    pub(crate) aligned: Extent,
    /// In ROS 1.
    pub(crate) packed: Extent,
}

/// A run in one of the encodings.
#[derive(Clone, Default, Debug)]
pub(crate) struct Extent {
    /// In bytes.
    pub(crate) len: usize,
    /// Those that have a role.
    pub(crate) values: Vec<Placed>,
}

/// A value with a role in its place in a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    at: usize,
    len: usize,
    role: Role,
    signed: bool,
}

/// What a step of a run takes.
struct Part {
    size: usize,
    count: usize,
    signed: bool,
    role: Option<Role>,
}

/// The longest number in a run: those of eight bytes are aligned differently by the versions of CDR.
const WIDEST: usize = 4;
/// The longest array in a run.
const LONGEST: usize = 64;

impl Part {
    /// The step as a part of a run; `None` if it can't be one.
    fn of(step: &Step) -> Option<Self> {
        let part = match *step {
            Step::Number { size, signed, role } => Self { size, count: 1, signed, role },
            Step::Data(Count::Array(count)) => Self { size: 1, count, signed: false, role: Some(Role::Data) },
            Step::Numbers { size, count: Count::Array(count) } => Self { size, count, signed: false, role: None },
            _ => return None,
        };
        (part.size <= WIDEST && part.count <= LONGEST).then_some(part)
    }
}

/// The same steps with runs instead of the numbers.
pub(crate) fn joined(steps: Vec<Step>) -> Vec<Step> {
    let mut joined = Vec::with_capacity(steps.len());
    for step in steps {
        let Some(part) = Part::of(&step) else {
            joined.push(step);
            continue;
        };
        match joined.last_mut() {
            Some(Step::Run(run)) if part.size <= run.align => run.push(&part),
            _ => {
                let mut run = Run { align: part.size, aligned: Extent::default(), packed: Extent::default() };
                run.push(&part);
                joined.push(Step::Run(run));
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

    /// Sets the values that have a role.
    #[inline]
    pub(crate) fn read<'a>(&self, layout: &mut impl Layout<'a>, values: &mut Values<'a>) -> Option<()> {
        let (bytes, placed) = layout.run(self)?;
        for &Placed { at, len, role, signed } in placed {
            let bytes = bytes.get(at..at + len)?;
            if role == Role::Data {
                values.data = Cow::Borrowed(bytes);
                continue;
            }
            let number = layout.placed(bytes);
            values.set(role, if signed { sign_extended(number, len) } else { number as i64 });
        }
        Some(())
    }
}

impl Extent {
    fn push(&mut self, part: &Part) {
        let len = part.size * part.count;
        if let Some(role) = part.role {
            self.values.push(Placed { at: self.len, len, role, signed: part.signed });
        }
        self.len += len;
    }
}
