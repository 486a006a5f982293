//! An editor's side of a session with `canvass lsp`, with time measurement.

use anyhow::{Context, Result, bail, ensure};
use lsp_server::{Message, Notification, Request, RequestId};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

const URI: &str = "file:///measured.eds";
/// Number of runs; the best and the median are printed.
const RUNS: usize = 21;

/// A session with one open file.
pub struct Editor {
    server: Child,
    to: Option<ChildStdin>,
    from: BufReader<ChildStdout>,
    requests: i32,
    version: i32,
    /// Time for parsing received messages, which is not the server's.
    understanding: Duration,
    /// Number of findings last published.
    pub findings: usize,
}

impl Editor {
    /// Starts the server and opens the file.
    pub fn start(program: &str, text: &str) -> Result<Self> {
        let mut server = Command::new(program)
            .arg("lsp")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .with_context(|| format!("can't run {program}"))?;
        let from = BufReader::new(server.stdout.take().context("no standard output")?);
        let to = server.stdin.take();
        let mut editor = Self { server, to, from, requests: 0, version: 1, understanding: Duration::ZERO, findings: 0 };
        editor.ask("initialize", json!({ "capabilities": {}, "processId": null, "rootUri": null }))?;
        editor.tell("initialized", json!({}))?;
        let document = json!({ "uri": URI, "languageId": "eds", "version": 1, "text": text });
        editor.tell("textDocument/didOpen", json!({ "textDocument": document }))?;
        editor.published()?;
        Ok(editor)
    }

    /// Runs `run` repeatedly, and prints the time until its answer.
    pub fn measured(&mut self, name: &str, mut run: impl FnMut(&mut Self) -> Result<()>) -> Result<()> {
        let mut times = Vec::with_capacity(RUNS);
        for _ in 0..RUNS {
            self.understanding = Duration::ZERO;
            let began = Instant::now();
            run(self)?;
            times.push(began.elapsed().saturating_sub(self.understanding));
        }
        times.sort();
        let millis = |time: Option<&Duration>| time.map_or(0.0, Duration::as_secs_f64) * 1e3;
        println!("  {name:26} {:>7.1} ms ({:.1} ms)", millis(times.first()), millis(times.get(RUNS / 2)));
        Ok(())
    }

    /// Replaces a line by a text and a number that is new in each call; waits for the findings.
    pub fn change(&mut self, line: usize, text: &str) -> Result<()> {
        self.write(line, &format!("{text} {}", self.version + 1))
    }

    /// Replaces a line by a text; waits for the findings.
    pub fn write(&mut self, line: usize, text: &str) -> Result<()> {
        self.version += 1;
        let text = format!("{text}\n");
        let range = json!({ "start": { "line": line, "character": 0 }, "end": { "line": line + 1, "character": 0 } });
        let document = json!({ "uri": URI, "version": self.version });
        let changes = json!([{ "range": range, "text": text }]);
        self.tell("textDocument/didChange", json!({ "textDocument": document, "contentChanges": changes }))?;
        self.published()
    }

    /// Sends a request about a place, by line and character.
    pub fn ask_at(&mut self, method: &str, (line, character): (usize, usize)) -> Result<()> {
        let at = json!({ "textDocument": { "uri": URI }, "position": { "line": line, "character": character } });
        self.answered(method, at)
    }

    /// Requests all places that mention the object at that place.
    pub fn ask_references(&mut self, (line, character): (usize, usize)) -> Result<()> {
        let position = json!({ "line": line, "character": character });
        let context = json!({ "includeDeclaration": true });
        let asked = json!({ "textDocument": { "uri": URI }, "position": position, "context": context });
        self.answered("textDocument/references", asked)
    }

    /// Requests the code actions for the findings of a line.
    pub fn ask_actions(&mut self, line: usize) -> Result<()> {
        let range = json!({ "start": { "line": line, "character": 0 }, "end": { "line": line, "character": 9 } });
        let context = json!({ "diagnostics": [] });
        let asked = json!({ "textDocument": { "uri": URI }, "range": range, "context": context });
        self.ask("textDocument/codeAction", asked).map(drop)
    }

    /// Requests all sections.
    pub fn ask_outline(&mut self) -> Result<()> {
        self.answered("textDocument/documentSymbol", json!({ "textDocument": { "uri": URI } }))
    }

    /// Ends the session.
    pub fn end(mut self) -> Result<()> {
        self.ask("shutdown", Value::Null)?;
        self.tell("exit", Value::Null)?;
        self.to = None;
        let status = self.server.wait()?;
        ensure!(status.success(), "the server ended with {status}");
        Ok(())
    }

    /// Sends a request and waits for its answer.
    fn answered(&mut self, method: &str, asked: Value) -> Result<()> {
        let answer = self.ask(method, asked)?;
        let is_empty = answer.is_null() || answer.as_array().is_some_and(Vec::is_empty);
        ensure!(!is_empty, "{method} has no answer");
        Ok(())
    }

    fn ask(&mut self, method: &str, params: Value) -> Result<Value> {
        self.requests += 1;
        let id = RequestId::from(self.requests);
        self.send(&Request { id, method: method.to_owned(), params }.into())?;
        match self.read()? {
            Message::Response(response) => match response.response_result {
                Ok(answer) => Ok(answer),
                Err(error) => bail!("{method}: {}", error.message),
            },
            other => bail!("{method} is answered by {other:?}"),
        }
    }

    /// Waits for the findings of the last version.
    fn published(&mut self) -> Result<()> {
        let Message::Notification(said) = self.read()? else { bail!("an answer without a request") };
        let findings = said.params.get("diagnostics").and_then(Value::as_array).map(Vec::len);
        self.findings = findings.with_context(|| format!("{} without findings", said.method))?;
        ensure!(said.params.get("version") == Some(&json!(self.version)), "the findings of another version");
        Ok(())
    }

    fn tell(&mut self, method: &str, params: Value) -> Result<()> {
        self.send(&Notification { method: method.to_owned(), params }.into())
    }

    fn send(&mut self, message: &Message) -> Result<()> {
        Ok(message.write(self.to.as_mut().context("the session has ended")?)?)
    }

    fn read(&mut self) -> Result<Message> {
        let message = self.framed()?;
        let began = Instant::now();
        let read = Message::read(&mut message.as_slice())?.context("an empty message");
        self.understanding += began.elapsed();
        read
    }

    /// The bytes of a message with its header.
    fn framed(&mut self) -> Result<Vec<u8>> {
        let mut header = String::new();
        while !header.ends_with("\r\n\r\n") {
            ensure!(self.from.read_line(&mut header)? > 0, "the server has ended");
        }
        let length = header.lines().find_map(|line| line.strip_prefix("Content-Length: "));
        let length: usize = length.context("a message without its length")?.parse()?;
        let mut message = header.into_bytes();
        let read = self.from.by_ref().take(length as u64).read_to_end(&mut message)?;
        ensure!(read == length, "the server has ended");
        Ok(message)
    }
}
