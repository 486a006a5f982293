//! `canvass verify`: checks that a bundle is unchanged, and that its verdicts follow from its recording.

use crate::bundle::setup::{self, Setup};
use crate::bundle::zip::{self, Entry};
use crate::bundle::{RECORDING, RESULT, TRANSCRIPT, WAIVERS, manifest};
use crate::devices;
use crate::devices::named;
use crate::output::{TextOrJson, diagnostic, print};
use crate::status::{Failure, Status};
use anyhow::{Context, Result, anyhow, bail};
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::KnownDevice;
use canvass_bus::Bus;
use canvass_bus::transcript::{Replay, Transcript};
use canvass_device::address::{BusAddress, DeviceName};
use canvass_device::models::Model;
use canvass_reports::escape::{Printable, printable};
use canvass_reports::results::{self, TestResult};
use canvass_suite::bench::{Bench, Target};
use canvass_suite::case::Case;
use canvass_suite::catalogue;
use canvass_suite::runner::{Plan, RunEvent, run};
use canvass_suite::verdict::{Deviation, Kind};
use canvass_suite::waiver::Waivers;
use canvass_traces::small_file::{self, OF_BUNDLE};
use canvass_traces::{Capture, ReadOptions, Record};
use serde_json::json;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Verify a bundle of `canvass test --bundle`
///
/// Checks that no byte was changed, and repeats the run with the recording as its bus: the cases must send the
/// recorded frames, and get the recorded answers. Exit status 1 if a byte was changed or a verdict differs.
#[derive(clap::Args)]
pub struct Args {
    /// The bundle
    bundle: PathBuf,
    /// How to print the result
    #[arg(long, value_enum, default_value_t)]
    format: TextOrJson,
}

/// A verdict that differs from the verdict in the bundle.
struct Difference {
    case: String,
    told: Option<Kind>,
    found: Option<Kind>,
}

/// The result of the verification.
struct Verified {
    cases: usize,
    differences: Vec<Difference>,
    /// The place at which the cases sent something else than was recorded.
    divergence: Option<String>,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let path = self.bundle.display();
        let archive = archive(&self.bundle).with_context(|| format!("can't read {path}"))?;
        let Some(archive) = archive else { return Err(anyhow!("{path} is no bundle of canvass").into()) };
        let entries = match unpacked(&archive) {
            Ok(entries) => entries,
            Err(why) => {
                diagnostic(&format!("canvass: {path} is refused: {why:#}"));
                return Ok(Status::Findings);
            }
        };
        let setup = Setup::read(content(&entries, setup::NAME)?)?;
        if let Some(why) = &setup.not_repeatable {
            return Err(Failure::unreachable(anyhow!(
                "{path}: no byte was changed, but the run can't be judged again: {why}"
            )));
        }
        let verified = judge(&entries, &setup)?;
        let shown = match self.format {
            TextOrJson::Text => Printable::document(&verified.text(&self.bundle)),
            TextOrJson::Json => Printable::pretty_json(&verified.json()),
        };
        print(&shown)?;
        Ok(if verified.is_good() { Status::Good } else { Status::Findings })
    }
}

/// The content of a file that begins like an archive. `None` for any other file, of which only the beginning is read.
fn archive(path: &Path) -> std::io::Result<Option<Vec<u8>>> {
    const BEGINNING: &[u8] = b"PK\x03\x04";
    let mut begun = Vec::new();
    File::open(path)?.take(BEGINNING.len() as u64).read_to_end(&mut begun)?;
    if begun == BEGINNING { small_file::read(path, OF_BUNDLE).map(Some) } else { Ok(None) }
}

/// The files of an unchanged bundle.
fn unpacked(archive: &[u8]) -> Result<Vec<Entry>> {
    let mut entries = zip::read(archive)?;
    let at = entries.iter().position(|entry| entry.name == manifest::NAME).context("manifest.json is missing")?;
    let listed = entries.remove(at);
    manifest::check(&listed, &entries)?;
    entries.insert(at, listed);
    match zip::changed(archive, &entries)? {
        Some(name) => bail!("{name} was changed: its header differs from the one that canvass writes"),
        None => Ok(entries),
    }
}

fn content<'a>(entries: &'a [Entry], name: &str) -> Result<&'a [u8]> {
    let entry = entries.iter().find(|entry| entry.name == name);
    entry.map(|entry| &*entry.content).with_context(|| format!("{name} is missing in the bundle"))
}

fn text<'a>(entries: &'a [Entry], name: &str) -> Result<&'a str> {
    std::str::from_utf8(content(entries, name)?).with_context(|| format!("{name} is no UTF-8 text"))
}

/// Runs the cases against the recording.
fn judge(entries: &[Entry], setup: &Setup) -> Result<Verified> {
    let told: TestResult =
        results::read(text(entries, RESULT)?).context("result.json is not the result of a bundle")?;
    let transcript: Transcript =
        text(entries, TRANSCRIPT)?.parse().context("transcript.txt is not the transcript of a bundle")?;
    let folder = tempfile::tempdir().context("can't make a temporary folder")?;
    let target = target(entries, setup, folder.path())?;
    let mut replay = Replay::new(records(entries, folder.path())?, transcript);
    let known = |id: &String| catalogue::find(id).with_context(|| format!("there is no case {id} in this version"));
    let cases: Vec<&'static Case> = setup.cases.iter().map(known).collect::<Result<_>>()?;
    let options = &setup.options;
    let plan = Plan { cases: &cases, bus: &setup.bus, bit_rate: replay.bit_rate(), seed: setup.seed, shuffle: None };
    let (cancel, mut annotate) = (AtomicBool::new(false), |_: &Record| String::new());
    let mut found: Vec<(&str, Kind)> = Vec::new();
    let mut bench = Bench::new(&mut replay, &target, options, &mut annotate, &cancel);
    // The verdicts are compared even if the run as a whole judged nothing.
    let _ = run(&mut bench, &plan, &mut |event| {
        if let RunEvent::CaseFinished(report) = event {
            found.push((report.case.id, report.verdict.kind()));
        }
    });
    drop(bench);
    let told: Vec<(&str, Kind)> = told.verdicts().collect();
    let divergence = replay.divergence().map(|divergence| divergence.to_string());
    Ok(Verified { cases: found.len(), differences: differences(&told, &found), divergence })
}

fn differences(told: &[(&str, Kind)], found: &[(&str, Kind)]) -> Vec<Difference> {
    let of = |rows: &[(&str, Kind)], id: &str| rows.iter().find(|row| row.0 == id).map(|row| row.1);
    let mut ids: Vec<&str> = told.iter().chain(found).map(|row| row.0).collect();
    ids.sort_unstable();
    ids.dedup();
    let rows = ids.into_iter().map(|id| Difference { case: id.to_owned(), told: of(told, id), found: of(found, id) });
    rows.filter(|row| row.told != row.found).collect()
}

fn records(entries: &[Entry], folder: &Path) -> Result<Vec<Record>> {
    let path = folder.join(RECORDING);
    std::fs::write(&path, content(entries, RECORDING)?)?;
    let capture = Capture::open(&path, &ReadOptions::default())?;
    capture.map(|record| record.map_err(|damage| anyhow!("{RECORDING} is damaged: {damage}"))).collect()
}

/// The device as the run knew it: from the files in the bundle, never from files of the same name on this machine.
fn target(entries: &[Entry], setup: &Setup, folder: &Path) -> Result<Target> {
    let file = setup.description.as_ref().map(|name| -> Result<PathBuf> {
        let path = folder.join(name);
        std::fs::write(&path, content(entries, name)?)?;
        Ok(path)
    });
    let file = file.transpose()?;
    let node = NodeId::new(setup.node).context("run.json: expected a node-ID from 1 to 127")?;
    let mut target = match (setup.device.as_deref().map(named), setup.bus.parse()) {
        (Some(device), _) => {
            let known = match &file {
                Some(path) => KnownDevice::described(devices::read(path)?),
                None => devices::describe(device)?,
            };
            Target::known(node, device.to_owned(), Some(known))
        }
        (None, Ok(BusAddress::Simulated(mut devices))) => {
            let first = devices.first_mut().context("run.json: expected a device on the simulated bus")?;
            if let (DeviceName::File(name), Some(path)) = (&mut first.device, &file) {
                *name = path.display().to_string();
            }
            let model = first.model()?;
            let (description, manual) = (model.description_with(first.firmware), model.device().manual.clone());
            Target::known(node, model.id().to_owned(), Some(KnownDevice { description, manual }))
        }
        (None, _) => Target::unknown(node),
    };
    if setup.waivers {
        let waivers = Waivers::read(text(entries, WAIVERS)?).context(WAIVERS)?;
        target.deviations = waivers.deviations(&setup.day);
    }
    target.deviations.extend(Model::by_id(&target.model).map(Deviation::of_model).unwrap_or_default());
    Ok(target)
}

impl Verified {
    fn is_good(&self) -> bool {
        self.differences.is_empty() && self.divergence.is_none()
    }

    fn text(&self, bundle: &Path) -> String {
        let bundle = printable(&bundle.display().to_string()).into_owned();
        let mut lines = vec![format!("{bundle}: no byte was changed")];
        for Difference { case, told, found } in &self.differences {
            let name = |kind: &Option<Kind>| kind.map_or("-", Kind::name);
            let case = printable(case);
            lines.push(format!(
                "{case}: expected the verdict {}, which the result has; the recording gives {}",
                name(told),
                name(found)
            ));
        }
        if let Some(divergence) = &self.divergence {
            lines.push(format!("the cases and the recording diverge {}", printable(divergence)));
        }
        let count = self.cases;
        lines.push(match self.is_good() {
            true => format!("all {count} verdicts follow from the recording"),
            false => format!("of {count} verdicts {} do not follow from the recording", self.differences.len()),
        });
        lines.join("\n") + "\n"
    }

    fn json(&self) -> serde_json::Value {
        let row = |difference: &Difference| {
            json!({
                "case": difference.case,
                "result": difference.told.map(Kind::name),
                "recording": difference.found.map(Kind::name),
            })
        };
        json!({
            "schema": "canvass/verify/1",
            "unchanged": true,
            "cases": self.cases,
            "differences": self.differences.iter().map(row).collect::<Vec<_>>(),
            "divergence": self.divergence,
        })
    }
}
