//! What devices of a model do otherwise than the standards, as their manuals document it: the table `[quirks]` of a
//! sheet. A key that is left out is off.

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
    /// Reading 1001h clears the newest entry of 1003h. When the last one is gone, also by writing 0 to 1003h:00 or by
    /// a reset, the error register is 0 again and EMCY 0000h is sent. 1003h counts errors that it does not show.
    pub error_register_read_clears: bool,
    /// An empty entry of 1003h is read as 0 instead of being refused.
    pub empty_error_history_reads_zero: bool,
    /// The bits that 1001h has; an error that would set none of them sets all. `None`: all eight, each by its error.
    pub error_register_bits: Option<u8>,
    /// The EMCY code of life guarding; `None`: 8130h.
    pub life_guarding_error: Option<u16>,
    /// The error of life guarding stays until reset node, whatever the master does.
    pub life_guarding_until_reset: bool,
    /// While the non-volatile memory is written, the device neither hears nor sends anything.
    pub silent_while_storing: bool,
    /// Written values of these objects can be read at once, but act only when 1010h stores them.
    #[serde(deserialize_with = "addresses")]
    pub acts_when_stored: Vec<Multiplexer>,
    /// The limits of those objects are checked when they are stored: a wrong value is alarm bit 13 of 6503h, and 1010h
    /// is refused with abort 0600 0006h.
    pub limits_checked_at_store: bool,
    /// 6001h and 6002h can be written only while bit 2 of 6000h is set; clearing it sets them back to their defaults.
    pub scaling_bit_guards: bool,
    /// While scaling is on, 6501h and 6502h show 6001h and the revolutions of 6002h.
    pub resolution_follows_scaling: bool,
    /// 2104h and 2105h are limit switches: bits 12 and 13 of 6000h enable them, these bits of 6500h show their states.
    pub limit_switches: bool,
    /// 6200h is the only event of TPDO 1, whose communication parameters have no event timer.
    pub cyclic_tpdo: bool,
    /// Strings come in segments, however short they are.
    pub strings_in_segments: bool,
    /// Reset node sets the parameters of the profile area to their defaults, not to what is stored.
    pub reset_node_restores_profile: bool,
    /// Reset communication loads all stored parameters, as reset node does.
    pub reset_communication_loads_all: bool,
    /// Node-ID and bit rate act from reset node on without being stored, until power-off.
    pub bus_objects_survive_reset: bool,
    /// Defaults that 1011h has restored are lost at power-off unless 1010h stores them.
    pub restore_needs_store: bool,
    /// Abort codes by those that CiA 301 gives for the same reason: `[standard, device]`.
    pub abort_codes: Vec<(u32, u32)>,
    /// For people: which of these values the manual does not say.
    pub assumed: ForPeople,
}

impl Quirks {
    /// Whether the limits of the object are checked only when it is stored.
    pub fn is_checked_later(&self, at: Multiplexer) -> bool {
        self.limits_checked_at_store && self.acts_when_stored.contains(&at)
    }

    /// The abort code of the device for the reason of a standard one.
    pub fn abort_code(&self, standard: AbortCode) -> AbortCode {
        let own = self.abort_codes.iter().find(|(from, _)| *from == standard.0);
        own.map_or(standard, |&(_, code)| AbortCode(code))
    }

    /// The EMCY code of a master that does not guard any more.
    pub fn life_guarding_code(&self) -> EmcyCode {
        self.life_guarding_error.map_or(EmcyCode::HEARTBEAT, EmcyCode)
    }
}
