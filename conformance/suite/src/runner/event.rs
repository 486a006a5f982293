//! The events of a run, from which every report is made.

use super::summary::Summary;
use crate::case::Case;
use crate::comparison::Comparison;
use crate::foreign::ForeignMessages;
use crate::trial::CaseReport;
use canvass_analyzer::{Multiplexer, NodeId};

/// An event of a run. Their order is: one [`RunEvent::RunStarted`], for each case a [`RunEvent::CaseStarted`] and a
/// [`RunEvent::CaseFinished`], a [`RunEvent::DictionaryCompared`], at most one [`RunEvent::OtherClients`], any number
/// of [`RunEvent::Noticed`], one [`RunEvent::RunFinished`].
#[derive(Debug)]
pub enum RunEvent<'a> {
    /// The device was reached; cases follow.
    RunStarted(&'a RunInfo),
    /// A case begins.
    CaseStarted {
        /// The case.
        case: &'static Case,
        /// The number of the case, from 1.
        number: usize,
        /// Number of all cases.
        of: usize,
    },
    /// A case has ended.
    CaseFinished(&'a CaseReport),
    /// The object dictionary was read again, which happens only if a case has run.
    DictionaryCompared(&'a Comparison),
    /// The foreign messages of the whole run, if there were any.
    OtherClients(&'a [ForeignMessages]),
    /// A notice about the run as a whole.
    Noticed(&'a str),
    /// All cases have ended, or the user has cancelled.
    RunFinished(&'a Summary),
}

/// The device under test, and the conditions of the run.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct RunInfo {
    /// The bus, as the user addressed it.
    pub bus: String,
    /// The bit rate in bit/s, if it is known.
    pub bit_rate: Option<u32>,
    /// The node-ID.
    pub node: NodeId,
    /// The model id or path of the description; empty if none was given.
    pub model: String,
    /// The identity that the device reports.
    pub device: DeviceIdentity,
    /// The seed of everything random in the run.
    pub seed: u64,
    /// The seed of the order of the cases; `None` if they have their usual order.
    pub shuffle: Option<u64>,
    /// Number of selected cases.
    pub cases: usize,
    /// The object dictionary before the first case, as far as the bench could read it.
    pub dictionary: Vec<(Multiplexer, Vec<u8>)>,
}

/// The identity that a device reports. The texts come from the device: they may hold anything.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct DeviceIdentity {
    /// 1000h, the device type.
    pub device_type: Option<u32>,
    /// 1018h:01 to 04: vendor-ID, product code, revision number, serial number.
    pub identity: [Option<u32>; 4],
    /// 1008h, 1009h, 100Ah: name, hardware version, software version.
    pub names: [Option<String>; 3],
}
