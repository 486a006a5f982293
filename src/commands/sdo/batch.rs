//! `canvass sdo batch`: reads and writes the objects of a list.

use super::{object, value};
use crate::devices::{self, DeviceArg};
use crate::interrupt::Interrupt;
use crate::live::{ClientArg, Live, parse_span};
use crate::output::{diagnostic, print};
use crate::status::{Failure, Status};
use anyhow::{Context, Result, anyhow, bail};
use canvass_analyzer::dictionary::{DataType, DeviceDescription, KnownDevice, Value};
use canvass_analyzer::{Multiplexer, NodeId, NodeRange};
use canvass_bus::client::sdo::{Bytes, Mode, Outcome, Transfer};
use canvass_bus::client::{Exchange, UploadLimit};
use canvass_reports::escape::Printable;
use canvass_traces::small_file::{self, OF_HAND};
use canvass_traces::{Duration, Record, Timestamp};
use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Read and write the objects of a list, one after the other
///
/// Each line is NODE read OBJECT, or NODE write OBJECT VALUE [TYPE]; r and w, and the form of CiA 309-3 with index and
/// sub-index apart, are read too. # begins a comment. The whole list is checked before the first request. canvass stops
/// at the first refusal. Exit status 1 if one was refused.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  canvass sdo batch can0 setup.txt --device 5=encoder.eds
  echo '5 read 1018:04' | canvass sdo batch can0 -")]
pub struct Args {
    /// The bus: can0, slcan:PORT[@BITRATE], pcan:CHANNEL@BITRATE or sim:MODEL[@BITRATE][+FAULT...]
    bus: String,
    /// The list; - is standard input
    file: PathBuf,
    /// The devices: built-in models, or EDS or DCF files, for names and data types
    #[arg(long, value_name = "NODE=MODEL|FILE")]
    device: Vec<DeviceArg>,
    /// Go on after a refusal
    #[arg(long)]
    keep_going: bool,
    /// How long to wait for each response, such as 500ms
    #[arg(long, default_value = "1s", value_name = "SPAN", value_parser = parse_span)]
    timeout: Duration,
    #[command(flatten)]
    client: ClientArg,
}

/// One line of the list.
#[derive(Clone, PartialEq, Eq, Debug)]
struct Step {
    line: usize,
    node: NodeId,
    at: Multiplexer,
    data_type: Option<DataType>,
    /// The value to write; `None` to read.
    value: Option<Vec<u8>>,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let text = read(&self.file)?;
        let mut descriptions: BTreeMap<NodeId, Arc<KnownDevice>> = BTreeMap::new();
        devices::each(&self.device, |node, known| _ = descriptions.insert(node, Arc::clone(known)))?;
        let mut live = Live::open(&self.bus, None, &self.device, self.client)?;
        if let (Some(node), Some(model)) = (live.simulated_node(), live.model) {
            descriptions.entry(node).or_insert_with(|| Arc::clone(model.device()));
        }
        let steps = steps(&text, &descriptions).with_context(|| self.file.display().to_string())?;
        let status = self.carry_out(&mut live, &steps)?;
        live.report_health();
        Ok(status)
    }

    fn carry_out(&self, live: &mut Live, steps: &[Step]) -> Result<Status, Failure> {
        let interrupt = Interrupt::watch()?;
        let mut exchange = Exchange { bus: live.bus.as_mut(), observe: &mut |_: &Record| {}, ends: Timestamp::MAX };
        let (mut done, mut refused) = (0, 0);
        for step in steps {
            if interrupt.came() || refused > 0 && !self.keep_going {
                break;
            }
            let transfer = match &step.value {
                Some(value) => Transfer::download(step.at, value, Mode::Shortest),
                None => Transfer::upload_within(step.at, UploadLimit::default()),
            };
            let outcome = exchange.transfer(step.node, transfer, self.timeout).map_err(Failure::unreachable)?;
            match &outcome {
                Outcome::Silent => {
                    let (node, at, line) = (step.node, step.at, step.line);
                    return Err(Failure::unreachable(anyhow!("line {line}: node {node} does not answer ({at})")));
                }
                Outcome::Uploaded(_) | Outcome::Downloaded => {
                    done += 1;
                    print(&Printable::document(&format!("{}\n", step.told(&outcome))))?;
                }
                other => {
                    refused += 1;
                    diagnostic(&format!("canvass: line {}: node {}, {}: {other}", step.line, step.node, step.at));
                }
            }
        }
        let left = steps.len() - done - refused;
        diagnostic(&format!("canvass: {done} of {} requests done, {refused} refused, {left} not sent", steps.len()));
        Ok(if refused > 0 || left > 0 { Status::Findings } else { Status::Good })
    }
}

impl Step {
    fn told(&self, outcome: &Outcome) -> String {
        let (node, at) = (self.node, self.at);
        match outcome {
            Outcome::Uploaded(bytes) => {
                let value = self.data_type.and_then(|data_type| Value::decode(data_type, bytes).ok());
                let shown = value.map_or_else(|| Bytes(bytes).to_string(), |value| value.to_string());
                format!("{node} {at} = {shown}")
            }
            _ => format!("{node} {at} = {} written", Bytes(self.value.as_deref().unwrap_or_default())),
        }
    }
}

fn read(path: &Path) -> Result<String> {
    if path.as_os_str() != "-" {
        return small_file::read_text(path, OF_HAND).with_context(|| format!("can't read {}", path.display()));
    }
    let mut text = String::new();
    std::io::stdin().lock().take(OF_HAND).read_to_string(&mut text).context("can't read standard input")?;
    Ok(text)
}

/// Reads the list.
fn steps(text: &str, descriptions: &BTreeMap<NodeId, Arc<KnownDevice>>) -> Result<Vec<Step>> {
    let mut steps = Vec::new();
    for (line, text) in (1..).zip(text.lines()) {
        let words = words(text);
        if !words.is_empty() {
            steps.push(step(line, &words, descriptions).with_context(|| format!("line {line}"))?);
        }
    }
    Ok(steps)
}

/// The words of a line; a text in double quotes is one word. `#` begins a comment.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut is_quoted, mut is_begun) = (Vec::new(), String::new(), false, false);
    for c in line.chars() {
        match c {
            '"' => (is_quoted, is_begun) = (!is_quoted, true),
            '#' if !is_quoted => break,
            c if c.is_whitespace() && !is_quoted => {
                if std::mem::take(&mut is_begun) {
                    words.push(std::mem::take(&mut word));
                }
            }
            c => {
                word.push(c);
                is_begun = true;
            }
        }
    }
    if is_begun {
        words.push(word);
    }
    words
}

fn step(line: usize, words: &[String], descriptions: &BTreeMap<NodeId, Arc<KnownDevice>>) -> Result<Step> {
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let usage = "expected NODE read OBJECT, or NODE write OBJECT VALUE [TYPE]";
    // CiA 309-3 allows a sequence number in brackets.
    let words = match &words[..] {
        [sequence, rest @ ..] if sequence.starts_with('[') && sequence.ends_with(']') => rest,
        all => all,
    };
    let [node, command, object, rest @ ..] = words else { bail!("{usage}, found \"{}\"", words.join(" ")) };
    let node = NodeRange::node(node)?;
    let description = descriptions.get(&node).map(|known| &known.description);
    let (at, rest, of_309) = address(object, rest, description)?;
    let known = value::known_type(at, description);
    match (*command, rest) {
        ("read" | "r", []) => Ok(Step { line, node, at, data_type: known, value: None }),
        ("read" | "r", [data_type]) => {
            Ok(Step { line, node, at, data_type: Some(value::parse_type(data_type)?), value: None })
        }
        // CiA 309-3 has the data type before the value.
        ("write" | "w", [data_type, text]) if of_309 => {
            written(line, node, at, Some(value::parse_type(data_type)?), text)
        }
        ("write" | "w", [text]) => written(line, node, at, known, text),
        ("write" | "w", [text, data_type]) => written(line, node, at, Some(value::parse_type(data_type)?), text),
        _ => bail!("{usage}, found \"{}\"", words.join(" ")),
    }
}

fn written(line: usize, node: NodeId, at: Multiplexer, data_type: Option<DataType>, text: &str) -> Result<Step> {
    let value = value::encode(text, at, data_type)?;
    Ok(Step { line, node, at, data_type, value: Some(value) })
}

/// The object, the words after it, and whether index and sub-index stand apart as in CiA 309-3.
fn address<'w>(
    object: &str,
    rest: &'w [&'w str],
    description: Option<&DeviceDescription>,
) -> Result<(Multiplexer, &'w [&'w str], bool)> {
    let apart = object.strip_prefix("0x").filter(|digits| !digits.contains(':')).zip(rest.split_first());
    if let Some((_, (sub, behind))) = apart
        && let (Some(index), Some(sub)) = (object::hexadecimal(object), number(sub))
    {
        return Ok((Multiplexer::new(index, sub), behind, true));
    }
    Ok((object::resolve(object, description)?, rest, false))
}

/// A sub-index as in CiA 309-3: decimal, or hexadecimal with 0x.
fn number(text: &str) -> Option<u8> {
    match text.strip_prefix("0x") {
        Some(digits) => u8::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<Step>> {
        steps(text, &BTreeMap::new())
    }

    #[test]
    fn lines_in_both_forms() {
        let list = "# set up\n5 write 1017 1000 # ms\n\n5 w 0x1017 0 u16 1000\n[7] 6 r 0x1018 4 u32\n5 write 2000:01 \"a b\" string\n\
            5 read 1018:04\n";
        let steps = read(list).unwrap();
        let told: Vec<(usize, u8, String, Option<Vec<u8>>)> =
            steps.iter().map(|step| (step.line, step.node.raw(), step.at.to_string(), step.value.clone())).collect();
        assert_eq!(
            told,
            [
                (2, 5, "1017h:00".to_owned(), Some(vec![0xE8, 3])),
                (4, 5, "1017h:00".to_owned(), Some(vec![0xE8, 3])),
                (5, 6, "1018h:04".to_owned(), None),
                (6, 5, "2000h:01".to_owned(), Some(b"a b".to_vec())),
                (7, 5, "1018h:04".to_owned(), None),
            ]
        );
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        for (text, says) in [
            ("5 read 1017\n200 read 1017", "line 2: expected a node-ID of 1 to 127"),
            ("5 erase 1017", "line 1: expected NODE read OBJECT"),
            ("5 read", "line 1: expected NODE read OBJECT"),
            ("5 write 2000 1", "line 1: the data type of 2000h:00 is not known"),
            ("5 write 1017 70000", "line 1: "),
            ("5 write 1017 1 u99", "line 1: expected u8 to u64"),
        ] {
            let error = format!("{:#}", read(text).unwrap_err());
            assert!(error.contains(says), "{text}: {error}");
        }
    }
}
