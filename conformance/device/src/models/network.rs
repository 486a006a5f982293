//! How a device is reached and which services it has: the table `[network]` of a sheet.

use super::sheet::address_option;
use canvass_analyzer::Multiplexer;
use serde::Deserialize;
use serde::de::IgnoredAny as ForPeople;

/// How the device is reached and which services it has.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Network {
    /// As delivered; `None` if it has to be set by LSS first.
    pub default_node_id: Option<u8>,
    /// As delivered.
    pub default_bit_rate_kbit: u32,
    /// The object that holds the node-ID to use.
    #[serde(default, deserialize_with = "address_option")]
    pub node_id_object: Option<Multiplexer>,
    /// The object that holds the code of the bit rate to use.
    #[serde(default, deserialize_with = "address_option")]
    pub bit_rate_object: Option<Multiplexer>,
    /// Whether there is an LMT slave, the forerunner of LSS.
    #[serde(default)]
    pub lmt: bool,
    /// What takes a new node-ID over.
    #[serde(default = "power_on_and_reset_node")]
    pub takes_effect: Vec<Trigger>,
    /// Whether there is an LSS slave.
    #[serde(default)]
    pub lss: bool,
    /// The NMT states in which LSS works; empty: in all.
    #[serde(default)]
    pub lss_states: Vec<String>,
    /// Whether entries of 1016h act only once they are stored: at the next boot-up, or when written again.
    #[serde(default)]
    pub heartbeat_consumer_needs_store: bool,
    /// Whether node guarding is answered.
    #[serde(default)]
    pub node_guarding: bool,
    /// Whether a boot-up message is sent.
    #[serde(default = "yes")]
    pub boot_up_message: bool,
    /// Whether TPDOs can be asked for by remote frames.
    #[serde(default)]
    pub rtr: bool,
    /// The transmission types of TPDOs, as ranges.
    #[serde(default = "all_transmission_types")]
    pub transmission_types: Vec<(u8, u8)>,
    /// The transmission types with which a TPDO is sent when a mapped value changes.
    #[serde(default = "event_of_manufacturer")]
    pub sent_on_change: Vec<u8>,
    /// The transmission types of RPDOs, as ranges.
    #[serde(default = "all_rpdo_transmission_types")]
    pub rpdo_transmission_types: Vec<(u8, u8)>,
    /// Whether the SDO server knows block transfers.
    #[serde(default)]
    pub sdo_block_transfer: bool,
    /// The abort code for a value of another length than its object's; `None`: one for too long, one for too short.
    pub sdo_length_abort: Option<u32>,
    /// The TPDOs, from 1, whose frames are filled up with zeros to 8 bytes.
    #[serde(default)]
    pub padded_tpdos: Vec<u8>,
    /// Whether SYNC can be produced (1005h bit 30).
    #[serde(default)]
    pub sync_producer: bool,
    /// The shortest time of 1006h, in microseconds.
    #[serde(default = "shortest_sync_period")]
    pub sync_period_least_us: u32,
    /// Whether TIME can be consumed (1012h bit 31): 1013h follows it.
    #[serde(default)]
    pub time_consumer: bool,
    /// How often TIME is sent where 1012h bit 30 is set; `None`: it can't be produced.
    pub time_period_ms: Option<u64>,
    /// The object, a TIME_OF_DAY, that shows the device's clock.
    #[serde(default, deserialize_with = "address_option")]
    pub clock_object: Option<Multiplexer>,
    /// The object, of 64 bits, that shows the last EMCY received from a node of 1028h.
    #[serde(default, deserialize_with = "address_option")]
    pub received_emcy_object: Option<Multiplexer>,
    /// When 1F80h makes the device operational by itself.
    #[serde(default)]
    pub start_up: StartUp,
    /// What LSS "store configuration" answers: 0 success, 1 not supported, 2 no access to the storage medium.
    #[serde(default)]
    pub lss_store_error: u8,
    /// Whether a new node-ID makes the device restart as soon as LSS is back in waiting; else it waits for reset
    /// communication (CiA 305).
    #[serde(default = "yes")]
    pub lss_restarts: bool,
    /// For people: which of these values the manual does not say.
    #[serde(default)]
    pub assumed: ForPeople,
    /// For people: how many nodes 1016h watches.
    #[serde(default)]
    pub heartbeat_consumers: ForPeople,
    /// For people: whether there is a heartbeat.
    #[serde(default)]
    pub heartbeat_producer: ForPeople,
    /// For people: how many there are.
    #[serde(default)]
    pub rpdos: ForPeople,
    /// For people: how many there are.
    #[serde(default)]
    pub tpdos: ForPeople,
}

/// Which bits of 1F80h start the device.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartUp {
    /// The bits that count.
    pub mask: u32,
    /// Their values where the device starts by itself.
    pub value: u32,
}

impl Default for StartUp {
    /// CiA 302-2: bit 2 is 0.
    fn default() -> Self {
        Self { mask: 4, value: 0 }
    }
}

/// What makes a device take over what is configured.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Trigger {
    /// Off and on again.
    PowerOn,
    /// NMT reset node.
    ResetNode,
    /// NMT reset communication.
    ResetCommunication,
}

const fn yes() -> bool {
    true
}

fn all_transmission_types() -> Vec<(u8, u8)> {
    vec![(0, 240), (252, 255)]
}

fn event_of_manufacturer() -> Vec<u8> {
    vec![254]
}

/// CiA 301: 241 to 253 are reserved for RPDOs.
fn all_rpdo_transmission_types() -> Vec<(u8, u8)> {
    vec![(0, 240), (254, 255)]
}

const fn shortest_sync_period() -> u32 {
    1_000
}

fn power_on_and_reset_node() -> Vec<Trigger> {
    vec![Trigger::PowerOn, Trigger::ResetNode]
}
