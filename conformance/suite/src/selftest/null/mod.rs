//! Devices that do nothing right, or hardly anything: a case that passes on them tests nothing.
//!
//! Every case that asks the device runs on every null device. A pass is right if the device has the tested behaviour,
//! or if the case is about a message that must not come: `passes.toml` lists each with its reason, and is reviewed. A
//! pass that is not listed is a failure, and so is a listed pass that does not occur.

mod answers;
mod machine;
mod reviewed;

pub use reviewed::BadList;

use super::{in_parallel, judge_machine, node_of, records};
use crate::bench::{Knowledge, Target};
use crate::case::Case;
use crate::verdict::{Kind, Reason};
use canvass_bus::Machine;
use canvass_device::Device;
use canvass_device::models::{Model, ModelError};
use machine::NullMachine;
use reviewed::Reviewed;

/// A device that does nothing right, or hardly anything.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum NullDevice {
    /// Never sends a frame.
    Silent,
    /// Starts, and refuses every request.
    RefusesAll,
    /// Starts and can be read; confirms every write and every command, but carries none out.
    ConfirmsAll,
    /// Returns every request unchanged.
    Echo,
    /// Answers every request with the same message.
    AlwaysSame,
    /// Answers every request with random bytes.
    Random,
    /// Right, except that it has none of the objects in its description.
    Ghost,
    /// Right, except that each object has one byte.
    OneByte,
    /// Right, with only the mandatory objects.
    MandatoryOnly,
}

impl NullDevice {
    /// All null devices.
    pub const ALL: [Self; 9] = [
        Self::Silent,
        Self::RefusesAll,
        Self::ConfirmsAll,
        Self::Echo,
        Self::AlwaysSame,
        Self::Random,
        Self::Ghost,
        Self::OneByte,
        Self::MandatoryOnly,
    ];

    /// The name of the null device in `passes.toml` and in the output.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Silent => "silent",
            Self::RefusesAll => "refuses-all",
            Self::ConfirmsAll => "confirms-all",
            Self::Echo => "echo",
            Self::AlwaysSame => "always-same",
            Self::Random => "random",
            Self::Ghost => "ghost",
            Self::OneByte => "one-byte",
            Self::MandatoryOnly => "mandatory-only",
        }
    }

    /// Whether the null device meets all requirements of the standard.
    const fn is_right(self) -> bool {
        matches!(self, Self::MandatoryOnly)
    }

    /// The model whose description the tester uses, and whose firmware does the parts that the null device leaves
    /// right.
    fn model(self) -> Result<Model, ModelError> {
        match self {
            Self::MandatoryOnly => Model::generic(self.id(), include_bytes!("mandatory-only.eds")),
            // This model has every optional service, so that every case of CiA 301 and 305 applies.
            _ => Model::by_id("reference-301").cloned().ok_or(ModelError::NodeId(0)),
        }
    }
}

/// The results of the cases on a null device.
#[derive(Clone, Debug)]
pub struct NullRow {
    /// The device.
    pub device: NullDevice,
    /// Number of cases with each verdict, in the order of [`Kind::ALL`].
    pub counts: [usize; Kind::ALL.len()],
    /// The cases that passed, each with its reason in the reviewed list.
    pub reviewed: Vec<(&'static Case, String)>,
    /// The cases that passed but are not in the list.
    pub unexplained: Vec<(&'static Case, Kind)>,
    /// The cases that failed, or could not be judged, although the device is right.
    pub alarms: Vec<(&'static Case, Kind, Reason)>,
    /// The entries of the list whose case did not pass, or does not exist.
    pub stale: Vec<String>,
}

impl NullRow {
    const fn new(device: NullDevice) -> Self {
        Self {
            device,
            counts: [0; Kind::ALL.len()],
            reviewed: Vec::new(),
            unexplained: Vec::new(),
            alarms: Vec::new(),
            stale: Vec::new(),
        }
    }

    /// Whether the passes are the reviewed ones, and no right device has failed.
    pub const fn is_good(&self) -> bool {
        self.unexplained.is_empty() && self.stale.is_empty() && self.alarms.is_empty()
    }
}

/// The reason why the null devices can't be run.
#[derive(Debug, thiserror::Error)]
pub enum NullError {
    /// A description can't be read.
    #[error("the null device {device}: {error}")]
    Model {
        /// The device.
        device: &'static str,
        /// The error in the description.
        error: ModelError,
    },
    /// The list of passes can't be read.
    #[error("passes.toml: {0}")]
    List(#[from] BadList),
}

/// Runs the cases that ask the device on every null device.
///
/// # Errors
/// [`NullError`] if the list of passes or a description can't be read.
pub fn run(cases: &[&'static Case]) -> Result<Vec<NullRow>, NullError> {
    let reviewed = Reviewed::read()?;
    let asking: Vec<&'static Case> = cases.iter().copied().filter(|case| case.asks_the_device()).collect();
    in_parallel(&NullDevice::ALL, |device| row(*device, &asking, &reviewed)).into_iter().collect()
}

fn row(device: NullDevice, cases: &[&'static Case], reviewed: &Reviewed) -> Result<NullRow, NullError> {
    let model = device.model().map_err(|error| NullError::Model { device: device.id(), error })?;
    let target = Target::of(&model, node_of(&model));
    let mut knowledge = Knowledge::default();
    let mut row = NullRow::new(device);
    for &case in cases {
        let new = |motion| -> Box<dyn Machine> {
            let base = Device::with_motion(&model, Some(target.node), canvass_device::Firmware::PLAIN, 0, &motion);
            match device {
                NullDevice::MandatoryOnly => Box::new(base),
                _ => Box::new(NullMachine::new(device, target.node, base)),
            }
        };
        let report = judge_machine(case, new, model.default_bit_rate(), &target, &mut knowledge, &mut |_| ());
        let kind = report.verdict.kind();
        // The record of an open case is no pass: it shows how the device behaves.
        let passes = is_pass(kind) && !records(case, &report.verdict);
        row.counts[kind as usize] += 1;
        if device.is_right() && matches!(kind, Kind::Fail | Kind::Inconclusive | Kind::Error) {
            row.alarms.push((case, kind, report.verdict.reason().unwrap_or_default()));
        }
        match reviewed.reason(device, case.id) {
            _ if !passes => {}
            Some(reason) => row.reviewed.push((case, reason.to_owned())),
            None => row.unexplained.push((case, kind)),
        }
    }
    let passed = |id: &str| row.reviewed.iter().any(|(case, _)| case.id == id);
    // If only some cases run, the entries of the other cases are not stale.
    let was_run = |id: &str| cases.iter().any(|case| case.id == id) || crate::catalogue::find(id).is_none();
    row.stale = reviewed.of(device).filter(|id| !passed(id) && was_run(id)).map(str::to_owned).collect();
    Ok(row)
}

/// Whether a verdict says that the device meets the requirement of the case.
const fn is_pass(kind: Kind) -> bool {
    matches!(kind, Kind::Pass | Kind::Tolerated | Kind::Deviation)
}
