//! The shell: statements of several lines until a semicolon, and commands that begin with a backslash.

use super::schema;
use super::sql::Answers;
use crate::output::{diagnostic, print, raw};
use crate::status::{Failure, Status};
use canvass_fleet::table::Table;
use rustyline::error::ReadlineError;
use rustyline::history::FileHistory;
use rustyline::{Config, Editor};
use std::path::PathBuf;

const HELP: &str = "\
statements end with a semicolon
\\d         tables
\\d TABLE   the columns of a table
\\?         this help
\\q         leave; so do quit, exit and Ctrl-D";

type Lines = Editor<(), FileHistory>;

/// Answers typed statements and commands until the end of the input.
pub async fn run(answers: Answers) -> Result<Status, Failure> {
    let config = Config::builder().auto_add_history(false).max_history_size(1000)?.build();
    let mut lines: Lines = Editor::with_config(config)?;
    let history = history_file();
    if let Some(file) = &history {
        // The first session has no history file yet.
        let _ = lines.load_history(file);
    }
    print("canvass-fleet: \\? for help, \\q to leave")?;
    while let Some(typed) = read(&mut lines)? {
        let _ = lines.add_history_entry(typed.trim());
        match command(&typed, &answers).await {
            Ok(true) => {}
            Ok(false) => break,
            Err(failure) => diagnostic(&failure.message()),
        }
    }
    if let Some(file) = &history {
        let saved = file.parent().map_or(Ok(()), std::fs::create_dir_all).is_ok() && lines.save_history(file).is_ok();
        if !saved {
            diagnostic(&format!("canvass-fleet: the history can't be written to {}", file.display()));
        }
    }
    Ok(Status::Good)
}

/// Reads the next statement or command; `None` at the end.
fn read(lines: &mut Lines) -> Result<Option<String>, Failure> {
    let mut typed = String::new();
    loop {
        let prompt = if typed.is_empty() { "canvass> " } else { "      -> " };
        match lines.readline(prompt) {
            Ok(line) => {
                if !typed.is_empty() {
                    typed.push('\n');
                }
                typed.push_str(&line);
            }
            // Ctrl-C discards the typed lines.
            Err(ReadlineError::Interrupted) => typed.clear(),
            Err(ReadlineError::Eof) => return Ok(None),
            Err(error) => return Err(error.into()),
        }
        if is_complete(&typed) {
            return Ok(Some(typed));
        }
        if typed.trim().is_empty() {
            typed.clear();
        }
    }
}

/// Whether the typed text is a whole statement or command.
fn is_complete(typed: &str) -> bool {
    let typed = typed.trim();
    typed.starts_with('\\') || typed.ends_with(';') || matches!(typed, "quit" | "exit")
}

/// Executes a typed command; `false` at the end.
async fn command(typed: &str, answers: &Answers) -> Result<bool, Failure> {
    let typed = typed.trim();
    let (word, rest) = typed.split_once(char::is_whitespace).unwrap_or((typed, ""));
    match word.trim_end_matches(';') {
        "\\q" | "quit" | "exit" => return Ok(false),
        "\\?" | "\\h" => print(HELP)?,
        "\\d" if rest.trim().is_empty() => list(answers).await?,
        "\\d" => describe(rest.trim().trim_end_matches(';'), answers).await?,
        other if other.starts_with('\\') => diagnostic(&format!("{other} is no command: \\? shows them")),
        _ => {
            // Ctrl-C ends the statement, not the shell.
            tokio::select! {
                answered = answers.all(typed, || Ok(raw())) => drop(answered?),
                _ = tokio::signal::ctrl_c() => diagnostic("interrupted"),
            }
        }
    }
    Ok(true)
}

async fn list(answers: &Answers) -> Result<(), Failure> {
    let functions: Vec<String> =
        Table::ALL.into_iter().map(|table| format!("  {:10}  {}", table.name(), table.doc())).collect();
    print(&format!("of captures and results, such as events('field/**/*.log'):\n{}", functions.join("\n")))?;
    let tables = "SELECT table_name, table_type FROM information_schema.tables \
                  WHERE table_schema <> 'information_schema' ORDER BY table_name";
    answers.all(tables, || Ok(raw())).await.map(drop)
}

async fn describe(name: &str, answers: &Answers) -> Result<(), Failure> {
    if let (Some(table), false) = (Table::by_name(name), answers.session().table_exist(name)?) {
        return Ok(print(&schema::text(table))?);
    }
    answers.all(&format!("DESCRIBE {name}"), || Ok(raw())).await.map(drop)
}

fn history_file() -> Option<PathBuf> {
    let folder = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let state = folder("XDG_STATE_HOME").or_else(|| Some(folder("HOME")?.join(".local/state")))?;
    Some(state.join("canvass").join("fleet-history"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_end_with_a_semicolon_and_commands_with_their_line() {
        assert!(
            is_complete("SELECT 1;") && is_complete("SELECT\n1 ; ") && is_complete("\\d frames") && is_complete("quit")
        );
        assert!(!is_complete("SELECT 1") && !is_complete(""));
    }
}
