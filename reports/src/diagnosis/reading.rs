//! The diagnosis of captures that are read record by record.

use super::html::Collector;
use canvass_analyzer::findings::{Diagnosis, InOrder, Results, SourceQuality};
use canvass_traces::{ChannelId, Merge, Record};
use std::io;

/// Passes records to a diagnosis and to the collector of the page, in the order of their times.
pub struct Reading {
    diagnosis: Diagnosis,
    collector: Option<Collector>,
    order: InOrder,
    /// Number of channels whose bit rates were taken over.
    channels: usize,
}

impl Reading {
    /// Begins a diagnosis, with a collector if there is to be a page.
    pub fn new(diagnosis: Diagnosis, collector: Option<Collector>) -> Self {
        Self { diagnosis, collector, order: InOrder::default(), channels: 0 }
    }

    /// Handles a part of a capture that could not be read: frames may be missing here.
    ///
    /// # Errors
    /// The errors of [`Reading::record`].
    pub fn interrupted(&mut self, captures: &Merge) -> io::Result<()> {
        self.flush(captures)?;
        self.diagnosis.interrupted();
        Ok(())
    }

    /// Takes over the bit rates of new channels, if their captures contain them.
    #[inline]
    pub fn see_channel(&mut self, channel: ChannelId, captures: &Merge) {
        if usize::from(channel.0) >= self.channels {
            self.say_bit_rates(captures);
        }
    }

    #[cold]
    fn say_bit_rates(&mut self, captures: &Merge) {
        let new = self.channels..captures.channels().len();
        self.channels = new.end;
        for channel in new.filter_map(|channel| u16::try_from(channel).ok()).map(ChannelId) {
            if let Some(bit_rate) = captures.bit_rate(channel) {
                self.diagnosis.say_bit_rate(channel, bit_rate);
            }
        }
    }

    /// Takes the next record. It leaves another record in its place, so that memory is reused.
    ///
    /// # Errors
    /// The errors of the page's collector.
    #[inline]
    pub fn record(&mut self, record: &mut Record, captures: &Merge) -> io::Result<()> {
        self.order.push(record);
        while let Some(record) = self.order.pop() {
            look_at(record, &mut self.diagnosis, &mut self.collector, captures)?;
        }
        Ok(())
    }

    fn flush(&mut self, captures: &Merge) -> io::Result<()> {
        while let Some(record) = self.order.flush() {
            look_at(record, &mut self.diagnosis, &mut self.collector, captures)?;
        }
        Ok(())
    }

    /// Ends the diagnosis. Returns its results and the collector.
    ///
    /// # Errors
    /// The errors of [`Reading::record`].
    pub fn finish(
        mut self,
        captures: &Merge,
        sources: &[SourceQuality<'_>],
    ) -> io::Result<(Results, Option<Collector>)> {
        self.flush(captures)?;
        self.diagnosis.disordered(self.order.disorder());
        Ok((self.diagnosis.finish(sources), self.collector))
    }
}

#[inline]
fn look_at(
    record: &Record,
    diagnosis: &mut Diagnosis,
    collector: &mut Option<Collector>,
    captures: &Merge,
) -> io::Result<()> {
    let observed = diagnosis.record(record);
    match (collector, observed) {
        (Some(collector), Some(observed)) => collector.frame(record, captures.channels(), &observed),
        _ => Ok(()),
    }
}
