//! The usual questions: views in SQL files, each with an explanation before its statement.

use datafusion::error::Result;
use datafusion::prelude::SessionContext;

/// A view that answers a question.
pub struct View {
    /// The name of the view.
    pub name: &'static str,
    /// The file: comments, and the statement that makes the view.
    pub sql: &'static str,
}

macro_rules! views {
    ($($name:literal)*) => {
        &[$(View { name: $name, sql: include_str!(concat!("../views/", $name, ".sql")) }),*]
    };
}

/// All views.
pub const VIEWS: &[View] = views![
    "heartbeat_losses"
    "emcy_rates"
    "emcy_after_heartbeat_loss"
    "sdo_latencies"
    "sdo_aborts"
    "bus_load"
    "position_drift"
    "position_jumps"
    "flaky_cases"
    "first_bad_release"
];

impl View {
    /// The explanation before the statement, line by line: the first line is the title.
    fn words(&self) -> impl Iterator<Item = &'static str> {
        self.sql.lines().map_while(|line| line.strip_prefix("--")).map(str::trim)
    }

    /// The title of the view.
    pub fn title(&self) -> &'static str {
        self.words().next().unwrap_or(self.name)
    }

    /// The content of the view, and its limits.
    pub fn doc(&self) -> String {
        self.words().skip(1).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
    }
}

/// Registers the views in a session that has the tables.
///
/// # Errors
/// If a table is missing.
pub async fn register(session: &SessionContext) -> Result<()> {
    for view in VIEWS {
        session.sql(view.sql).await?.collect().await?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_view_has_words_and_makes_what_its_file_is_called() {
        for view in VIEWS {
            assert!(!view.title().is_empty() && view.title() != view.name, "{}", view.name);
            assert!(view.doc().len() > 40, "{}", view.name);
            assert!(view.sql.contains(&format!("CREATE VIEW {} AS", view.name)), "{}", view.name);
        }
    }
}
