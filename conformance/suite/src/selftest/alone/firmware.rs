//! The firmwares on which cases run alone and together.

use super::Sample;
use crate::bench::Target;
use crate::dice::Dice;
use crate::selftest::node_of;
use canvass_device::models::Model;
use canvass_device::{Fault, Faults, Firmware};
use std::fmt;

/// A firmware with its model.
#[derive(Clone, Copy, Debug)]
pub struct Subject {
    /// The model.
    pub model: &'static Model,
    /// The firmware.
    pub firmware: Firmware,
}

/// Faults that keep a server busy, which earlier cases could hand on to later ones: they are in every sample.
const STICKY: [&[Fault]; 4] = [
    &[Fault::SdoOpenDownloadSurvivesReset],
    &[Fault::SdoTransferSurvivesReset, Fault::SdoBusyAfterAbandonedDownload],
    &[Fault::SdoTransferSurvivesReset, Fault::SdoFirstBlockAbortIgnored],
    &[Fault::SdoDownloadSegmentUnconfirmed, Fault::SdoOpenDownloadSurvivesReset],
];

impl Subject {
    /// Every model without fault, the faults of [`STICKY`], and drawn faults, alone and in pairs.
    pub(super) fn draw(sample: Sample) -> Vec<Self> {
        let plain = Model::all().iter().map(|model| Self { model, firmware: Firmware::PLAIN });
        let sticky = STICKY.iter().filter_map(|faults| Self::with(faults));
        let mut dice = Dice::new(sample.seed);
        let count = sample.count.unwrap_or(Fault::ALL.len());
        let single = drawn(&mut dice, count);
        let pairs = drawn(&mut dice, count).into_iter().zip(drawn(&mut dice, count));
        // Both faults must show on the model of the first.
        let pairs = pairs.filter(|(one, other)| one != other && one.model() == other.model());
        let single = single.iter().filter_map(|fault| Self::with(&[*fault]));
        let pairs: Vec<Self> = pairs.filter_map(|(one, other)| Self::with(&[one, other])).collect();
        plain.chain(sticky).chain(single).chain(pairs).collect()
    }

    fn with(faults: &[Fault]) -> Option<Self> {
        let model = Model::by_id(faults.first()?.model())?;
        Some(Self { model, firmware: faults.iter().fold(Faults::NONE, |all, fault| all.with(*fault)).into() })
    }

    pub(super) fn target(self) -> Target {
        Target::with_firmware(self.model, node_of(self.model), self.firmware)
    }
}

/// `count` different faults in a random order.
fn drawn(dice: &mut Dice, count: usize) -> Vec<Fault> {
    let mut faults: Vec<(u64, Fault)> = Fault::ALL.iter().map(|fault| (dice.next(), *fault)).collect();
    faults.sort_unstable();
    faults.into_iter().map(|(_, fault)| fault).take(count).collect()
}

/// The model and its faults, as `sim:` takes them: `reference-301+boot-up-missing`.
impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.model.id())?;
        self.firmware.faults.iter().try_for_each(|fault| write!(f, "+{fault}"))
    }
}
