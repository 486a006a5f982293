//! The LMT slave: sets node-ID and bit rate over the bus. LMT is the predecessor of LSS (CiA DS-205).
//!
//! ```text
//! operation --04h mode 1, or 01h 02h 03h with the own address--> configuration --04h mode 0--> operation
//! ```
//!
//! The slave answers only inquiries, configurations and "identify". 17h stores the configuration, which takes
//! effect after power-off; only 15h activates a new bit rate earlier.

use super::bit_rate::bit_rate;
use super::context::Context;
use super::layer_setting::{LayerSetting, is_within};
use super::nmt::Order;
use super::routes::{Route, Routes};
use super::service::Service;
use super::store::StoredNetwork;
use crate::models::{LmtAddress, Model};
use crate::{Fault, Firmware};
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::layer_setting::Dialect;
use canvass_analyzer::wire::lmt::{self, Bound, ConfigureCommand, Lmt, Part, Request, Response, Seven};
use canvass_traces::{Duration, Frame, Timestamp};

/// The error code for a value outside its range. The standard leaves the codes to the manufacturer.
const OUT_OF_RANGE: u8 = 3;

/// The error code that announces a manufacturer-specific code.
const SPECIFIC: u8 = 255;

/// The state of the LMT slave.
#[derive(Clone, Debug)]
pub(super) struct LmtSlave {
    at: LayerSetting,
    pending: Pending,
}

/// A configuration that is not yet stored.
#[derive(Clone, Copy, Debug, Default)]
struct Pending {
    node_id: Option<NodeId>,
    /// The bit rate: the index in table 0 of CiA DS-205.
    bit_timing: Option<u8>,
}

/// The effect of an LMT message on the device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Effect {
    Store,
    /// Change the bit rate; the device is silent for this time before and after.
    Activate(Duration),
    /// Use the node-ID without power-off, in a faulty firmware.
    TakeNodeId(NodeId),
}

impl LmtSlave {
    /// The state operation, without pending values.
    pub const fn new() -> Self {
        Self { at: LayerSetting::new(), pending: Pending { node_id: None, bit_timing: None } }
    }

    fn on_request(
        &mut self,
        request: Request,
        address: &LmtAddress,
        model: &Model,
        firmware: &Firmware,
    ) -> (Option<Response>, Option<Effect>) {
        let configuring = self.at.configuring || firmware.has(Fault::LmtAnsweredInOperation);
        match request {
            Request::SwitchGlobal { mode } => {
                self.at.switch(mode, firmware.has(Fault::LmtReservedModeObeyed).then_some(true));
                (None, None)
            }
            Request::SwitchSelective { part, value } => {
                (self.on_switch_selective(part, value, address, firmware), None)
            }
            Request::IdentifyRemote { bound, value } => (self.on_identify(bound, value, address, firmware), None),
            request if configuring => self.on_configuration(request, address, model, firmware),
            _ => (None, None),
        }
    }

    /// Handles a part of "switch mode selective": the three parts must come in order; the last part switches, without
    /// an answer.
    fn on_switch_selective(
        &mut self,
        part: Part,
        value: Seven,
        address: &LmtAddress,
        firmware: &Firmware,
    ) -> Option<Response> {
        if self.at.configuring {
            return None;
        }
        let unchecked = match part {
            Part::SerialNumber => firmware.has(Fault::LmtSerialNotCompared),
            Part::ManufacturerName | Part::ProductName => firmware.has(Fault::LmtNamesNotCompared),
        };
        let fits = unchecked || own(part, address, firmware) == value;
        self.at.configuring = self.at.selected.takes(part, fits);
        // This faulty firmware answers as an LSS slave does.
        (self.at.configuring && firmware.has(Fault::LmtSwitchSelectiveAnswered)).then_some(Response::Switched)
    }

    /// Handles a part of "identify remote slave": the names must be equal, and the serial number within its bounds.
    fn on_identify(
        &mut self,
        bound: Bound,
        value: Seven,
        address: &LmtAddress,
        firmware: &Firmware,
    ) -> Option<Response> {
        let (part, limit) = Lmt::limits(bound);
        let any_serial = part == Part::SerialNumber && firmware.has(Fault::LmtIdentifyRangeIgnored);
        let fits = any_serial || is_within::<Lmt>(limit, value, own(part, address, firmware));
        let identified = self.at.identified.takes(bound, fits);
        (identified && !firmware.has(Fault::LmtIdentifySilent)).then_some(Response::Identified)
    }

    fn on_configuration(
        &mut self,
        request: Request,
        address: &LmtAddress,
        model: &Model,
        firmware: &Firmware,
    ) -> (Option<Response>, Option<Effect>) {
        match request {
            Request::ConfigureNodeId { node_id } => self.on_node_id(node_id, firmware),
            Request::ConfigureBitTiming { table, index } => {
                let known = row(index, firmware).filter(|&row| table == 0 && bit_rate(model, row).is_some());
                let ok = known.is_some() || firmware.has(Fault::LmtBitTimingUnchecked);
                self.pending.bit_timing = known.or(self.pending.bit_timing);
                let error = u8::from(!ok);
                (Some(Response::Configured { command: ConfigureCommand::BitTiming, error, specific: 0 }), None)
            }
            Request::ActivateBitTiming { delay } => {
                (None, Some(Effect::Activate(Duration::from_millis(u64::from(delay)))))
            }
            Request::StoreConfiguration => {
                let done = Response::Configured { command: ConfigureCommand::Store, error: 0, specific: 0 };
                ((!firmware.has(Fault::LmtStoreSilent)).then_some(done), Some(Effect::Store))
            }
            Request::Inquire { part } => (Some(Response::Part { part, value: own(part, address, firmware) }), None),
            _ => (None, None),
        }
    }

    fn on_node_id(&mut self, node_id: u8, firmware: &Firmware) -> (Option<Response>, Option<Effect>) {
        let new = NodeId::new(node_id);
        self.pending.node_id = new.or(self.pending.node_id);
        let ok = new.is_some() || firmware.has(Fault::LmtNodeIdUnchecked);
        let (error, specific) = if ok { (0, 0) } else { (SPECIFIC, OUT_OF_RANGE) };
        let effect = new.filter(|_| firmware.has(Fault::LmtNodeIdAtOnce)).map(Effect::TakeNodeId);
        (Some(Response::Configured { command: ConfigureCommand::NodeId, error, specific }), effect)
    }
}

/// A part of the slave's address as this firmware has it.
fn own(part: Part, address: &LmtAddress, firmware: &Firmware) -> Seven {
    let name = |name: Seven| match firmware.has(Fault::LmtNameUnpadded) {
        true => Seven(name.0.map(|byte| if byte == 0 { 0xFF } else { byte })),
        false => name,
    };
    match part {
        Part::ManufacturerName => name(address.manufacturer_name),
        Part::ProductName => name(address.product_name),
        Part::SerialNumber if firmware.has(Fault::LmtSerialNotBcd) => binary(address.serial_number),
        Part::SerialNumber => address.serial_number,
    }
}

/// The row of the table of bit rates that this firmware takes; `None` for a reserved row.
fn row(index: u8, firmware: &Firmware) -> Option<u8> {
    // The table of LSS: row 5 is reserved, and the following rows are shifted by one.
    match index {
        5 if firmware.has(Fault::LmtBitTimingUnshifted) => None,
        6.. if firmware.has(Fault::LmtBitTimingUnshifted) => Some(index - 1),
        index => Some(index),
    }
}

/// Converts BCD digits to a binary number, little-endian.
fn binary(digits: Seven) -> Seven {
    let number =
        digits.0.iter().fold(0_u64, |number, byte| number * 100 + u64::from(byte >> 4) * 10 + u64::from(byte & 0xF));
    let [a, b, c, d, e, f, g, _] = number.to_le_bytes();
    Seven([a, b, c, d, e, f, g])
}

impl LmtSlave {
    fn store(&self, context: &mut Context) {
        let at = context.objects.model.sheet().network.node_id_object;
        if let (Some(at), Some(node)) = (at, self.pending.node_id) {
            context.store.save_number(at, u64::from(node.raw()), &context.objects.parameters);
        }
        let before = context.store.network();
        let bit_timing = self.pending.bit_timing.or(before.bit_timing);
        context.store.save_network(StoredNetwork { bit_timing, ..before });
    }
}

impl Service for LmtSlave {
    fn handle(&mut self, _: Timestamp, _: Route, frame: &Frame, context: &mut Context) {
        let Ok(request) = lmt::Request::read(frame.data()) else { return };
        let sheet = context.objects.model.sheet();
        let Some(address) = sheet.lmt else { return };
        if !context.phase.is_running() || frame.len() != 8 {
            return;
        }
        let (response, effect) = self.on_request(request, &address, &context.objects.model, context.firmware());
        if let Some(response) = response {
            let frame = response.to_frame(lmt::SLAVE_CAN_ID);
            let short = frame.data().get(..7).filter(|_| context.has(Fault::LmtShortResponse));
            context.send(short.and_then(|bytes| Frame::new(frame.id(), bytes)).unwrap_or(frame));
        }
        match effect {
            Some(Effect::Store) => self.store(context),
            Some(Effect::Activate(delay)) => {
                let delay = if context.has(Fault::LmtActivationNotSilent) { Duration::ZERO } else { delay };
                let is_used = !context.has(Fault::LmtBitTimingWithoutEffect);
                let bit_timing = self.pending.bit_timing.filter(|_| is_used);
                context.order(Order::ActivateBitRate { bit_timing, delay });
            }
            Some(Effect::TakeNodeId(node)) if context.node != Some(node) => context.order(Order::MoveTo(node)),
            Some(Effect::TakeNodeId(_)) | None => {}
        }
    }

    fn find_routes(&self, context: &Context, routes: &mut Routes) {
        if context.objects.model.sheet().lmt.is_some() {
            routes.set(lmt::MASTER_CAN_ID, Route::Lmt);
        }
    }
}
