//! What the command line says.

use anyhow::{Context, Result, bail};

/// What is repeated.
pub struct Options {
    /// How often.
    pub runs: u32,
    /// So many devices and testers at the same time, each pair on a bus of its own.
    pub at_once: usize,
    /// The simulated devices.
    pub models: Vec<String>,
    /// The cases, as `canvass test --select` takes them.
    pub select: Option<String>,
    /// A CAN interface instead of SLCAN over TCP; then one pair at a time.
    pub interface: Option<String>,
}

impl Options {
    /// Reads `[--runs N] [--at-once N] [--model ID]... [--select CASES] [--bus INTERFACE]`.
    ///
    /// # Errors
    /// If an argument is not one of these.
    pub fn read(arguments: &[String]) -> Result<Self> {
        let mut options = Self { runs: 3, at_once: 2, models: Vec::new(), select: None, interface: None };
        let mut arguments = arguments.iter();
        while let Some(name) = arguments.next() {
            let value = arguments.next().with_context(|| format!("{name} needs a value"))?;
            match name.as_str() {
                "--runs" => options.runs = value.parse()?,
                "--at-once" => options.at_once = value.parse()?,
                "--model" => options.models.push(value.clone()),
                "--select" => options.select = Some(value.clone()),
                "--bus" => options.interface = Some(value.clone()),
                _ => bail!(
                    "usage: cargo xtask flaky [--runs N] [--at-once N] [--model ID]... [--select CASES] [--bus INTERFACE]"
                ),
            }
        }
        if options.models.is_empty() {
            options.models.push("reference-301".to_owned());
        }
        if options.interface.is_some() {
            options.at_once = 1;
        }
        Ok(options)
    }
}
