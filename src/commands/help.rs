//! `canvass help`: help of a command or a topic.

use crate::output::print;
use crate::status::{Failure, Status};
use anyhow::anyhow;
use canvass_reports::escape::Printable;

/// Print the help of a command, or of a topic: filter
#[derive(clap::Args)]
pub struct Args {
    /// A command, such as sdo read, or a topic (default: canvass itself)
    what: Vec<String>,
}

/// Topics that concern several commands: name and page.
const TOPICS: [(&str, &str); 1] = [("filter", include_str!("help/filter.txt"))];

impl Args {
    /// Prints the help; `cli` is the whole command line.
    pub fn run(self, mut cli: clap::Command) -> Result<Status, Failure> {
        cli.build();
        if let [topic] = &self.what[..]
            && let Some((_, page)) = TOPICS.iter().find(|(name, _)| name == topic)
        {
            print(&Printable::document(page))?;
            return Ok(Status::Good);
        }
        let mut command = &mut cli;
        for name in &self.what {
            let topics = TOPICS.map(|(name, _)| name).join(", ");
            let what = self.what.join(" ");
            command = command
                .find_subcommand_mut(name)
                .ok_or_else(|| anyhow!("there is no command \"{what}\"; there is also help on: {topics}"))?;
        }
        print(&Printable::document(&command.render_long_help().to_string()))?;
        Ok(Status::Good)
    }
}
