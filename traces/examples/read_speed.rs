//! Measures how fast a capture becomes records: prints the number of frames and damages and the best CPU time in
//! nanoseconds.
//!
//! `cargo run --release -p canvass-traces --example read_speed -- FILE [RUNS]`

use canvass_traces::{Capture, ReadOptions};
use nix::time::ClockId;
use std::io::{self, Write};
use std::path::Path;
use std::time::Duration;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let path = args.next().ok_or("expected a file")?;
    let runs: u32 = args.next().as_deref().unwrap_or("1").parse()?;
    let (mut frames, mut damages, mut best) = (0, 0, Duration::MAX);
    for _ in 0..runs {
        let begin = cpu_time()?;
        (frames, damages) = (0_u64, 0_u64);
        let mut sum = 0;
        for next in Capture::open(Path::new(&path), &ReadOptions::default())? {
            match next {
                Ok(record) => {
                    frames += 1;
                    sum ^= record.timestamp.nanos() ^ record.frame.len() as u64;
                }
                Err(_) => damages += 1,
            }
        }
        std::hint::black_box(sum);
        best = best.min(cpu_time()?.saturating_sub(begin));
    }
    writeln!(io::stdout(), "{frames} {damages} {}", best.as_nanos())?;
    Ok(())
}

/// The processor time of this thread, so that other programs on the machine don't count.
fn cpu_time() -> nix::Result<Duration> {
    ClockId::CLOCK_THREAD_CPUTIME_ID.now().map(Duration::from)
}
