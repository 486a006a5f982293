//! Checks of written values in addition to the limits in the encoder's description.

use super::operating::SCALING;
use super::{Encoder, OPERATING_PARAMETERS};
use crate::device::Parameters;
use crate::models::Rule;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::objects as encoder;
use canvass_analyzer::wire::sdo::AbortCode;

impl Encoder {
    /// Checks a value by the encoder's rules. The abort code of a refusal is the code in the model's manual.
    pub(super) fn check_written(&self, at: Multiplexer, value: u64, parameters: &Parameters) -> Result<(), AbortCode> {
        let sheet = self.model.sheet();
        let own = |rule| sheet.abort(rule, at);
        let scales = matches!(at.index.0, encoder::UNITS_PER_REVOLUTION | encoder::TOTAL_MEASURING_RANGE);
        match at.index.0 {
            encoder::PRESET_VALUE => self.check_preset(value, parameters).map_err(|_| own(Rule::InsideActiveRange)),
            0x6000.. if sheet.quirks.is_checked_later(at) => self.check_scaling_bit(parameters),
            _ if scales && sheet.quirks.scaling_bit_guards => self.check_scaling_bit(parameters),
            _ if scales => self.check_operating(at, value, parameters).map_err(|_| own(Rule::UnitsAtMostRange)),
            encoder::OPERATING_PARAMETERS => self.check_operating(at, value, parameters),
            encoder::HIGH_PRECISION_PRESET => self.check_preset(value, parameters),
            _ => Ok(()),
        }
    }

    /// Refuses a change of the scaling while the scaling bit is clear, if that bit guards the scaling on this model.
    fn check_scaling_bit(&self, parameters: &Parameters) -> Result<(), AbortCode> {
        let guarded = self.model.sheet().quirks.scaling_bit_guards;
        let is_on = parameters.number_or_zero(OPERATING_PARAMETERS.index.0, 0) & SCALING != 0;
        if is_on || !guarded { Ok(()) } else { Err(AbortCode::UNSUPPORTED_ACCESS) }
    }
}
