//! The services of a device and its access by the network: the table `[network]` of a sheet.

use super::sheet::address_option;
use canvass_analyzer::Multiplexer;
use serde::Deserialize;
use serde::de::IgnoredAny as ForPeople;

/// The services of a device and its access by the network.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Network {
    /// The node-ID as delivered; `None` if LSS must set it first.
    pub default_node_id: Option<u8>,
    /// The bit rate as delivered, in kbit/s.
    pub default_bit_rate_kbit: u32,
    /// The object that holds the node-ID to use.
    #[serde(default, deserialize_with = "address_option")]
    pub node_id_object: Option<Multiplexer>,
    /// The object that holds the code of the bit rate to use.
    #[serde(default, deserialize_with = "address_option")]
    pub bit_rate_object: Option<Multiplexer>,
    /// Whether the device has an LMT slave. LMT is the predecessor of LSS.
    #[serde(default)]
    pub lmt: bool,
    /// The events at which the device begins to use a new node-ID.
    #[serde(default = "power_on_and_reset_node")]
    pub takes_effect: Vec<Trigger>,
    /// Whether the device has an LSS slave.
    #[serde(default)]
    pub lss: bool,
    /// The NMT states in which LSS works; empty: all states.
    #[serde(default)]
    pub lss_states: Vec<String>,
    /// Whether an entry of 1016h takes effect only after it is stored: at the next boot-up, or when written again.
    #[serde(default)]
    pub heartbeat_consumer_needs_store: bool,
    /// Whether the device answers node guarding.
    #[serde(default)]
    pub node_guarding: bool,
    /// Whether the device sends a boot-up message.
    #[serde(default = "yes")]
    pub boot_up_message: bool,
    /// Whether the device answers remote frames for its TPDOs.
    #[serde(default)]
    pub rtr: bool,
    /// The transmission types that TPDOs accept, as ranges.
    #[serde(default = "all_transmission_types")]
    pub transmission_types: Vec<(u8, u8)>,
    /// The transmission types with which a TPDO is sent when a mapped value changes.
    #[serde(default = "event_of_manufacturer")]
    pub sent_on_change: Vec<u8>,
    /// The transmission types that RPDOs accept, as ranges.
    #[serde(default = "all_rpdo_transmission_types")]
    pub rpdo_transmission_types: Vec<(u8, u8)>,
    /// Whether the SDO server supports block transfers.
    #[serde(default)]
    pub sdo_block_transfer: bool,
    /// The abort code for a value whose length differs from the object's; `None`: the codes for "too long" and "too
    /// short".
    pub sdo_length_abort: Option<u32>,
    /// The TPDOs, from 1, whose frames are filled up with zeros to 8 bytes.
    #[serde(default)]
    pub padded_tpdos: Vec<u8>,
    /// Whether the device can produce SYNC (1005h bit 30).
    #[serde(default)]
    pub sync_producer: bool,
    /// The shortest communication cycle period (1006h), in microseconds.
    #[serde(default = "shortest_sync_period")]
    pub sync_period_least_us: u32,
    /// Whether the device can consume TIME (1012h bit 31); 1013h then follows TIME.
    #[serde(default)]
    pub time_consumer: bool,
    /// The period of TIME while 1012h bit 30 is set; `None` if the device can't produce TIME.
    pub time_period_ms: Option<u64>,
    /// The object of type TIME_OF_DAY that shows the device's clock.
    #[serde(default, deserialize_with = "address_option")]
    pub clock_object: Option<Multiplexer>,
    /// The object of 64 bits that shows the last EMCY received from a node of 1028h.
    #[serde(default, deserialize_with = "address_option")]
    pub received_emcy_object: Option<Multiplexer>,
    /// The value of 1F80h at which the device enters operational by itself.
    #[serde(default)]
    pub start_up: StartUp,
    /// The error code of LSS "store configuration": 0 success, 1 not supported, 2 no access to the storage medium.
    #[serde(default)]
    pub lss_store_error: u8,
    /// Whether a new node-ID makes the device restart as soon as LSS is back in the state waiting. Otherwise the device
    /// waits for reset communication (CiA 305).
    #[serde(default = "yes")]
    pub lss_restarts: bool,
    /// For people: the values of this table that the manual does not give.
    #[serde(default)]
    pub assumed: ForPeople,
    /// For people: the number of nodes that 1016h can monitor.
    #[serde(default)]
    pub heartbeat_consumers: ForPeople,
    /// For people: whether the device sends heartbeats.
    #[serde(default)]
    pub heartbeat_producer: ForPeople,
    /// For people: the number of RPDOs.
    #[serde(default)]
    pub rpdos: ForPeople,
    /// For people: the number of TPDOs.
    #[serde(default)]
    pub tpdos: ForPeople,
}

/// The bits of 1F80h that make a device enter operational by itself.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartUp {
    /// The bits of 1F80h that matter.
    pub mask: u32,
    /// The values of these bits at which the device enters operational by itself.
    pub value: u32,
}

impl Default for StartUp {
    /// Bit 2 is 0, as in CiA 302-2.
    fn default() -> Self {
        Self { mask: 4, value: 0 }
    }
}

/// An event at which a device begins to use its configuration.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Trigger {
    /// Power-off and on.
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

/// The transmission types of RPDOs in CiA 301, where 241 to 253 are reserved.
fn all_rpdo_transmission_types() -> Vec<(u8, u8)> {
    vec![(0, 240), (254, 255)]
}

const fn shortest_sync_period() -> u32 {
    1_000
}

fn power_on_and_reset_node() -> Vec<Trigger> {
    vec![Trigger::PowerOn, Trigger::ResetNode]
}
