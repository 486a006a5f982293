//! Workflow commands of GitHub, which show each finding beside its line in a pull request.

use super::{CheckedFile, Located};
use crate::escape::printable;
use canvass_analyzer::dictionary::Severity;

/// The findings in one file that are not waived, one on each line.
pub fn render(file: &CheckedFile) -> String {
    file.open().map(|located| line(file, located)).collect()
}

fn line(file: &CheckedFile, located: &Located) -> String {
    let finding = &located.finding;
    let command = match finding.severity() {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Hint => "notice",
    };
    let name = property(&file.name);
    let rule = property(finding.problem.rule.id);
    let place = match finding.line {
        0 => String::new(),
        line => {
            let (column, end_line, end_column) = (finding.column, located.end_line, located.end_column);
            format!(",line={line},col={column},endLine={end_line},endColumn={end_column}")
        }
    };
    format!("::{command} file={name}{place},title={rule}::{}\n", data(&located.message()))
}

fn data(text: &str) -> String {
    printable(&text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")).into_owned()
}

fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}
