//! What the masters of LSS and LMT have in common: the same CAN-IDs, and commands of the same form.

use crate::live::{ClientArg, Live, parse_span};
use crate::output::{TextOrJson, diagnostic, print};
use crate::status::{Failure, Status};
use anyhow::{Context, Result, anyhow};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::layer_setting::{
    ConfigureCommand, Dialect, MASTER_CAN_ID, Request, Response, SLAVE_CAN_ID,
};
use canvass_analyzer::wire::lss::Lss;
use canvass_bus::client::Exchange;
use canvass_device::address;
use canvass_reports::escape::Printable;
use canvass_traces::{Duration, Record, Timestamp};

/// Default timeout for an answer.
pub const PATIENCE: Duration = Duration::from_millis(1_000);
/// Timeout for "store": the slave erases and writes its memory before it answers.
const STORE_PATIENCE: Duration = Duration::from_millis(10_000);

#[derive(clap::Args)]
pub struct OnBus {
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// How long to wait for each answer, such as 100ms. Fastscan waits up to 68 times for each device, "store" waits
    /// at least 10 s
    #[arg(long, value_name = "SPAN", value_parser = parse_span)]
    timeout: Option<Duration>,
    /// How to print the result
    #[arg(long, value_enum, default_value_t)]
    format: TextOrJson,
    /// Same as --format json (former name)
    #[arg(long, hide = true)]
    json: bool,
    #[command(flatten)]
    client: ClientArg,
}

/// The actions after node-ID and bit rate were configured.
#[derive(clap::Args)]
pub struct Rest {
    /// Store both in non-volatile memory
    #[arg(long)]
    store: bool,
    /// Make all devices change to the bit rate that was set for them, with a pause of this length before and after
    /// the change, such as 100ms
    #[arg(long, value_name = "SPAN", value_parser = parse_delay)]
    activate: Option<u16>,
}

/// The configuration that the user wishes. The bit rate is a row in table 0 of LSS or LMT.
pub struct Wish {
    pub node_id: Option<u8>,
    pub bit_rate: Option<u8>,
    pub rest: Rest,
}

impl Wish {
    /// # Errors
    /// If there is nothing to do.
    pub fn expect_something(&self) -> Result<()> {
        let Self { node_id, bit_rate, rest: Rest { store, activate } } = self;
        if node_id.is_none() && bit_rate.is_none() && !store && activate.is_none() {
            return Err(anyhow!("nothing to do: use --node-id, --bit-rate, --store or --activate"));
        }
        Ok(())
    }
}

/// Parses a bit rate, and returns its row in table 0 of LSS or LMT.
pub fn parse_bit_rate<D: Dialect>(text: &str) -> Result<u8> {
    let rate = address::parse_bit_rate(text).ok();
    rate.and_then(D::bit_rate_index).with_context(|| {
        let known: Vec<_> = (0..=u8::MAX).filter_map(D::bit_rate).map(|rate| format!("{}k", rate / 1000)).collect();
        format!("expected one of {}, found \"{text}\"", known.join(", "))
    })
}

/// Parses the delay of "activate bit timing", which has 16 bits, and returns it in milliseconds.
fn parse_delay(text: &str) -> Result<u16> {
    let millis = parse_span(text)?.nanos() / 1_000_000;
    u16::try_from(millis)
        .ok()
        .filter(|millis| *millis > 0)
        .ok_or_else(|| anyhow!("expected 1ms to 65s, found \"{text}\""))
}

impl OnBus {
    /// Opens the bus and acts as master, and ends the configuration of all slaves after it.
    pub fn run(
        &self,
        patience: Duration,
        act: impl FnOnce(&mut Master<'_>) -> Result<Status, Failure>,
    ) -> Result<Status, Failure> {
        let mut live = Live::open(&self.bus, None, &[], self.client)?;
        let wanted = [(MASTER_CAN_ID, 0x7FF), (SLAVE_CAN_ID, 0x7FF)];
        live.bus.only(&wanted).map_err(Failure::unreachable)?;
        let patience = self.timeout.unwrap_or(patience);
        let mut observe = |_: &Record| {};
        let exchange = Exchange { bus: live.bus.as_mut(), observe: &mut observe, ends: Timestamp::MAX };
        let mut master = Master { exchange, patience, json: self.json || matches!(self.format, TextOrJson::Json) };
        let acted = act(&mut master);
        // No device may stay in configuration, even after an error. The message is the same in both dialects.
        let left = master.tell(&Request::<Lss>::SwitchGlobal { mode: 0 });
        let status = acted?;
        left?;
        live.report_health();
        Ok(status)
    }
}

/// The master, for one command.
pub struct Master<'a> {
    pub exchange: Exchange<'a>,
    pub patience: Duration,
    pub json: bool,
}

impl Master<'_> {
    /// Sends a request, and waits for its answer.
    pub fn ask<D: Dialect>(&mut self, request: &Request<D>) -> Result<Response<D>, Failure> {
        let usual = if *request == Request::StoreConfiguration { STORE_PATIENCE } else { PATIENCE };
        let response = self.exchange.ask(request, self.patience.max(usual)).map_err(Failure::unreachable)?;
        response.ok_or_else(|| Failure::unreachable(anyhow!("no device answers to \"{request}\"")))
    }

    /// Sends a request that slaves do not answer.
    pub fn tell<D: Dialect>(&mut self, request: &Request<D>) -> Result<(), Failure> {
        self.exchange.bus.send(&request.to_frame(MASTER_CAN_ID)).map_err(Failure::unreachable)?;
        // A slave needs time to process this request before it can take the next.
        self.exchange.wait_for(Duration::from_millis(5), |_| None::<()>).map_err(Failure::unreachable)?;
        Ok(())
    }

    /// Configures the slave that is in configuration.
    pub fn carry_out<D: Dialect>(&mut self, wish: &Wish) -> Result<Status, Failure> {
        if let Some(node_id) = wish.node_id {
            self.configured::<D>(ConfigureCommand::NodeId, &Request::ConfigureNodeId { node_id })?;
        }
        if let Some(index) = wish.bit_rate {
            self.configured::<D>(ConfigureCommand::BitTiming, &Request::ConfigureBitTiming { table: 0, index })?;
        }
        if wish.rest.store {
            self.configured::<D>(ConfigureCommand::Store, &Request::StoreConfiguration)?;
        }
        if let Some(delay) = wish.rest.activate {
            self.tell::<D>(&Request::ActivateBitTiming { delay })?;
            diagnostic(&format!(
                "canvass: all devices change their bit rate in {delay} ms: change that of this interface too"
            ));
        }
        Ok(Status::Good)
    }

    /// Sends a configuration command. Any answer other than success is an error.
    pub fn configured<D: Dialect>(&mut self, command: ConfigureCommand, request: &Request<D>) -> Result<(), Failure> {
        let response = self.ask(request)?;
        let Response::Configured { command: found, error: 0, .. } = response else {
            return Err(anyhow!("{request}: the device answers \"{response}\"").into());
        };
        if found != command {
            return Err(anyhow!("{request}: the device answers \"{response}\"").into());
        }
        if !self.json {
            print(&Printable::document(&format!("{response}\n")))?;
        }
        Ok(())
    }
}
