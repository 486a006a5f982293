//! A session with an editor: requests are answered, changes followed, findings published.

use super::answers::Answers;
use super::document::{Document, Units};
use anyhow::Result;
use canvass_reports::provenance::VERSION;
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, Response};
use lsp_types::notification::{
    DidChangeTextDocument, DidCloseTextDocument, DidOpenTextDocument, Notification as _, PublishDiagnostics,
};
use lsp_types::{
    CodeActionKind, CodeActionOptions, CodeActionProviderCapability, CompletionOptions, DidChangeTextDocumentParams,
    DidCloseTextDocumentParams, DidOpenTextDocumentParams, HoverProviderCapability, InitializeParams, OneOf,
    PublishDiagnosticsParams, ServerCapabilities, TextDocumentSyncCapability, TextDocumentSyncKind, Uri,
};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::collections::HashMap;

/// The open files of an editor.
pub struct Session {
    documents: HashMap<Uri, Document>,
    units: Units,
    /// Files that have changed since their findings were published.
    changed: Vec<Uri>,
}

impl Session {
    pub fn new(asked: InitializeParams) -> Self {
        let offered = asked.capabilities.general.and_then(|general| general.position_encodings);
        Self { documents: HashMap::new(), units: Units::agreed(offered.as_deref()), changed: Vec::new() }
    }

    /// What the editor may ask for.
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
            code_action_provider: Some(CodeActionProviderCapability::Options(CodeActionOptions {
                code_action_kinds: Some(vec![CodeActionKind::QUICKFIX, CodeActionKind::SOURCE_FIX_ALL]),
                ..CodeActionOptions::default()
            })),
            ..ServerCapabilities::default()
        };
        json!({ "capabilities": capabilities, "serverInfo": { "name": "canvass", "version": VERSION } })
    }

    /// Serves until the editor says that it is over, or is gone.
    pub fn serve(&mut self, connection: &Connection) -> Result<()> {
        for message in &connection.receiver {
            match message {
                Message::Request(request) => {
                    if connection.handle_shutdown(&request)? {
                        return Ok(());
                    }
                    connection.sender.send(self.answer(request).into())?;
                }
                Message::Notification(notification) => {
                    for uri in self.follow(notification) {
                        // What is closed has no findings any more.
                        connection.sender.send(published(uri, Vec::new(), None)?)?;
                    }
                }
                Message::Response(_) => {}
            }
            // While the editor has more to say, what it says next would make the findings old.
            if connection.receiver.is_empty() {
                self.publish(connection)?;
            }
        }
        Ok(())
    }

    fn publish(&mut self, connection: &Connection) -> Result<()> {
        for uri in std::mem::take(&mut self.changed) {
            let Some(document) = self.documents.get(&uri) else { continue };
            let findings = Answers { uri: &uri, document, units: self.units }.findings();
            connection.sender.send(published(uri.clone(), findings, Some(document.version))?)?;
        }
        Ok(())
    }

    /// Takes over what has become of the files; those that were closed.
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

    fn answer(&self, asked: Request) -> Response {
        let Request { id, method, params } = asked;
        let uri = params.pointer("/textDocument/uri").cloned().and_then(read::<Uri>);
        let Some((uri, document)) = uri.and_then(|uri| Some((uri.clone(), self.documents.get(&uri)?))) else {
            let error = "no open file of that name is known".to_owned();
            return Response::new_err(id, ErrorCode::InvalidParams as i32, error);
        };
        match (Answers { uri: &uri, document, units: self.units }.to(&method, params)) {
            Some(Ok(answer)) => Response::new_ok(id, answer),
            Some(Err(error)) => Response::new_err(id, ErrorCode::InvalidParams as i32, error.to_string()),
            None => Response::new_err(id, ErrorCode::MethodNotFound as i32, format!("{method} is not served")),
        }
    }
}

fn published(uri: Uri, diagnostics: Vec<lsp_types::Diagnostic>, version: Option<i32>) -> Result<Message> {
    let params = serde_json::to_value(PublishDiagnosticsParams { uri, diagnostics, version })?;
    Ok(Notification { method: PublishDiagnostics::METHOD.to_owned(), params }.into())
}

/// What an editor says that is not as the protocol has it is passed over.
fn read<T: DeserializeOwned>(value: Value) -> Option<T> {
    serde_json::from_value(value).ok()
}
