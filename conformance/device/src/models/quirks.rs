//! Documented differences of a model's behaviour from the standards: the table `[quirks]` of a sheet. A key that is
//! left out is off.

use super::sheet::addresses;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_analyzer::wire::sdo::AbortCode;
use serde::Deserialize;
use serde::de::IgnoredAny as ForPeople;

/// The quirks of a model. Each is implemented in the file of its service.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Quirks {
    /// Reading 1001h clears the newest entry of 1003h. When the last entry is cleared, also by writing 0 to 1003h:00 or
    /// by a reset, the error register becomes 0 and the device sends EMCY 0000h. The device counts more errors than
    /// 1003h shows.
    pub error_register_read_clears: bool,
    /// An empty entry of 1003h reads as 0; the device does not refuse to read it.
    pub empty_error_history_reads_zero: bool,
    /// The bits that 1001h supports. An error whose bits are all unsupported sets all supported bits. `None`: all eight
    /// bits are supported.
    pub error_register_bits: Option<u8>,
    /// The EMCY code of life guarding; `None`: 8130h.
    pub life_guarding_error: Option<u16>,
    /// The error of life guarding stays until a reset, even if the master guards again. The reset also clears the error
    /// history.
    pub life_guarding_until_reset: bool,
    /// While the device writes its non-volatile memory, it neither receives nor sends.
    pub silent_while_storing: bool,
    /// Values written to these objects read back at once, but take effect only when 1010h stores them.
    #[serde(deserialize_with = "addresses")]
    pub acts_when_stored: Vec<Multiplexer>,
    /// The limits of the objects in `acts_when_stored` are checked only by 1010h. A value outside its limits sets alarm
    /// bit 13 of 6503h, and 1010h is refused with abort 0600 0006h.
    pub limits_checked_at_store: bool,
    /// 6001h and 6002h can be written only while bit 2 of 6000h is set; clearing bit 2 resets them to their defaults.
    pub scaling_bit_guards: bool,
    /// While scaling is on, 6501h and 6502h show 6001h and the revolutions of 6002h.
    pub resolution_follows_scaling: bool,
    /// 2104h and 2105h are limit switches: bits 12 and 13 of 6000h enable them, these bits of 6500h show their states.
    pub limit_switches: bool,
    /// 6200h is the only event of TPDO 1, whose communication parameters have no event timer.
    pub cyclic_tpdo: bool,
    /// Strings come in segments, however short they are.
    pub strings_in_segments: bool,
    /// Reset node sets the parameters of the profile area to their defaults, not to their stored values.
    pub reset_node_restores_profile: bool,
    /// Reset communication loads all stored parameters, as reset node does.
    pub reset_communication_loads_all: bool,
    /// A SYNC with data is ignored.
    pub sync_without_data: bool,
    /// From reset node until power-off, node-ID and bit rate take effect even if they are not stored.
    pub bus_objects_survive_reset: bool,
    /// Defaults that 1011h has restored are lost at power-off unless 1010h stores them.
    pub restore_needs_store: bool,
    /// Pairs `[standard, device]`: the abort code of the device in place of a code of CiA 301.
    pub abort_codes: Vec<(u32, u32)>,
    /// For people: the values of this table that the manual does not give.
    pub assumed: ForPeople,
}

impl Quirks {
    /// Whether the limits of the object are checked only when it is stored.
    pub(crate) fn is_checked_later(&self, at: Multiplexer) -> bool {
        self.limits_checked_at_store && self.acts_when_stored.contains(&at)
    }

    /// The abort code of the device for the reason of the standard code `standard`.
    pub fn abort_code(&self, standard: AbortCode) -> AbortCode {
        let own = self.abort_codes.iter().find(|(from, _)| *from == standard.0);
        own.map_or(standard, |&(_, code)| AbortCode(code))
    }

    /// The EMCY code for the loss of the guarding master.
    pub(crate) fn life_guarding_code(&self) -> EmcyCode {
        self.life_guarding_error.map_or(EmcyCode::HEARTBEAT, EmcyCode)
    }
}
