//! `--select` and `--ignore`: which rules count.

use anyhow::{Result, bail};
use canvass_analyzer::dictionary::check::Finding;
use canvass_analyzer::dictionary::rules;

/// Which rules count
#[derive(clap::Args)]
pub struct Selection {
    /// Look only for these rules or families, such as eds/pdo,eds/list/count
    #[arg(long, value_name = "SELECTOR", value_delimiter = ',')]
    select: Vec<String>,
    /// Don't look for these rules or families
    #[arg(long, value_name = "RULES", value_delimiter = ',')]
    ignore: Vec<String>,
}

impl Selection {
    /// Refuses what names no rule: a slip would select nothing.
    pub fn check(&self) -> Result<()> {
        for id in self.select.iter().chain(&self.ignore) {
            if !rules::all().any(|rule| rule.is_in(id)) {
                bail!("\"{id}\" is no rule and no family of rules: `canvass list eds-rules` shows what there is");
            }
        }
        Ok(())
    }

    /// Whether a finding counts.
    pub fn wants(&self, finding: &Finding) -> bool {
        let is_in = |ids: &[String]| ids.iter().any(|id| finding.problem.rule.is_in(id));
        (self.select.is_empty() || is_in(&self.select)) && !is_in(&self.ignore)
    }
}
