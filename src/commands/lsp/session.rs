//! A session with an editor: answers requests, follows changes, publishes findings.

use super::answers::Answers;
use super::document::{Document, Units};
use anyhow::Result;
use canvass_reports::provenance::VERSION;
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, RequestId};
use lsp_types::notification::{
    DidChangeTextDocument, DidCloseTextDocument, DidOpenTextDocument, Notification as _, PublishDiagnostics,
};
use lsp_types::request::{Request as _, WorkspaceSymbolRequest};
use lsp_types::{
    ClientCapabilities, CodeActionKind, CodeActionOptions, CodeActionProviderCapability, CompletionOptions,
    DidChangeTextDocumentParams, DidCloseTextDocumentParams, DidOpenTextDocumentParams, FoldingRangeProviderCapability,
    HoverProviderCapability, InitializeParams, OneOf, PublishDiagnosticsParams, RenameOptions, ServerCapabilities,
    TextDocumentSyncCapability, TextDocumentSyncKind, Uri, WorkDoneProgressOptions,
};
use serde::de::DeserializeOwned;
use serde_json::{Value, json, to_string};
use std::collections::HashMap;
use std::io::{self, Write};

/// The open files of an editor.
pub struct Session {
    documents: HashMap<Uri, Document>,
    units: Units,
    /// Whether the editor fetches the edits of a code action only when the user chooses it.
    resolves: bool,
    /// Files that have changed since their findings were published.
    changed: Vec<Uri>,
}

impl Session {
    pub fn new(asked: InitializeParams) -> Self {
        let resolves = resolves(&asked.capabilities);
        let offered = asked.capabilities.general.and_then(|general| general.position_encodings);
        Self { documents: HashMap::new(), units: Units::agreed(offered.as_deref()), resolves, changed: Vec::new() }
    }

    /// The capabilities that the server announces.
    pub fn capabilities(&self) -> Value {
        let capabilities = ServerCapabilities {
            position_encoding: Some(self.units.kind()),
            text_document_sync: Some(TextDocumentSyncCapability::Kind(TextDocumentSyncKind::INCREMENTAL)),
            hover_provider: Some(HoverProviderCapability::Simple(true)),
            completion_provider: Some(CompletionOptions {
                trigger_characters: Some(vec!["[".to_owned(), "=".to_owned()]),
                ..CompletionOptions::default()
            }),
            definition_provider: Some(OneOf::Left(true)),
            references_provider: Some(OneOf::Left(true)),
            document_symbol_provider: Some(OneOf::Left(true)),
            document_formatting_provider: Some(OneOf::Left(true)),
            folding_range_provider: Some(FoldingRangeProviderCapability::Simple(true)),
            rename_provider: Some(OneOf::Right(RenameOptions {
                prepare_provider: Some(true),
                work_done_progress_options: WorkDoneProgressOptions::default(),
            })),
            workspace_symbol_provider: Some(OneOf::Left(true)),
            code_action_provider: Some(CodeActionProviderCapability::Options(CodeActionOptions {
                code_action_kinds: Some(vec![CodeActionKind::QUICKFIX, CodeActionKind::SOURCE_FIX_ALL]),
                resolve_provider: Some(true),
                ..CodeActionOptions::default()
            })),
            ..ServerCapabilities::default()
        };
        json!({ "capabilities": capabilities, "serverInfo": { "name": "canvass", "version": VERSION } })
    }

    /// Serves requests until the editor ends the session or disconnects.
    pub fn serve(&mut self, connection: &Connection, editor: &mut impl Write) -> Result<()> {
        while let Ok(message) = connection.receiver.recv() {
            let mut next = Some(message);
            // While more messages wait, findings would be outdated at once; so they are published after the last
            // message.
            while let Some(message) = next {
                if self.take(connection, message, editor)? {
                    return Ok(());
                }
                next = connection.receiver.try_recv().ok();
            }
            self.publish(editor)?;
        }
        Ok(())
    }

    /// Handles a message; returns whether the session is over.
    fn take(&mut self, connection: &Connection, message: Message, editor: &mut impl Write) -> Result<bool> {
        match message {
            Message::Request(request) => {
                if connection.handle_shutdown(&request)? {
                    return Ok(true);
                }
                write(editor, &self.answer(request)?)?;
            }
            Message::Notification(notification) => {
                for uri in self.follow(notification) {
                    // An empty list removes the findings of a closed file from the editor.
                    write(editor, &published(uri, Vec::new(), None)?)?;
                }
            }
            Message::Response(_) => {}
        }
        Ok(false)
    }

    fn publish(&mut self, editor: &mut impl Write) -> Result<()> {
        for uri in std::mem::take(&mut self.changed) {
            let Some(document) = self.documents.get(&uri) else { continue };
            let findings = self.answers(&uri, document).findings();
            write(editor, &published(uri.clone(), findings, Some(document.version))?)?;
        }
        Ok(())
    }

    /// Applies notifications of opened, changed and closed files; returns the closed files.
    fn follow(&mut self, said: Notification) -> Vec<Uri> {
        match said.method.as_str() {
            DidOpenTextDocument::METHOD => {
                if let Some(DidOpenTextDocumentParams { text_document: opened }) = read(said.params) {
                    self.documents.insert(opened.uri.clone(), Document::new(opened.text, opened.version));
                    self.changed.push(opened.uri);
                }
            }
            DidChangeTextDocument::METHOD => {
                let read: Option<DidChangeTextDocumentParams> = read(said.params);
                if let Some(DidChangeTextDocumentParams { text_document: changed, content_changes }) = read
                    && let Some(document) = self.documents.get_mut(&changed.uri)
                {
                    document.change(content_changes, changed.version, self.units);
                    if !self.changed.contains(&changed.uri) {
                        self.changed.push(changed.uri);
                    }
                }
            }
            DidCloseTextDocument::METHOD => {
                if let Some(DidCloseTextDocumentParams { text_document: closed }) = read(said.params) {
                    self.documents.remove(&closed.uri);
                    return vec![closed.uri];
                }
            }
            _ => {}
        }
        Vec::new()
    }

    fn answers<'a>(&self, uri: &'a Uri, document: &'a Document) -> Answers<'a> {
        Answers { uri, document, units: self.units, resolves: self.resolves }
    }

    /// The message that answers a request.
    fn answer(&self, asked: Request) -> serde_json::Result<String> {
        let Request { id, method, params } = asked;
        // A request to resolve an action carries the file's URI in the action's data.
        let named = params.pointer("/textDocument/uri").or_else(|| params.pointer("/data/uri"));
        if method == WorkspaceSymbolRequest::METHOD {
            let query = params.get("query").and_then(Value::as_str).unwrap_or_default();
            let found: Vec<_> =
                self.documents.iter().flat_map(|(uri, document)| self.answers(uri, document).symbols(query)).collect();
            return to_string(&json!({ "jsonrpc": "2.0", "id": id, "result": found }));
        }
        if named.is_none() {
            // All other requests that are supported name a file.
            return refused(&id, ErrorCode::MethodNotFound, &format!("{method} is not supported"));
        }
        let uri = named.cloned().and_then(read::<Uri>);
        let Some((uri, document)) = uri.and_then(|uri| Some((uri.clone(), self.documents.get(&uri)?))) else {
            return refused(&id, ErrorCode::InvalidParams, "no open file has this name");
        };
        match self.answers(&uri, document).to(&method, params) {
            Some(Ok(answer)) => Ok(format!(r#"{{"jsonrpc":"2.0","id":{},"result":{answer}}}"#, to_string(&id)?)),
            Some(Err(error)) => refused(&id, ErrorCode::InvalidParams, &error.to_string()),
            None => refused(&id, ErrorCode::MethodNotFound, &format!("{method} is not supported")),
        }
    }
}

fn refused(id: &RequestId, code: ErrorCode, message: &str) -> serde_json::Result<String> {
    to_string(&json!({ "jsonrpc": "2.0", "id": id, "error": { "code": code as i32, "message": message } }))
}

/// Writes a message with the protocol's header.
fn write(editor: &mut impl Write, message: &str) -> io::Result<()> {
    write!(editor, "Content-Length: {}\r\n\r\n", message.len())?;
    editor.write_all(message.as_bytes())?;
    editor.flush()
}

/// Whether the editor can fetch the edits of an action later and keeps the action's data until then.
fn resolves(capabilities: &ClientCapabilities) -> bool {
    let actions = capabilities.text_document.as_ref().and_then(|of| of.code_action.as_ref());
    actions.is_some_and(|actions| {
        let resolved = actions.resolve_support.as_ref().map_or(&[][..], |support| &support.properties);
        actions.data_support == Some(true) && resolved.iter().any(|property| property == "edit")
    })
}

/// The message that publishes the findings of a file.
fn published(uri: Uri, diagnostics: Vec<lsp_types::Diagnostic>, version: Option<i32>) -> serde_json::Result<String> {
    let params = to_string(&PublishDiagnosticsParams { uri, diagnostics, version })?;
    Ok(format!(r#"{{"jsonrpc":"2.0","method":"{}","params":{params}}}"#, PublishDiagnostics::METHOD))
}

/// Parses parameters; a notification with wrong parameters is ignored.
fn read<T: DeserializeOwned>(value: Value) -> Option<T> {
    serde_json::from_value(value).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    /// An editor that takes each message as soon as it is whole.
    struct Editor {
        begun: Vec<u8>,
        messages: mpsc::Sender<Message>,
    }

    impl Write for Editor {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.begun.extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            let message = Message::read(&mut std::mem::take(&mut self.begun).as_slice())?.unwrap();
            self.messages.send(message).map_err(io::Error::other)
        }
    }

    fn notification(method: &str, params: Value) -> Message {
        Notification { method: method.to_owned(), params }.into()
    }

    #[test]
    fn changes_that_wait_are_checked_once() {
        let (ours, theirs) = Connection::memory();
        let document = json!({ "uri": "file:///a.eds", "languageId": "eds", "version": 1, "text": "" });
        theirs.sender.send(notification("textDocument/didOpen", json!({ "textDocument": document }))).unwrap();
        for version in 2..=20 {
            let document = json!({ "uri": "file:///a.eds", "version": version });
            let changes = json!([{ "text": format!("[FileInfo]\nFileVersion={version}\n") }]);
            let change = json!({ "textDocument": document, "contentChanges": changes });
            theirs.sender.send(notification("textDocument/didChange", change)).unwrap();
        }
        let (sender, messages) = mpsc::channel();
        let serving = std::thread::spawn(move || {
            let mut session = Session::new(InitializeParams::default());
            session.serve(&ours, &mut Editor { begun: Vec::new(), messages: sender }).map_err(|error| error.to_string())
        });
        let Message::Notification(said) = messages.recv().unwrap() else { panic!("no findings") };
        assert_eq!(said.params["version"], 20);
        theirs.sender.send(Request::new(RequestId::from(1), "shutdown".to_owned(), Value::Null).into()).unwrap();
        assert!(matches!(theirs.receiver.recv().unwrap(), Message::Response(_)));
        theirs.sender.send(notification("exit", Value::Null)).unwrap();
        serving.join().unwrap().unwrap();
        assert!(messages.try_recv().is_err(), "findings of older versions");
    }
}
