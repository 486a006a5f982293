//! The LSS slave: sets node-ID and bit rate over the bus (CiA 305).

use super::bit_rate::bit_rate;
use super::context::Context;
use super::layer_setting::{LayerSetting, is_within};
use super::nmt::{Order, Phase};
use super::objects::Objects;
use super::parameters::Parameters;
use super::routes::{Route, Routes};
use super::service::{Event, Service};
use super::store::StoredNetwork;
use crate::models::Model;
use crate::{Fault, Firmware, Liberty};
use canvass_analyzer::NodeId;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::layer_setting::{Dialect, Limit};
use canvass_analyzer::wire::lss::{self, Bound, ConfigureCommand, Lss, Part, Request, Response};
use canvass_traces::{Duration, Frame, Timestamp};

/// The node-ID that means "not configured".
pub(super) const UNCONFIGURED: u8 = 255;

/// The LSS address: 1018h:01 to 1018h:04.
pub(super) type Address = [u32; 4];

/// The state of the LSS slave.
#[derive(Clone, Debug)]
pub(super) struct LssSlave {
    at: LayerSetting,
    /// The part of the LSS address that Fastscan compares next.
    scanning: u8,
    /// The configured values that are not yet in effect.
    pub pending: Pending,
    /// An answer that waits for its time.
    later: Option<(Timestamp, Frame)>,
}

/// Duration of a store in a slow non-volatile memory.
const SLOW_STORE: Duration = Duration::from_millis(2_000);

/// A new configuration.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Pending {
    /// The node-ID: 1 to 127 or [`UNCONFIGURED`].
    pub node_id: Option<u8>,
    /// The bit rate: the index in table 0 of CiA 305.
    pub bit_timing: Option<u8>,
}

/// The effect of an LSS message on the device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Effect {
    /// Store the pending values.
    Store,
    /// The master has ended configuration: a restart applies the new node-ID.
    Leave,
    /// Change to the new bit rate; the device is silent for this time before and after.
    Activate(Duration),
    /// Hang, in a faulty firmware.
    Hang,
}

impl LssSlave {
    /// The state waiting, without pending values.
    pub const fn new() -> Self {
        Self { at: LayerSetting::new(), scanning: 0, pending: Pending { node_id: None, bit_timing: None }, later: None }
    }

    /// Handles a message of the master. `node` is the current node-ID, or [`UNCONFIGURED`].
    fn on_request(
        &mut self,
        request: Request,
        address: Address,
        node: u8,
        model: &Model,
        firmware: &Firmware,
    ) -> (Option<Response>, Option<Effect>) {
        let response = match request {
            Request::SwitchGlobal { mode } => return (None, self.on_switch_global(mode, firmware)),
            Request::SwitchSelective { part, value } => self.on_switch_selective(part, value, address, firmware),
            Request::IdentifyRemote { bound, value } => self.on_identify(bound, value, address, firmware),
            Request::IdentifyNonConfigured => {
                let answers = node == UNCONFIGURED || firmware.has(Fault::LssNonConfiguredAnswered);
                answers.then_some(Response::NonConfigured)
            }
            Request::Fastscan { .. } if firmware.takes(Liberty::NoFastscan) => None,
            Request::Fastscan { sub, next, .. } if (sub > 3 || next > 3) && firmware.has(Fault::FastscanHangs) => {
                return (None, Some(Effect::Hang));
            }
            Request::Fastscan { id, bit_check, sub, next } => {
                let has_part = node == UNCONFIGURED || firmware.has(Fault::FastscanAnsweredWhenConfigured);
                let takes_part = has_part && !self.at.configuring;
                if takes_part { self.on_fastscan(id, bit_check, sub, next, address, firmware) } else { None }
            }
            Request::ActivateBitTiming { delay } if self.at.configuring => {
                return (None, Some(Effect::Activate(Duration::from_millis(delay.into()))));
            }
            Request::StoreConfiguration if self.at.configuring => {
                let error = model.sheet().network.lss_store_error;
                let specific = u8::from(firmware.has(Fault::LssStoreSpecificError));
                let done = Response::Configured { command: ConfigureCommand::Store, error, specific };
                return (Some(done), (error == 0).then_some(Effect::Store));
            }
            request if self.at.configuring || firmware.has(Fault::LssAnsweredWhileWaiting) => {
                self.on_configuration(request, address, node, model, firmware)
            }
            _ => None,
        };
        (response, None)
    }

    fn on_switch_global(&mut self, mode: u8, firmware: &Firmware) -> Option<Effect> {
        let was_configuring = self.at.configuring;
        let obeyed = self.at.switch(mode, firmware.has(Fault::LssReservedModeWaits).then_some(false));
        let leaves = !self.at.configuring || firmware.has(Fault::LssLeavesWhenToldAgain);
        (obeyed && was_configuring && leaves).then_some(Effect::Leave)
    }

    /// Handles a part of "switch state selective": the four parts must come in order; the last part switches.
    fn on_switch_selective(
        &mut self,
        part: Part,
        value: u32,
        address: Address,
        firmware: &Firmware,
    ) -> Option<Response> {
        if self.at.configuring {
            return None;
        }
        let unchecked = part == Part::SerialNumber && firmware.has(Fault::LssSelectiveThreeParts);
        let fits = address[part as usize] == value || unchecked;
        self.at.configuring = match firmware.has(Fault::LssSelectiveAnyOrder) {
            true => self.at.selected.counts::<Part>(fits),
            false => self.at.selected.takes(part, fits),
        };
        self.at.configuring.then_some(Response::Switched)
    }

    /// Handles a bound of "identify remote slave": vendor-ID and product code must be equal, revision and serial number
    /// within their bounds.
    fn on_identify(&mut self, bound: Bound, value: u32, address: Address, firmware: &Firmware) -> Option<Response> {
        let (part, limit) = Lss::limits(bound);
        let own = address[part as usize];
        let excluded = firmware.has(Fault::LssIdentifyRangeExclusive) && limit == Limit::Highest && value == own;
        let fits = is_within::<Lss>(limit, value, own) && !excluded;
        self.at.identified.takes(bound, fits).then_some(Response::Identified)
    }

    fn on_fastscan(
        &mut self,
        id: u32,
        bit_check: u8,
        sub: u8,
        next: u8,
        address: Address,
        firmware: &Firmware,
    ) -> Option<Response> {
        if bit_check == 0x80 {
            self.scanning = 0;
            return Some(Response::Identified);
        }
        if bit_check > 31 || sub > 3 || next > 3 || sub != self.scanning {
            return None;
        }
        let own = *address.get(usize::from(sub))?;
        if (own ^ id) >> bit_check != 0 {
            return None;
        }
        if bit_check == 0 {
            // Only the last part ends the scan, if the master names an earlier part as the next part.
            self.at.configuring = (sub == 3 || firmware.has(Fault::FastscanEarlyMatch)) && next < sub;
            self.scanning = next;
        }
        Some(Response::Identified)
    }

    fn on_configuration(
        &mut self,
        request: Request,
        address: Address,
        node: u8,
        model: &Model,
        firmware: &Firmware,
    ) -> Option<Response> {
        let configured = |command, ok: bool| Response::Configured { command, error: u8::from(!ok), specific: 0 };
        Some(match request {
            Request::ConfigureNodeId { node_id } => {
                let ok = matches!(node_id, 1..=127 | UNCONFIGURED) || firmware.has(Fault::LssNodeIdUnchecked);
                if ok && matches!(node_id, 1..=127 | UNCONFIGURED) {
                    let mistaken = node_id != UNCONFIGURED && firmware.has(Fault::LssNodeIdMistaken);
                    self.pending.node_id = Some(if mistaken { node_id % 127 + 1 } else { node_id });
                }
                configured(ConfigureCommand::NodeId, ok)
            }
            Request::ConfigureBitTiming { table, index } => {
                let known = model.sheet().bit_rates.iter().any(|rate| rate.lss_code == Some(index));
                let ok = table == 0 && known;
                if ok {
                    self.pending.bit_timing = Some(index);
                } else if firmware.has(Fault::LssBitTimingWrongCode) {
                    let command = ConfigureCommand::BitTiming;
                    return Some(Response::Configured { command, error: 255, specific: 1 });
                }
                configured(ConfigureCommand::BitTiming, ok || firmware.has(Fault::LssBitTimingUnchecked))
            }
            Request::Inquire { .. } | Request::InquireNodeId if firmware.takes(Liberty::NoLssInquiry) => return None,
            Request::Inquire { part } => Response::Part { part, value: address[part as usize] },
            Request::InquireNodeId => Response::NodeId(node),
            _ => return None,
        })
    }
}

impl LssSlave {
    fn store(&self, context: &mut Context) {
        if context.has(Fault::LssStoreNotPersistent) {
            return;
        }
        let Objects { model, parameters, .. } = &context.objects;
        let network = &model.sheet().network;
        let rate = self.pending.bit_timing.and_then(|code| bit_rate(model, code)).and_then(|rate| rate.object_code);
        let node_id = self.pending.node_id.map(u64::from);
        let stored = [(network.node_id_object, node_id), (network.bit_rate_object, rate.map(u64::from))];
        for (at, number) in stored {
            if let (Some(at), Some(number)) = (at, number) {
                context.store.save_number(at, number, parameters);
            }
        }
        let before = context.store.network();
        context.store.save_network(StoredNetwork {
            node_id: self.pending.node_id.or(before.node_id),
            bit_timing: self.pending.bit_timing.or(before.bit_timing),
        });
    }

    /// Handles the end of configuration. A restart applies new settings at once if the manual says so. A device that
    /// had no node-ID applies its node-ID; else that applies at the next reset communication (CiA 305).
    fn leave(&mut self, context: &mut Context) {
        let Pending { node_id, bit_timing } = self.pending;
        let restarts = context.objects.model.sheet().network.lss_restarts;
        let is_new = node_id.is_some() || restarts && bit_timing.is_some();
        if is_new && (restarts || context.node.is_none()) {
            *self = Self::new();
            let node = node_id.map_or(context.node, NodeId::new);
            context.order(Order::Restart { node, bit_timing: bit_timing.filter(|_| restarts) });
        }
    }

    fn take_node_id_at_once(&self, context: &mut Context) {
        let node_id = self.pending.node_id.and_then(NodeId::new);
        if context.has(Fault::LssNodeIdAtOnce) && context.node.is_some() && node_id.is_some() {
            context.node = node_id;
            context.routes_changed = true;
        }
    }
}

impl Service for LssSlave {
    fn handle(&mut self, now: Timestamp, _: Route, frame: &Frame, context: &mut Context) {
        let network = &context.objects.model.sheet().network;
        let state = context.phase.state();
        let works = network.lss_states.is_empty()
            || context.phase == Phase::Unconfigured
            || network.lss_states.iter().any(|name| state.name() == Some(name));
        let booting = matches!(context.phase, Phase::Initialising { .. });
        let Ok(request) = lss::Request::read(frame.data()) else { return };
        let is_there = network.lss || context.has(Fault::LssUndescribed);
        let fits = frame.len() == 8 || context.has(Fault::LssShortRequestAnswered);
        if !is_there || !works || booting || !fits {
            return;
        }
        let address = address(&context.objects.parameters);
        let node = context.node.map_or(UNCONFIGURED, NodeId::raw);
        let (response, effect) =
            self.on_request(request, address, node, &context.objects.model, &context.objects.firmware);
        if let Some(frame) = response.map(|response| response.to_frame(lss::SLAVE_CAN_ID)) {
            match effect == Some(Effect::Store) && context.takes(Liberty::LssStoreIn2S) {
                true => self.later = Some((now + SLOW_STORE, frame)),
                false => context.send(frame),
            }
        }
        match effect {
            Some(Effect::Store) => self.store(context),
            Some(Effect::Leave) => self.leave(context),
            Some(Effect::Activate(delay)) => {
                let is_used = !context.has(Fault::LssBitTimingWithoutEffect);
                let bit_timing = self.pending.bit_timing.filter(|_| is_used);
                context.order(Order::ActivateBitRate { bit_timing, delay });
            }
            Some(Effect::Hang) => context.order(Order::Hang),
            None => self.take_node_id_at_once(context),
        }
    }

    fn on_event(&mut self, _: Timestamp, event: Event, _: &mut Context) {
        if event == Event::Initialise {
            self.later = None;
        }
    }

    fn poll(&mut self, now: Timestamp, context: &mut Context) {
        if let Some((_, frame)) = self.later.take_if(|(due, _)| now >= *due) {
            context.send(frame);
        }
    }

    fn timeout(&self, _: &Context) -> Timestamp {
        self.later.map_or(Timestamp::MAX, |(due, _)| due)
    }

    fn find_routes(&self, _: &Context, routes: &mut Routes) {
        routes.set(lss::MASTER_CAN_ID, Route::Lss);
    }
}

/// The LSS address of the device: 1018h:01 to 1018h:04.
pub(super) fn address(parameters: &Parameters) -> Address {
    [1, 2, 3, 4].map(|sub| parameters.number_or_zero(object::IDENTITY, sub) as u32)
}
