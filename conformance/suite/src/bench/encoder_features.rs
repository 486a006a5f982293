//! What an encoder has (CiA 406, and what Kübler's encoders have beside it).

use super::Bench;
use super::objects::TPDO_FIRST_ENTRY;
use crate::case::{Need, Touch};
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_device::models::Model;
use canvass_traces::Duration;

const POSITION: Multiplexer = Multiplexer::new(0x6004, 0);
const LENGTH: Multiplexer = Multiplexer::new(0x6020, 0);
const PRESET: Multiplexer = Multiplexer::new(0x6003, 0);
const VENDOR_ID: Multiplexer = Multiplexer::new(0x1018, 1);
const KUEBLER: u32 = 0x13;

/// A shaft at rest trembles by so many units.
const TREMBLE: u32 = 4;

impl Bench<'_> {
    pub(super) fn of_encoder(&mut self, need: Need) -> Result<Result<(), String>, Stop> {
        match need {
            Need::VolatilePreset => Ok(self.volatile_preset()),
            Need::WorkArea => self.all(&[(0x6400, 1), (0x6401, 1), (0x6402, 1)]),
            Need::Alarms => self.all(&[(0x6503, 0), (0x6504, 0), (0x6505, 0), (0x6506, 0)]),
            Need::TemperatureLimit => self.of_kuebler(&[(0x2120, 2), (0x2120, 3), (0x6505, 0)]),
            Need::RawPosition => self.all(&[(0x600C, 0)]),
            Need::RawData => self.of_kuebler(&[(0x2160, 0), (0x2161, 0), (0x2162, 0)]),
            Need::Speed => self.all(&[(0x6030, 1)]),
            Need::SpeedParameters => self.all(&[(0x6030, 1), (0x6031, 4)]),
            Need::Acceleration => self.all(&[(0x6030, 1), (0x6040, 1)]),
            Need::Jerk => self.all(&[(0x6040, 1), (0x6050, 1)]),
            Need::Cams => self.all(&[(0x6300, 1), (0x6301, 1), (0x6302, 1), (0x6310, 1), (0x6320, 1)]),
            Need::HighPrecision => self.all(&[(0x6008, 0)]),
            Need::RedundantChannels => self.redundant_channels(),
            _ => self.of_kuebler(&[(0x3003, 0), (0x3004, 0), (0x3005, 0), (0x3010, 0), (0x5000, 0)]),
        }
    }

    fn all(&mut self, objects: &[(u16, u8)]) -> Result<Result<(), String>, Stop> {
        for &(index, sub) in objects {
            let at = Multiplexer::new(index, sub);
            if !self.has(at)? {
                return Ok(Err(format!("the device has no {at}")));
            }
        }
        Ok(Ok(()))
    }

    /// Objects in the manufacturer's area mean something only with the vendor-ID.
    fn of_kuebler(&mut self, objects: &[(u16, u8)]) -> Result<Result<(), String>, Stop> {
        if !self.has(VENDOR_ID)? || self.read_number(VENDOR_ID)? != KUEBLER {
            return Ok(Err("the device is not one of Kübler's".to_owned()));
        }
        self.all(objects)
    }

    fn redundant_channels(&mut self) -> Result<Result<(), String>, Stop> {
        let second = Multiplexer::new(TPDO_FIRST_ENTRY.index.0, 2);
        for entry in [TPDO_FIRST_ENTRY, second] {
            if !self.has(entry)? || self.read_number(entry)? >> 16 != u32::from(LENGTH.index.0) {
                return Ok(Err(format!("{entry} does not map 6020h")));
            }
        }
        Ok(Ok(()))
    }

    /// A device that stores a preset at once wears its memory, and keeps a position that is not its own if the run ends in
    /// the middle.
    fn volatile_preset(&self) -> Result<(), String> {
        let persists = self.keeps_presets();
        if persists && !self.options.allow.contains(&Touch::Nvm) {
            return Err(format!("the device stores a preset at once: say --allow {}", Touch::Nvm));
        }
        Ok(())
    }

    /// Whether the device stores a preset as soon as it is written, as its manual says.
    pub(crate) fn keeps_presets(&self) -> bool {
        Model::by_id(&self.target.model).is_some_and(|model| model.sheet().storage.persist_at_once.contains(&PRESET))
    }

    pub(super) fn turning_shaft(&mut self) -> Result<Result<(), String>, Stop> {
        let at = if self.has(POSITION)? { POSITION } else { LENGTH };
        if !self.has(at)? {
            return Ok(Err("the device has no position".to_owned()));
        }
        let first = self.read_number(at)?;
        self.listen(Duration::from_millis(100))?;
        let second = self.read_number(at)?;
        if first.abs_diff(second) > TREMBLE { Ok(Ok(())) } else { Ok(Err("the shaft is at rest".to_owned())) }
    }
}
