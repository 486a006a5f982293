//! The scripts that pipelines run: one installs the program, the other runs a command with all its reports. The action
//! for GitHub (`action.yml`) and the component for GitLab (`templates/canvass.yml`) stand on both.

use super::{FOLDER, address, filled};
use anyhow::Result;
use std::path::Path;

/// The name of this part of the release.
pub const ID: &str = "pipelines";
/// Where the scripts are.
const SOURCE: &str = "packaging/ci";

/// Both scripts; that which installs knows where this release is, if that is known.
pub fn make() -> Result<Vec<String>> {
    let address = address().unwrap_or_else(|| "@ADDRESS@".to_owned());
    ["install.sh", "run.sh"]
        .into_iter()
        .map(|script| {
            let text = filled(&format!("{SOURCE}/{script}"), &[("ADDRESS", &address)])?;
            std::fs::write(Path::new(FOLDER).join(script), text)?;
            Ok(script.to_owned())
        })
        .collect()
}
