//! A violation: the broken rule, what shows it on the bus, and the state in which the models believed the device to be.

use super::nmt::Phase;
use crate::coverage::{LssState, SdoState};
use crate::property::Property;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::{Duration, Frame, Timestamp};
use std::fmt::{self, Write};

/// A violation of a property.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Violation {
    /// The violated property.
    pub property: Property,
    /// The violated rule, or the state of the device.
    pub rule: &'static str,
    /// The required behaviour.
    pub expected: Box<str>,
    /// The actual behaviour.
    pub actual: Box<str>,
    /// The abort code, if only the code of the abort is wrong.
    pub abort: Option<AbortCode>,
    /// The allowed time between two frames with the CAN-ID of the symptom, if this time is wrong.
    pub interval: Option<Box<(Duration, Duration)>>,
    /// Whether the device was silent although an answer was due.
    pub is_silence: bool,
    /// What shows the violation on the bus.
    pub symptom: Symptom,
    /// The state of the device according to the models.
    pub state: DeviceState,
    /// The time of the violation.
    pub at: Timestamp,
}

/// What shows a violation on the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Symptom {
    /// The device sent this frame.
    Frame(Frame),
    /// The device did not send a frame with this CAN-ID in time. `None`: the CAN-ID is not known.
    Missing(Option<u16>),
    /// The device has stopped working.
    Dead,
}

/// The cause of a violation: violations with the same defect are one finding.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Defect {
    /// The violated property.
    pub property: Property,
    /// The violated rule: the situation in which the answer is wrong.
    pub rule: &'static str,
    /// What is wrong with the answer.
    pub answer: WrongAnswer,
}

/// The stable id, such as `prop-02-initiate-upload-abort-06020000`: property, rule, and what is wrong with the answer.
impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-", self.property.id().to_lowercase())?;
        for letter in self.rule.chars() {
            f.write_char(if letter.is_ascii_alphanumeric() { letter.to_ascii_lowercase() } else { '-' })?;
        }
        match self.answer {
            WrongAnswer::Missing => f.write_str("-no-answer"),
            WrongAnswer::Code(code) => write!(f, "-abort-{:08x}", code.0),
            WrongAnswer::Other => Ok(()),
        }
    }
}

/// What is wrong with an answer.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum WrongAnswer {
    /// There is none.
    Missing,
    /// It is an abort with this code.
    Code(AbortCode),
    /// It is any other wrong answer.
    Other,
}

impl Violation {
    /// The cause of the violation.
    pub fn defect(&self) -> Defect {
        let answer = match (self.symptom, self.abort) {
            (Symptom::Missing(_) | Symptom::Dead, _) => WrongAnswer::Missing,
            (Symptom::Frame(_), Some(code)) => WrongAnswer::Code(code),
            (Symptom::Frame(_), None) => WrongAnswer::Other,
        };
        Defect { property: self.property, rule: self.rule, answer }
    }

    /// The violation as the frame of a device in this state shows it.
    pub(super) fn by(self, frame: &Frame, state: DeviceState) -> Self {
        Self { symptom: Symptom::Frame(*frame), state, ..self }
    }

    /// The violation as the absence of a frame with this CAN-ID shows it, of a device in this state.
    pub(super) fn by_absence(self, can_id: u16, state: DeviceState) -> Self {
        let symptom = match self.symptom {
            Symptom::Missing(None) => Symptom::Missing(Some(can_id)),
            known => known,
        };
        Self { symptom, state, ..self }
    }
}

/// The state of a device according to the models.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct DeviceState {
    pub(super) phase: Option<Phase>,
    pub(super) sdo: Option<SdoState>,
    pub(super) lss: Option<LssState>,
}

impl fmt::Display for DeviceState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.phase.map_or("not known", Phase::name))?;
        if let Some(sdo) = self.sdo {
            write!(f, "; SDO server: {}", sdo.name())?;
        }
        match self.lss {
            None | Some(LssState::Waiting) => Ok(()),
            Some(lss) => write!(f, "; LSS: {}", lss.name()),
        }
    }
}
