//! The text of `canvass.toml`.
//!
//! ```toml
//! bus = "can0"
//! node = 63
//! device = "my.eds"
//! waivers = "waivers.toml"
//!
//! [timeouts]
//! sdo = "2s"
//!
//! [thresholds]
//! "nodes/heartbeat-late.percent" = 130
//! ```

use super::Setting;
use crate::devices::parse_node;
use crate::timing::Timeout;
use anyhow::{Result, anyhow};
use canvass_analyzer::findings::Thresholds;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    bus: Option<Spanned<String>>,
    node: Option<Spanned<u8>>,
    device: Option<Spanned<String>>,
    waivers: Option<Spanned<String>>,
    #[serde(default)]
    timeouts: BTreeMap<String, Spanned<Scalar>>,
    #[serde(default)]
    thresholds: BTreeMap<String, Spanned<Scalar>>,
}

#[derive(Clone, Deserialize)]
#[serde(untagged)]
enum Scalar {
    Number(u64),
    Text(String),
}

impl Scalar {
    fn text(&self) -> String {
        match self {
            Self::Number(number) => number.to_string(),
            Self::Text(text) => text.clone(),
        }
    }
}

/// Reads the settings in the text of the file.
///
/// # Errors
/// The first error, with path and line.
pub fn read(path: &Path, text: &str) -> Result<Vec<Setting>> {
    let line = |at: usize| 1 + text.bytes().take(at).filter(|&byte| byte == b'\n').count();
    let wrong = |line: usize, problem: &str| anyhow!("{}:{line}: {problem}", path.display());
    let file: File = toml::from_str(text)
        .map_err(|error| wrong(error.span().map_or(1, |span| line(span.start)), error.message()))?;
    let mut settings = Vec::new();
    let mut add = |key: String, value: String, at: usize, problem: Result<()>| -> Result<()> {
        problem.map_err(|problem| wrong(line(at), &format!("{key}: {problem}")))?;
        settings.push(Setting { key, value, line: line(at) });
        Ok(())
    };
    if let Some(bus) = &file.bus {
        add("bus".to_owned(), bus.get_ref().clone(), bus.span().start, Ok(()))?;
    }
    if let Some(node) = &file.node {
        let text = node.get_ref().to_string();
        let known = parse_node(&text).map(drop).map_err(|error| anyhow!("{error}"));
        add("node".to_owned(), text, node.span().start, known)?;
    }
    if let Some(device) = &file.device {
        add("device".to_owned(), beside(path, device.get_ref()), device.span().start, Ok(()))?;
    }
    if let Some(waivers) = &file.waivers {
        let found = folder(path).join(waivers.get_ref()).display().to_string();
        add("waivers".to_owned(), found, waivers.span().start, Ok(()))?;
    }
    for (key, value) in &file.timeouts {
        let text = value.get_ref().text();
        let known = format!("{key}={text}").parse::<Timeout>().map(drop);
        add(format!("timeouts.{key}"), text, value.span().start, known)?;
    }
    for (key, value) in &file.thresholds {
        let text = value.get_ref().text();
        let known = Thresholds::default().set(&format!("{key}={text}")).map_err(Into::into);
        add(format!("thresholds.{key}"), text, value.span().start, known)?;
    }
    Ok(settings)
}

fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// Resolves a device: a model stays as it is, a file's path is relative to the folder of the settings.
fn beside(path: &Path, device: &str) -> String {
    let (node, name) = device.split_once('=').map_or((None, device), |(node, name)| (Some(node), name));
    let file = folder(path).join(name);
    let name = if file.is_file() { file.display().to_string() } else { name.to_owned() };
    node.map_or_else(|| name.clone(), |node| format!("{node}={name}"))
}
