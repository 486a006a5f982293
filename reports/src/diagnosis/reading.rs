//! A diagnosis of captures that are read record by record.

use super::html::Collector;
use canvass_analyzer::findings::{Diagnosis, InOrder, Results, SourceQuality};
use canvass_traces::{ChannelId, Merge, Record};
use std::io;

/// Gives records to a diagnosis in the order of their times, and to what collects for the page.
pub struct Reading {
    diagnosis: Diagnosis,
    collector: Option<Collector>,
    order: InOrder,
    /// The channels whose bit rates were asked for.
    channels: usize,
}

impl Reading {
    /// A diagnosis to which nothing was shown yet; with what the page needs, or without.
    pub fn new(diagnosis: Diagnosis, collector: Option<Collector>) -> Self {
        Self { diagnosis, collector, order: InOrder::default(), channels: 0 }
    }

    /// Something could not be read: frames may be missing here.
    ///
    /// # Errors
    /// As [`Reading::record`].
    pub fn interrupted(&mut self, captures: &Merge) -> io::Result<()> {
        self.flush(captures)?;
        self.diagnosis.interrupted();
        Ok(())
    }

    /// Takes the bit rates of channels that are new, where their captures know them.
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

    /// Takes the next record, and leaves something else in its place.
    ///
    /// # Errors
    /// What collects for the page may write.
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

    /// What was found, and what was collected.
    ///
    /// # Errors
    /// As [`Reading::record`].
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
