//! SDO block transfers, and the raw messages of cases that break off inside a block transfer.

use super::Bench;
use super::sdo::Attempt;
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_bus::client::block_download::DownloadManner;
use canvass_bus::client::block_upload::{UploadManner, abort};
use canvass_bus::client::{BlockDownload, BlockStep, BlockTransfer, BlockUpload, Message, Outcome};
use canvass_traces::Frame;

/// Maximum number of server messages in a block transfer: a value of a megabyte has 150 000.
const MOST_MESSAGES: usize = 200_000;

/// The command byte of an abort. No segment has this byte: sequence numbers begin with 1.
pub(super) const ABORT: u8 = 0x80;

fn has_succeeded<T>((attempt, _): &(Attempt, T)) -> bool {
    matches!(attempt.outcome, Outcome::Uploaded(_) | Outcome::Downloaded)
}

impl Bench<'_> {
    /// Uploads an object in blocks. The client records how the server behaved.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub fn block_upload(
        &mut self,
        multiplexer: Multiplexer,
        manner: UploadManner,
    ) -> Result<(Attempt, BlockUpload), Stop> {
        self.between_others(has_succeeded, move |bench| {
            let mut client = BlockUpload::new(multiplexer, manner.clone());
            let attempt = bench.block_transfer(&mut client, format!("block upload of {multiplexer}"))?;
            Ok((attempt, client))
        })
    }

    /// Downloads an object in blocks. The bench puts the earlier value back after the case.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub fn block_download(
        &mut self,
        multiplexer: Multiplexer,
        value: &[u8],
        manner: DownloadManner,
    ) -> Result<(Attempt, BlockDownload), Stop> {
        self.remember(multiplexer)?;
        self.between_others(has_succeeded, |bench| {
            let mut client = BlockDownload::new(multiplexer, value, manner);
            let what = format!("block download of {} bytes to {multiplexer}", value.len());
            let attempt = bench.block_transfer(&mut client, what)?;
            Ok((attempt, client))
        })
    }

    fn block_transfer(&mut self, client: &mut dyn BlockTransfer, what: String) -> Result<Attempt, Stop> {
        self.drain()?;
        let begin = client.begin();
        self.send_message(begin)?;
        let mut responses: Vec<Frame> = Vec::new();
        for _ in 0..MOST_MESSAGES {
            let Some(frame) = self.wait_for_response(self.timing().sdo_response)? else {
                self.send_message(abort(client.multiplexer(), AbortCode::TIMEOUT))?;
                return Ok(Attempt { multiplexer: client.multiplexer(), what, outcome: Outcome::Silent, responses });
            };
            if responses.len() < 256 {
                responses.push(frame);
            }
            if !client.awaits_segment() || frame.bytes()[0] == ABORT {
                self.judge_answer(Some(client.multiplexer()), &frame);
            }
            let outcome = match client.handle(frame.bytes()) {
                BlockStep::Wait => continue,
                BlockStep::Send(messages) => {
                    self.send_messages(&messages)?;
                    continue;
                }
                BlockStep::Finish(messages, outcome) => {
                    self.send_messages(&messages)?;
                    outcome
                }
                BlockStep::Done(outcome) => outcome,
            };
            if matches!(outcome, Outcome::Violated(_)) {
                self.send_message(abort(client.multiplexer(), AbortCode::GENERAL))?;
            }
            return Ok(Attempt { multiplexer: client.multiplexer(), what, outcome, responses });
        }
        self.send_message(abort(client.multiplexer(), AbortCode::GENERAL))?;
        Ok(Attempt {
            multiplexer: client.multiplexer(),
            what,
            outcome: Outcome::Violated(canvass_bus::client::Violation::Endless),
            responses,
        })
    }

    fn send_messages(&mut self, messages: &[Message]) -> Result<(), Stop> {
        messages.iter().try_for_each(|message| self.send_message(*message))
    }

    /// Sends eight bytes to the SDO server, even if they form no valid message.
    ///
    /// # Errors
    /// The errors of [`Bench::send`].
    pub(crate) fn send_message(&mut self, message: Message) -> Result<(), Stop> {
        let cob_id = canvass_analyzer::wire::sdo::REQUEST_BASE + u16::from(self.node().raw());
        self.send_bytes(cob_id, &message).map(|_| ())
    }
}
