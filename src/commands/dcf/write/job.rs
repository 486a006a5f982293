//! Writing one configuration to one device.

use super::{Args, is_concise};
use crate::commands::dcf::allow::{Allowed, needed, word};
use crate::commands::dcf::device::{Session, tell, told_objects};
use crate::commands::dcf::diff::compared;
use crate::commands::dcf::file::ConfigurationFile;
use crate::commands::dcf::journal::{self, Undo};
use crate::devices::{describe, named};
use crate::output::{Color, TextJsonOrMarkdown, terminal_width};
use crate::status::{Failure, Status};
use anyhow::{Result, anyhow};
use canvass_analyzer::dictionary::KnownDevice;
use canvass_analyzer::dictionary::configuration::{
    DeviceSettings, Download, Hazard, companions, identity, is_cob_id, ordered,
};
use canvass_analyzer::dictionary::survey::{Answer, Survey};
use canvass_analyzer::object;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::client::Outcome;
use canvass_reports::descriptions::configuration::ComparedConfigurations;
use canvass_reports::document::Style;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::PathBuf;

/// The names of the parts of 1018h.
const PARTS: [&str; 4] = ["vendor-ID", "product code", "revision number", "serial number"];

/// The configuration of one device, and what the device has before.
pub struct Job {
    node: NodeId,
    /// The model or file that describes the device in the journal.
    device: String,
    wanted: Vec<Download>,
    survey: Survey,
    state: Option<State>,
    differences: ComparedConfigurations,
    store: bool,
    /// The journal; `None` for a simulated device, which nobody can leave changed.
    journal: Option<(PathBuf, bool)>,
}

impl Job {
    /// Reads the device, and refuses what must not be written to it.
    pub fn prepare(
        session: &mut Session,
        node: NodeId,
        file: &ConfigurationFile,
        args: &Args,
        is_only: bool,
    ) -> Result<Self, Failure> {
        let values = file.values(node)?;
        let given = args.device.as_deref().map(named);
        let model = session.models(node)?.first().copied();
        let other = match given {
            Some(device) => Some((device.to_owned(), describe(device)?)),
            None => model.map(|model| (model.id().to_owned(), KnownDevice::clone(model.device()))),
        };
        let known = file.known(other.as_ref().map(|(_, known)| known));
        let device = match is_concise(file) {
            true => other.map(|(name, _)| name).unwrap_or_default(),
            false => file.path.display().to_string(),
        };
        let settings = settings(node, &values, &known);
        let wanted = without_acting(node, values, &settings, &args.allow);
        let survey = survey(session, node, &known, &wanted)?;
        check_identity(node, &known, &survey, &args.allow)?;
        let state = session.state(node, &survey)?;
        check_state(&session.address, node, state, &args.allow)?;
        let (one, address) = (file.path.display().to_string(), &session.address);
        let differences = compared((one, &wanted), (format!("node {node} on {address}"), &survey), &known.description);
        check_hazards(node, &wanted, &differences, &settings, &args.allow)?;
        let path = || journal::path(args.journal.as_deref(), address, node, is_only);
        let is_journaled = session.is_live() || args.journal.is_some();
        let journal = is_journaled.then(|| (path(), args.journal.is_some()));
        Ok(Self { node, device, wanted, survey, state, differences, store: args.store, journal })
    }

    /// Prints what differs.
    pub fn show(&self, color: Color) -> Result<(), Failure> {
        let style = Style { color: color.on_stdout(), width: terminal_width() };
        TextJsonOrMarkdown::Text.print(&self.differences, style)?;
        Ok(())
    }

    /// Writes what differs, reads it back, and lets the device store it.
    pub fn carry_out(&mut self, session: &mut Session) -> Result<Status, Failure> {
        if self.differences.differences.is_empty() && !self.store {
            return Ok(Status::Good);
        }
        let (node, address) = (self.node, session.address.clone());
        let begin = |(path, is_kept): &(PathBuf, bool)| {
            Undo::begin(path, *is_kept, &address, node, &self.device, self.state, &self.survey)
        };
        let mut undo = self.journal.as_ref().map(begin).transpose()?;
        let done = self.write(session).and_then(|done| match done {
            true => self.finish(session, undo.as_mut()),
            false => Ok(Status::Findings),
        });
        match (&done, undo) {
            (Ok(Status::Good), Some(undo)) => undo.end()?,
            (_, Some(undo)) => undo.tell(),
            (_, None) => {}
        }
        done
    }

    /// Whether all was written.
    fn write(&self, session: &mut Session) -> Result<bool, Failure> {
        let steps = self.steps();
        let (all, node) = (steps.len(), self.node);
        let (mut queue, mut done) = (VecDeque::from(steps), 0);
        // A setting may depend on another that comes later: it is tried again once others were written since.
        let mut postponed: Vec<(Download, Outcome)> = Vec::new();
        while let Some(download) = queue.pop_front() {
            if session.is_interrupted() {
                tell(node, &format!("interrupted: {done} of {all} writes were done"));
                return Ok(false);
            }
            match session.write(node, &download)? {
                Outcome::Downloaded => {
                    done += 1;
                    queue.extend(postponed.drain(..).map(|(download, _)| download));
                }
                Outcome::Silent => return Err(session.silent(node, download.at)),
                refused if may_wait(download.at) => postponed.push((download, refused)),
                refused => return Ok(self.refused(&download, &refused, done, all)),
            }
        }
        match postponed.first() {
            None => Ok(true),
            Some((download, refused)) => Ok(self.refused(download, refused, done, all)),
        }
    }

    fn refused(&self, download: &Download, refused: &Outcome, done: usize, all: usize) -> bool {
        let value = canvass_traces::hex::spaced(&download.value);
        tell(self.node, &format!("{} = {value} was refused: {refused}; {done} of {all} writes were done", download.at));
        false
    }

    /// Reads back what was written, and lets the device store it.
    fn finish(&self, session: &mut Session, undo: Option<&mut Undo>) -> Result<Status, Failure> {
        let mut unlike = 0;
        for differing in &self.differences.differences {
            let now = session.value(self.node, differing.at)?;
            if now != differing.one {
                let told = |value: Option<&Vec<u8>>| {
                    value.map_or_else(|| "no value".to_owned(), |value| canvass_traces::hex::spaced(value).to_string())
                };
                let (now, wanted) = (told(now.as_ref()), told(differing.one.as_ref()));
                tell(self.node, &format!("{} reads {now} after {wanted} was written", differing.at));
                unlike += 1;
            }
        }
        if unlike > 0 {
            return Ok(Status::Findings);
        }
        let written = match self.differences.differences.len() {
            1 => "1 setting".to_owned(),
            many => format!("{many} settings"),
        };
        tell(self.node, &format!("{written} written and read back"));
        if self.store {
            undo.map_or(Ok(()), Undo::store)?;
            match session.store(self.node)? {
                Outcome::Downloaded => tell(self.node, "stored"),
                refused => {
                    tell(self.node, &format!("is not stored (1010h:01): {refused}"));
                    return Ok(Status::Findings);
                }
            }
        }
        Ok(Status::Good)
    }

    /// The writes in their order: what differs, and what must be written with it.
    fn steps(&self) -> Vec<Download> {
        let wanted: BTreeMap<Multiplexer, &Vec<u8>> =
            self.wanted.iter().map(|download| (download.at, &download.value)).collect();
        let mut objects: BTreeSet<Multiplexer> = self.differences.differences.iter().map(|one| one.at).collect();
        let changed: Vec<Multiplexer> = objects.iter().copied().collect();
        for at in changed {
            objects.extend(companions(at).into_iter().flatten());
            // A device may forget all entries of a mapping while its count is 0.
            if object::is_pdo_mapping(at.index.0) {
                objects.extend(wanted.keys().filter(|other| other.index == at.index));
            }
        }
        let value = |at: Multiplexer| wanted.get(&at).map(|value| (*value).clone()).or_else(|| self.before(at));
        let downloads: Vec<Download> =
            objects.iter().filter_map(|&at| Some(Download { at, value: value(at)? })).collect();
        let held = objects.iter().filter(|at| is_cob_id(**at));
        let held: Vec<(Multiplexer, u32)> =
            held.filter_map(|&at| Some((at, u32::try_from(self.survey.number(at)?).ok()?))).collect();
        ordered(&downloads, &held)
    }

    fn before(&self, at: Multiplexer) -> Option<Vec<u8>> {
        self.survey.value(at).map(<[u8]>::to_vec)
    }
}

/// Whether an object may be written after others that it depends on: not within the order of a communication object.
fn may_wait(at: Multiplexer) -> bool {
    at.index.0 >= 0x2000
}

/// Reads the device: all that is described, and all that is to be written.
fn survey(session: &mut Session, node: NodeId, known: &KnownDevice, wanted: &[Download]) -> Result<Survey, Failure> {
    let mut survey = session.survey(node, &known.description)?;
    let needed = wanted.iter().flat_map(|download| companions(download.at).into_iter().flatten().chain([download.at]));
    for at in needed.collect::<BTreeSet<Multiplexer>>() {
        if survey.get(at).is_none()
            && let Some(value) = session.value(node, at)?
        {
            survey.insert(at, Answer::Value(value));
        }
    }
    Ok(survey)
}

/// The device with the RPDOs that it will have: outputs are no settings.
fn settings<'a>(node: NodeId, values: &[Download], known: &'a KnownDevice) -> DeviceSettings<'a> {
    DeviceSettings::new(known, |at| {
        let written = values.iter().find(|download| download.at == at).map(|download| &download.value);
        let number =
            |value: &Vec<u8>| value.iter().take(8).rev().fold(0, |number, byte| number << 8 | u64::from(*byte));
        let described = || known.description.dictionary.entry(at).ok()?.start_value(node)?.to_raw();
        written.map(number).or_else(described)
    })
}

/// The values without those of objects that act, unless the user allows them.
fn without_acting(
    node: NodeId,
    values: Vec<Download>,
    settings: &DeviceSettings<'_>,
    allowed: &[Allowed],
) -> Vec<Download> {
    let mut left: BTreeMap<Hazard, Vec<Multiplexer>> = BTreeMap::new();
    let mut wanted = Vec::new();
    for download in values {
        match settings.hazard(download.at, &download.value) {
            Some(hazard @ (Hazard::Acts(_) | Hazard::Process))
                if !needed(hazard).is_some_and(|needed| allowed.contains(&needed)) =>
            {
                left.entry(hazard).or_default().push(download.at);
            }
            _ => wanted.push(download),
        }
    }
    for (hazard, objects) in left {
        let how = needed(hazard).map_or_else(String::new, |needed| format!(" (--allow {})", word(needed)));
        tell(node, &format!("left out, {hazard}{how}: {}", told_objects(&objects)));
    }
    wanted
}

fn check_identity(node: NodeId, known: &KnownDevice, survey: &Survey, allowed: &[Allowed]) -> Result<()> {
    if allowed.contains(&Allowed::Identity) {
        return Ok(());
    }
    let wanted = identity(&known.description, node);
    for ((sub, name), wanted) in (1..).zip(PARTS).zip(wanted) {
        let found = survey.number(Multiplexer::new(object::IDENTITY, sub));
        if let (Some(wanted), Some(found)) = (wanted, found)
            && u64::from(wanted) != found
        {
            return Err(anyhow!(
                "node {node} is not the device of the file: expected the {name} {wanted:08X}h (1018h:{sub:02X}), found \
                 {found:08X}h; --allow identity writes all the same"
            ));
        }
    }
    Ok(())
}

fn check_state(address: &str, node: NodeId, state: Option<State>, allowed: &[Allowed]) -> Result<()> {
    match state {
        Some(State::OPERATIONAL) if !allowed.contains(&Allowed::Operational) => Err(anyhow!(
            "node {node} is operational, and its configuration would change while it works: `canvass nmt {address} \
             pre-operational {node}` first, or --allow operational"
        )),
        Some(State::STOPPED) => Err(anyhow!(
            "node {node} is stopped, and answers no SDO: `canvass nmt {address} pre-operational {node}` first"
        )),
        _ => Ok(()),
    }
}

fn check_hazards(
    node: NodeId,
    wanted: &[Download],
    differences: &ComparedConfigurations,
    settings: &DeviceSettings<'_>,
    allowed: &[Allowed],
) -> Result<()> {
    let changed = |at: Multiplexer| differences.differences.iter().any(|differing| differing.at == at);
    for download in wanted.iter().filter(|download| changed(download.at)) {
        if let Some(hazard) = settings.hazard(download.at, &download.value)
            && let Some(needed) = needed(hazard)
            && !allowed.contains(&needed)
        {
            let (at, word) = (download.at, word(needed));
            return Err(anyhow!("node {node}: {at} {hazard}: --allow {word} writes it; nothing was written"));
        }
    }
    Ok(())
}
