//! Devices that have LMT (CiA DS-205) in place of LSS. Both protocols share the CAN-IDs and most commands, but their
//! tables of bit rates differ.

use crate::commands::layer_setting::{Master, PATIENCE};
use crate::status::Failure;
use anyhow::anyhow;
use canvass_analyzer::wire::layer_setting::Dialect;
use canvass_analyzer::wire::lmt::{Lmt, Part, Request, Response};
use canvass_analyzer::wire::lss::{self, Lss};

impl Master<'_> {
    /// The identity of an LMT slave in configuration; LSS slaves do not know this inquiry. `None` if no LMT slave
    /// answers.
    fn find_lmt_slave(&mut self) -> Result<Option<String>, Failure> {
        let mut parts = Vec::new();
        for part in Part::ALL {
            match self.inquire_lmt(part)? {
                Some(told) => parts.push(told),
                None if parts.is_empty() => return Ok(None),
                None => {}
            }
        }
        Ok(Some(parts.join(", ")))
    }

    fn inquire_lmt(&mut self, part: Part) -> Result<Option<String>, Failure> {
        let patience = self.patience.max(PATIENCE);
        let response = self.exchange.ask(&Request::Inquire { part }, patience).map_err(Failure::unreachable)?;
        Ok(match response {
            Some(response @ Response::Part { part: found, .. }) if found == part => Some(response.to_string()),
            _ => None,
        })
    }

    /// Refuses a bus on which an LMT slave answers and no LSS slave.
    pub(super) fn refuse_only_lmt(&mut self) -> Result<(), Failure> {
        let patience = self.patience.max(PATIENCE);
        let vendor_id = lss::Request::Inquire { part: lss::Part::VendorId };
        if self.exchange.ask(&vendor_id, patience).map_err(Failure::unreachable)?.is_some() {
            return Ok(());
        }
        match self.find_lmt_slave()? {
            Some(slave) => Err(Failure::unreachable(anyhow!(
                "no device answers to LSS, but a device answers to LMT (CiA DS-205): {slave}; use canvass lmt"
            ))),
            None => Ok(()),
        }
    }

    /// Refuses to set a bit rate where an LMT slave would read the index in its own, different table.
    pub(super) fn refuse_lmt(&mut self, index: u8) -> Result<(), Failure> {
        let Some(slave) = self.find_lmt_slave()? else { return Ok(()) };
        let rate =
            |rate: Option<u32>| rate.map_or_else(|| "none".to_owned(), |rate| format!("{} kbit/s", rate / 1_000));
        let (wanted, meant) = (rate(Lss::bit_rate(index)), rate(Lmt::bit_rate(index)));
        Err(anyhow!(
            "a device speaks LMT (CiA DS-205), not LSS: {slave}; its table of bit rates differs: row {index} means \
             {wanted} in LSS and {meant} in LMT; nothing was configured: use canvass lmt configure"
        )
        .into())
    }
}
