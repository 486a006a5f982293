//! `statistics`: frames, rates and load of each channel, in total and by service.

use super::column::{Column, Rows, write_str};
use canvass_analyzer::Service;
use canvass_analyzer::statistics::{BusStatistics, Peak};
use canvass_tables::columns;
use canvass_traces::Timestamp;

/// The rows of `statistics`.
pub struct Statistics;

/// A channel, or one service on it.
pub struct StatisticsRow<'a> {
    /// The name of the capture.
    pub capture: &'a str,
    /// The channel's name.
    pub channel: &'a str,
    /// The statistics of the channel.
    pub bus: &'a BusStatistics,
    /// The service; `None` for all services.
    pub service: Option<Service>,
}

impl Rows for Statistics {
    type Row<'a> = StatisticsRow<'a>;
    const COLUMNS: &'static [Column<Self>] = columns![Self:
        "capture" name "the file" = |row, out| write_str(out, Some(row.capture));
        "channel" name "the channel's name" = |row, out| write_str(out, Some(row.channel));
        "service" word "the service; null: all of them" = |row| row.service.map(Service::name);
        "t" time "the channel's first frame" = |row| Some(row.bus.first);
        "t_last" time "its last frame" = |row| Some(row.bus.last);
        "frames" u64 "frames" = |row| Some(row.frames());
        "frames_per_second" f64 "the mean rate; null of a capture without duration" = |row| row.bus.rate(row.frames());
        "bits" u64 "bits on the bus, with stuff bits and intermission" = |row| Some(row.bits());
        "load_percent" f64 "the mean load, where the bit rate is known" = |row| row.bus.share_of_load(row.bits());
        "peak_t" time "when the fullest tenth of a second began" = |row| row.peak().map(|peak| peak.0);
        "peak_percent" f64 "its load" = |row| row.peak().map(|peak| peak.1);
        "bit_rate" u32 "in bit/s, as the capture says or as inferred" = |row| row.bus.bit_rate.map(u64::from);
        "bit_rate_inferred" flag "whether it was inferred" = |row| row.bus.bit_rate.map(|_| row.bus.is_inferred);
        "copies" u64 "of all services: frames that the interface recorded twice" = |row| row.service.is_none().then_some(row.bus.copies);
    ];
}

impl StatisticsRow<'_> {
    fn frames(&self) -> u64 {
        self.service.map_or_else(|| self.bus.total(), |service| self.bus.frames[service as usize])
    }

    fn bits(&self) -> u64 {
        self.service.map_or_else(|| self.bus.bits.iter().sum(), |service| self.bus.bits[service as usize])
    }

    fn peak(&self) -> Option<(Timestamp, f64)> {
        let peak: &Peak = self.service.map_or(&self.bus.peak, |service| &self.bus.peaks[service as usize]);
        peak.percent(self.bus.bit_rate?)
    }
}
