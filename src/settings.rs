//! `canvass.toml`: settings of a project, in the working directory or a folder above. The command line and the
//! environment take precedence.

mod file;

use anyhow::{Context, Result};
use canvass_traces::small_file::{self, OF_HAND};
use clap::Command;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The name of the file.
pub const NAME: &str = "canvass.toml";

/// The environment variable that names the bus.
pub const BUS_VARIABLE: &str = "CANVASS_BUS";

/// Commands whose bus may come from the settings.
pub const ON_BUS: [&str; 5] = ["test", "fuzz", "monitor", "scan", "restore"];
/// Commands that test one device.
const OF_DEVICE: [&str; 2] = ["test", "fuzz"];
/// Commands that take devices by node.
const OF_NODES: [&str; 5] = ["decode", "diagnose", "signals", "plot", "monitor"];

/// The content of the file.
pub struct Settings {
    /// The path of the file.
    pub path: PathBuf,
    /// The settings in the order of the file.
    pub settings: Vec<Setting>,
}

/// One key with its value.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Setting {
    /// The key, such as `node` or `timeouts.sdo`.
    pub key: String,
    /// The value as it would be typed.
    pub value: String,
    /// The line of the file.
    pub line: usize,
}

impl Settings {
    /// Finds the nearest file.
    ///
    /// # Errors
    /// If the file can't be read or has an unknown key, with its path and line.
    pub fn find() -> Result<Option<Self>> {
        let Ok(folder) = std::env::current_dir() else { return Ok(None) };
        let found = folder.ancestors().map(|folder| folder.join(NAME)).find(|path| path.is_file());
        found.map(|path| Self::read(&path)).transpose()
    }

    fn read(path: &Path) -> Result<Self> {
        let unreadable = || format!("can't read {}", path.display());
        let text = small_file::read_text(path, OF_HAND).with_context(unreadable)?;
        let settings = file::read(path, &text)?;
        Ok(Self { path: path.to_owned(), settings })
    }

    fn value(&self, key: &str) -> Option<&str> {
        self.settings.iter().find(|setting| setting.key == key).map(|setting| setting.value.as_str())
    }

    /// `KEY=VALUE` for all keys of a table.
    fn table(&self, name: &str) -> Vec<String> {
        let of = |setting: &Setting| {
            let key = setting.key.strip_prefix(name)?.strip_prefix('.')?;
            Some(format!("{key}={}", setting.value))
        };
        self.settings.iter().filter_map(of).collect()
    }

    /// The settings for the arguments of a command; `typed` holds the arguments of the command line.
    fn arguments(&self, command: &str, typed: &Typed) -> Vec<(&'static str, Vec<String>)> {
        let one = |key: &'static str| (key, self.value(key).map(str::to_owned).into_iter().collect());
        let mut all = Vec::new();
        if ON_BUS.contains(&command) {
            all.push(one("bus"));
        }
        // Node, device and waivers of the file belong to the file's bus: they do not apply to another bus.
        let is_its_bus = typed.bus.is_none() || typed.bus.as_deref() == self.value("bus");
        if is_its_bus && OF_DEVICE.contains(&command) {
            all.extend([one("node"), one("device")]);
        }
        if is_its_bus && OF_NODES.contains(&command) {
            all.push(("device", self.device_of_node().into_iter().collect()));
        }
        match command {
            "test" if is_its_bus => all.extend([one("waivers"), ("timeout", self.table("timeouts"))]),
            "test" => all.push(("timeout", self.table("timeouts"))),
            "diagnose" => all.push(("threshold", self.table("thresholds"))),
            _ => {}
        }
        all.into_iter().filter(|(_, values)| !values.is_empty()).collect()
    }

    /// `NODE=DEVICE`, if the file has both.
    fn device_of_node(&self) -> Option<String> {
        let device = self.value("device")?;
        if device.contains('=') {
            return Some(device.to_owned());
        }
        self.value("node").map(|node| format!("{node}={device}"))
    }
}

/// The parts of the command line that decide which settings apply.
#[derive(Default)]
struct Typed {
    bus: Option<String>,
    /// The typed options.
    options: Vec<String>,
}

/// A command line with the settings added.
pub struct Completed {
    /// The commands, with the settings as defaults.
    pub command: Command,
    /// The command line.
    pub arguments: Vec<OsString>,
    /// The arguments whose default comes from the settings.
    pub set: Vec<&'static str>,
    /// The settings file, if it sets something for this command.
    pub file: Option<PathBuf>,
}

/// Adds the settings to the typed command.
///
/// # Errors
/// If the file has an error and the command would use it.
pub fn complete(command: Command, mut arguments: Vec<OsString>) -> Result<Completed> {
    if let Some(arguments) = with_bus(&command, &arguments)? {
        return Ok(Completed { command, arguments, set: Vec::new(), file: None });
    }
    let (name, typed) = typed(&command, &arguments);
    let is_used = ON_BUS.iter().chain(&OF_NODES).any(|known| name.as_deref() == Some(known));
    let (Some(name), true) = (name, is_used) else {
        return Ok(Completed { command, arguments, set: Vec::new(), file: None });
    };
    let Some(settings) = Settings::find()? else {
        return Ok(Completed { command, arguments, set: Vec::new(), file: None });
    };
    let all = settings.arguments(&name, &typed);
    let file = (!all.is_empty()).then_some(settings.path);
    let (mut set, mut command) = (Vec::new(), command);
    for (id, values) in all {
        if !typed.options.iter().any(|option| option == id) {
            command = with_default(command, &name, id, &values);
            set.push(id);
        } else if matches!(id, "timeout" | "threshold") {
            // Each value is a separate argument; typed values come later and take precedence.
            put_first(&mut arguments, &name, id, &values);
        }
    }
    Ok(Completed { command, arguments, set, file })
}

/// Whether the arguments of a command begin with the bus, so that the bus can be left out.
///
/// The commands of [`ON_BUS`] have no other argument without a name: clap itself fills in their bus.
pub fn begins_with_bus(command: &Command) -> bool {
    let is_first = command.get_positionals().next().is_some_and(|first| first.get_id() == "bus");
    is_first && !ON_BUS.contains(&command.get_name())
}

/// The command line with the bus of the environment or of the settings file, if the bus was left out.
///
/// The arguments after the bus have forms that no bus has: a node-ID, the name of an NMT command, a frame. The bus was
/// therefore left out exactly if the command line is right with the bus put in.
fn with_bus(command: &Command, arguments: &[OsString]) -> Result<Option<Vec<OsString>>> {
    let Some(at) = end_of_names(command, arguments) else { return Ok(None) };
    let with = |bus: &OsString| {
        let mut arguments = arguments.to_vec();
        arguments.insert(at, bus.clone());
        command.clone().try_get_matches_from(&arguments).is_ok().then_some(arguments)
    };
    // Whether a bus would fit is asked first: a mistake in the settings must not stop a command that does not use them.
    if with(&"can0".into()).is_none() {
        return Ok(None);
    }
    let bus = match std::env::var_os(BUS_VARIABLE) {
        Some(bus) => Some(bus),
        None => Settings::find()?.and_then(|settings| settings.value("bus").map(OsString::from)),
    };
    Ok(bus.as_ref().and_then(with))
}

/// The place after the names of the command and its subcommand, if the arguments there begin with a bus.
fn end_of_names(command: &Command, arguments: &[OsString]) -> Option<usize> {
    let (mut command, mut at) = (command, 1);
    while command.has_subcommands() {
        let found = (at..arguments.len()).find_map(|place| {
            let name = arguments.get(place)?.to_str()?;
            Some((command.find_subcommand(name)?, place + 1))
        });
        (command, at) = found?;
    }
    begins_with_bus(command).then_some(at)
}

/// The subcommand and its arguments, as far as they can be determined without parsing the whole command line.
fn typed(command: &Command, arguments: &[OsString]) -> (Option<String>, Typed) {
    let Ok(matches) = command.clone().ignore_errors(true).try_get_matches_from(arguments) else {
        return Default::default();
    };
    let Some((name, below)) = matches.subcommand() else { return Default::default() };
    let is_typed = |id: &str| below.value_source(id) == Some(clap::parser::ValueSource::CommandLine);
    let options = below.ids().map(|id| id.as_str().to_owned()).filter(|id| is_typed(id)).collect();
    let bus = below.try_get_one::<String>("bus").ok().flatten().filter(|_| is_typed("bus")).cloned();
    (Some(name.to_owned()), Typed { bus, options })
}

fn with_default(command: Command, name: &str, id: &'static str, values: &[String]) -> Command {
    let with_values = |argument: clap::Arg| match argument.get_id() == id {
        true => argument.required(false).default_values(values.to_vec()),
        false => argument,
    };
    command.mut_subcommands(|below| if below.get_name() == name { below.mut_args(with_values) } else { below })
}

fn put_first(arguments: &mut Vec<OsString>, name: &str, option: &str, values: &[String]) {
    let Some(at) = arguments.iter().position(|argument| argument == name) else { return };
    let added = values.iter().map(|value| OsString::from(format!("--{option}={value}")));
    arguments.splice(at + 1..at + 1, added);
}
