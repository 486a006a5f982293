//! A simulated device in virtual time for an independent program: requests on standard input, answers on standard
//! output, one JSON object per line ([`request`]). The peer acts as the device's user: it reads, writes, waits, and
//! switches the supply off and on. In between it lets canvass test the device, ends such a run early, and lets canvass
//! restore the device.

mod request;
mod run;
mod watched;
mod world;

use anyhow::Result;
use request::Request;
use serde_json::{Value, json};
use std::io::{BufRead, Write, stdin, stdout};
use world::World;

fn main() -> Result<()> {
    let mut world = World::new()?;
    let mut out = stdout().lock();
    for line in stdin().lock().lines() {
        let answer = answer(&mut world, &line?).unwrap_or_else(|error| json!({ "error": format!("{error:#}") }));
        writeln!(out, "{answer}")?;
        out.flush()?;
    }
    Ok(())
}

fn answer(world: &mut World, line: &str) -> Result<Value> {
    match serde_json::from_str(line)? {
        Request::Catalogue => Ok(world::catalogue()),
        Request::Device { address } => world.device(address),
        Request::Send { frame, silence_us } => world.send(&frame, silence_us),
        Request::Wait { ms } => world.wait(ms),
        Request::PowerCycle => world.power_cycle(),
        Request::Keep { name } => world.keep(name),
        Request::GoBack { name } => world.go_back(&name),
        Request::Run(wanted) => run::test(world, &wanted),
        Request::Restore => run::restore(world),
    }
}
