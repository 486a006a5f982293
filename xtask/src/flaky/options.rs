//! The options of the command line.

use anyhow::{Context, Result, bail, ensure};

/// The usage text.
const USAGE: &str = "usage: cargo xtask flaky [--runs N] [--at-once N] [--model ID]... [--select CASES] [--bus vcan|INTERFACE] [--starve device]";

/// The transport between device and tester.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Transport {
    /// SLCAN over TCP, a connection for each pair.
    Slcan,
    /// SocketCAN, a virtual interface for each pair.
    Virtual,
    /// An existing CAN interface, for one pair at a time.
    Interface(String),
}

/// The process that gets no processor while there is other work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Starved {
    /// The tester is starved. The device gets a processor before the other work, if this user may set its priority.
    Tester,
    /// The device is starved.
    Device,
}

/// The options of `cargo xtask flaky`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// Number of runs.
    pub runs: u32,
    /// Number of devices and testers at the same time, each pair on a bus of its own.
    pub at_once: usize,
    /// The simulated devices.
    pub models: Vec<String>,
    /// The cases, as `canvass test --select` takes them.
    pub select: Option<String>,
    /// The bus.
    pub transport: Transport,
    /// The process that gets a processor only after the other work.
    pub starved: Starved,
    /// Whether this process was started in a machine of its own, with the built program.
    pub in_machine: bool,
}

/// The argument that [`Options::words`] adds for the process in the machine.
const IN_MACHINE: &str = "--in-machine";

impl Options {
    /// Reads the arguments.
    ///
    /// # Errors
    /// If an argument is unknown.
    pub fn read(arguments: &[String]) -> Result<Self> {
        let mut options = Self {
            runs: 3,
            at_once: 2,
            models: Vec::new(),
            select: None,
            transport: Transport::Slcan,
            starved: Starved::Tester,
            in_machine: false,
        };
        let mut arguments = arguments.iter();
        while let Some(name) = arguments.next() {
            if name == IN_MACHINE {
                options.in_machine = true;
                continue;
            }
            let value = arguments.next().with_context(|| format!("{name} needs a value; {USAGE}"))?;
            match name.as_str() {
                "--runs" => options.runs = value.parse()?,
                "--at-once" => options.at_once = value.parse()?,
                "--model" => options.models.push(value.clone()),
                "--select" => options.select = Some(value.clone()),
                "--starve" if value == "device" => options.starved = Starved::Device,
                "--bus" if value == "vcan" => options.transport = Transport::Virtual,
                "--bus" => options.transport = Transport::Interface(value.clone()),
                _ => bail!("{USAGE}"),
            }
        }
        if options.models.is_empty() {
            options.models.push("reference-301".to_owned());
        }
        if matches!(options.transport, Transport::Interface(_)) {
            options.at_once = 1;
        }
        ensure!(options.runs > 0 && options.at_once > 0, "at least one run, and one at once; {USAGE}");
        Ok(options)
    }

    /// The arguments with which the process in the machine repeats the suite in the same way, with another number of
    /// runs.
    pub fn words(&self, runs: u32) -> Vec<String> {
        let mut words = vec![IN_MACHINE.to_owned(), "--bus".to_owned(), "vcan".to_owned()];
        let mut add = |name: &str, value: String| words.extend([name.to_owned(), value]);
        add("--runs", runs.to_string());
        add("--at-once", self.at_once.to_string());
        if self.starved == Starved::Device {
            add("--starve", "device".to_owned());
        }
        self.models.iter().for_each(|model| add("--model", model.clone()));
        if let Some(select) = &self.select {
            add("--select", select.clone());
        }
        words
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Options> {
        Options::read(&text.split_whitespace().map(str::to_owned).collect::<Vec<_>>())
    }

    #[test]
    fn what_goes_into_the_machine_is_what_was_asked_for() {
        let asked =
            read("--bus vcan --runs 100 --at-once 8 --model reference-406 --select 301/sdo --starve device").unwrap();
        assert_eq!(asked.transport, Transport::Virtual);
        let inside = Options::read(&asked.words(50)).unwrap();
        assert_eq!(inside, Options { runs: 50, in_machine: true, ..asked });
    }

    #[test]
    fn one_interface_serves_one_pair() {
        let options = read("--bus can0 --at-once 8").unwrap();
        assert_eq!((options.at_once, options.transport), (1, Transport::Interface("can0".to_owned())));
        assert!(read("--at-once 0").is_err());
        assert!(read("--bus").is_err());
        assert!(read("--often 3").is_err());
        assert!(read("--starve tester").is_err());
        assert_eq!(options.starved, Starved::Tester);
    }
}
