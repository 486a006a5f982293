//! `--select` and `--ignore`: the rules to check.

use anyhow::{Result, bail};
use canvass_analyzer::dictionary::check::Finding;
use canvass_analyzer::dictionary::rules;

/// Options that select rules.
#[derive(clap::Args)]
pub struct Selection {
    /// Check only these rules or families, such as eds/pdo,eds/list/count
    #[arg(long, value_name = "SELECTOR", value_delimiter = ',')]
    select: Vec<String>,
    /// Leave out these rules or families
    #[arg(long, value_name = "RULES", value_delimiter = ',')]
    ignore: Vec<String>,
}

impl Selection {
    /// Refuses unknown rules: a misspelt name would select nothing, and nothing would be found.
    pub fn check(&self) -> Result<()> {
        for id in self.select.iter().chain(&self.ignore) {
            if !rules::all().any(|rule| rule.is_in(id)) {
                bail!("\"{id}\" is no rule and no family of rules: `canvass list eds-rules` lists them");
            }
        }
        Ok(())
    }

    /// Whether only some rules are checked.
    pub const fn is_narrowed(&self) -> bool {
        !self.select.is_empty()
    }

    /// Whether the options select a finding.
    pub fn wants(&self, finding: &Finding) -> bool {
        let is_in = |ids: &[String]| ids.iter().any(|id| finding.problem.rule.is_in(id));
        (self.select.is_empty() || is_in(&self.select)) && !is_in(&self.ignore)
    }
}
