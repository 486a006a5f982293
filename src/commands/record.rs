//! `canvass record`: records a bus into files.

mod outputs;

use crate::files::Files;
use crate::interrupt::Interrupt;
use crate::live::{channel_name, open_bus, parse_size, parse_span, time_base};
use crate::output::diagnostic;
use crate::reconnect::{interruptions, status_of_listener};
use crate::status::{Failure, Status};
use anyhow::anyhow;
use canvass_bus::Bus;
use canvass_traces::{Channels, Duration, Format, Timestamp};
use outputs::{Outputs, Rotation};
use std::path::PathBuf;

/// Record a bus into files of any format that canvass writes
///
/// Receiving does not wait for the disk. Even if the recorder is killed, everything up to the last second is
/// readable. After an interruption of the bus, recording goes on when the bus is back. Ends by Ctrl-C, --for or
/// --frames, with exit status 1 if frames were lost, and 3 if the bus did not come back.
#[derive(clap::Args)]
pub struct Args {
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// The files to write; their extensions give the formats, such as .pcapng, .mcap or .log; .log.gz is compressed
    #[arg(required = true, value_name = "OUT")]
    out: Vec<PathBuf>,
    /// The format to write, if the extension does not give it
    #[arg(long, value_name = "FORMAT", value_parser = crate::inputs::parse_format)]
    to: Option<Format>,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Begin a new file after this many bytes, such as 500k, 100M or 2G; the files are then numbered: OUT-0001
    #[arg(long, value_name = "SIZE", value_parser = parse_size)]
    rotate_size: Option<u64>,
    /// Begin a new file after this time, such as 10min or 1h
    #[arg(long, value_name = "SPAN", value_parser = parse_span)]
    rotate_time: Option<Duration>,
    /// Keep only this many files of each output, the latest
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    keep: Option<u32>,
    /// End after this time, such as 10, 500ms or 1h
    #[arg(long = "for", value_name = "SPAN", value_parser = parse_span)]
    span: Option<Duration>,
    /// End after this many frames
    #[arg(long, value_name = "N")]
    frames: Option<u64>,
}

/// Interval between two flushes: if the recorder is killed, at most the frames of this interval are lost.
const FLUSH: Duration = Duration::from_millis(250);

/// Number of frames between two looks at the clock while frames come without a pause.
const CLOCK: u64 = 64;

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        Files::new().bus(&self.bus).writes(&self.out)?;
        let mut bus = open_bus(&self.bus, 0)?.bus;
        if !bus.is_live() && self.span.is_none() && self.frames.is_none() {
            return Err(
                anyhow!("on a simulated bus time is virtual: limit the recording with --for or --frames").into()
            );
        }
        let mut channels = Channels::new();
        channels.intern(channel_name(&self.bus));
        let rotation = Rotation { size: self.rotate_size, time: self.rotate_time, keep: self.keep };
        let mut outputs = Outputs::open(&self.out, self.to, self.force, rotation, time_base(bus.as_ref()))?;
        let interrupt = Interrupt::watch()?;
        diagnostic(&format!("canvass: recording {}", self.bus));
        let mut frames = 0;
        let recorded = self.record(bus.as_mut(), &channels, &mut outputs, &interrupt, &mut frames);
        // The files are completed also after an error, so that their frames can be read.
        let finished = outputs.finish();
        let status = report(&self.bus, bus.as_ref(), frames);
        recorded?;
        finished?;
        Ok(status)
    }

    fn record(
        &self,
        bus: &mut dyn Bus,
        channels: &Channels,
        outputs: &mut Outputs,
        interrupt: &Interrupt,
        frames: &mut u64,
    ) -> Result<(), Failure> {
        let mut end = self.span.map_or(Timestamp::MAX, |span| bus.now() + span);
        let (mut now, mut told) = (bus.now(), bus.health());
        let mut flushed = now;
        while self.frames.is_none_or(|wanted| *frames < wanted) {
            if interrupt.came() {
                end = end.min(bus.now());
            }
            match bus.receive(end.min(now + FLUSH)).map_err(Failure::unreachable)? {
                Some(record) => {
                    outputs.write(&record, channels)?;
                    *frames += 1;
                    // Reading the clock for every frame would cost more than writing the frame.
                    if !frames.is_multiple_of(CLOCK) {
                        continue;
                    }
                }
                // All frames received before the end are fetched first.
                None if now >= end => break,
                None => {}
            }
            now = bus.now();
            if now.since(flushed) >= FLUSH {
                outputs.flush()?;
                flushed = now;
                let health = bus.health();
                let since = health.since(&told);
                if since.lost > 0 {
                    diagnostic(&format!("canvass: {} frames were lost here, at {now} s", since.lost));
                }
                if let Some(trouble) = since.trouble {
                    diagnostic(&format!("canvass: {trouble}: recording goes on when the bus is back"));
                }
                if told.interrupted_since.is_some() && health.interrupted_since.is_none() {
                    diagnostic(&format!("canvass: the bus is back, after {}", since.interrupted_for));
                }
                told = health;
            }
        }
        Ok(())
    }
}

/// Reports the number of frames recorded and lost.
fn report(address: &str, bus: &dyn Bus, frames: u64) -> Status {
    let (lost, interruptions) = (bus.health().lost, interruptions(bus));
    let told = interruptions.as_ref().map(|interruptions| format!(", {interruptions}")).unwrap_or_default();
    diagnostic(&format!("canvass: {frames} frames recorded, {lost} lost{told}"));
    status_of_listener(address, interruptions.as_ref(), if lost > 0 { Status::Findings } else { Status::Good })
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_bus::BusError;
    use canvass_traces::{ChannelId, Frame, Record, parse_frame};
    use clap::Parser;
    use std::cell::Cell;
    use std::collections::VecDeque;

    /// A bus whose frames wait to be fetched; each look at the clock takes a second.
    struct Behind {
        now: Cell<Timestamp>,
        waiting: VecDeque<Record>,
    }

    impl Bus for Behind {
        fn now(&self) -> Timestamp {
            self.now.replace(self.now.get() + Duration::from_secs(1))
        }

        fn send(&mut self, _: &Frame) -> Result<(), BusError> {
            Ok(())
        }

        fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
            let is_in_time = self.waiting.front().is_some_and(|record| record.timestamp <= deadline);
            Ok(if is_in_time { self.waiting.pop_front() } else { None })
        }

        fn bit_rate(&self) -> Option<u32> {
            None
        }
    }

    #[derive(clap::Parser)]
    struct Command {
        #[command(flatten)]
        args: Args,
    }

    #[test]
    fn what_came_before_the_end_is_recorded_however_far_behind() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out.log");
        let args = Command::parse_from(["record", "can0", &out.display().to_string(), "--for", "2s"]).args;
        let frame = parse_frame("123#00").unwrap().frame;
        let at = |second: u64| Record::new(Timestamp(second * 1_000_000_000), ChannelId(0), frame);
        let waiting = [0, 0, 0, 0, 1, 1, 1, 1, 2, 3].map(at).into();
        let mut bus = Behind { now: Cell::default(), waiting };
        let mut channels = Channels::new();
        channels.intern("can0");
        let rotation = Rotation { size: None, time: None, keep: None };
        let mut outputs = Outputs::open(&args.out, None, false, rotation, time_base(&bus)).unwrap();
        let mut frames = 0;
        args.record(&mut bus, &channels, &mut outputs, &Interrupt::default(), &mut frames).unwrap();
        outputs.finish().unwrap();
        assert_eq!((frames, bus.waiting.len()), (9, 1));
        assert_eq!(std::fs::read_to_string(&out).unwrap().lines().count(), 9);
    }
}
