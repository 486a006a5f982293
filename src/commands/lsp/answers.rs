//! Answers to requests about one file.

use super::document::{Document, Units};
use crate::commands::eds::found::Beside;
use canvass_analyzer::dictionary::Severity;
use canvass_analyzer::dictionary::check::{Checked, Finding, Folder, apply_fixes, check_source};
use canvass_analyzer::dictionary::editor::{self, Symbol};
use canvass_analyzer::dictionary::source::Source;
use lsp_types::request::{
    CodeActionRequest, CodeActionResolveRequest, Completion, DocumentSymbolRequest, FoldingRangeRequest, Formatting,
    GotoDefinition, HoverRequest, PrepareRenameRequest, References, Rename, Request as _,
};
use lsp_types::{
    CodeAction, CodeActionKind, CodeActionParams, CompletionItem, CompletionItemKind, CompletionParams,
    CompletionTextEdit, Diagnostic, DiagnosticSeverity, DocumentSymbol, Documentation, FoldingRange,
    GotoDefinitionParams, Hover, HoverContents, HoverParams, Location, MarkupContent, MarkupKind, NumberOrString,
    OneOf, Position, ReferenceParams, RenameParams, SymbolKind, TextDocumentPositionParams, TextEdit, Uri,
    WorkspaceEdit, WorkspaceSymbol,
};
use serde::de::DeserializeOwned;
use serde_json::{Value, json, to_string};
use std::collections::HashMap;
use std::path::PathBuf;

/// An open file, and the unit of positions in it.
pub struct Answers<'a> {
    pub uri: &'a Uri,
    pub document: &'a Document,
    pub units: Units,
    /// Whether the editor fetches the edits of a code action only when the user chooses it.
    pub resolves: bool,
}

/// The JSON text of an answer. It is written directly: building a tree of values would take longer than everything
/// else.
pub type Answer = Result<String, serde_json::Error>;

impl Answers<'_> {
    /// The answer to a request about the file; `None` if the method is not supported.
    pub fn to(&self, method: &str, params: Value) -> Option<Answer> {
        Some(match method {
            HoverRequest::METHOD => {
                answer(params, |asked: HoverParams| self.hover(asked.text_document_position_params.position))
            }
            Completion::METHOD => {
                answer(params, |asked: CompletionParams| self.completion(asked.text_document_position.position))
            }
            GotoDefinition::METHOD => answer(params, |asked: GotoDefinitionParams| {
                let at = self.at(asked.text_document_position_params.position);
                to_string(&editor::definition(self.source(), at).map(|range| self.location(&range)))
            }),
            References::METHOD => answer(params, |asked: ReferenceParams| {
                let at = self.at(asked.text_document_position.position);
                let found = editor::references(self.source(), at);
                to_string(&found.iter().map(|range| self.location(range)).collect::<Vec<_>>())
            }),
            DocumentSymbolRequest::METHOD => to_string(
                &editor::outline(self.source()).into_iter().map(|symbol| self.symbol(symbol)).collect::<Vec<_>>(),
            ),
            CodeActionRequest::METHOD => answer(params, |asked: CodeActionParams| self.actions(&asked)),
            CodeActionResolveRequest::METHOD => answer(params, |offered: CodeAction| self.resolved(offered)),
            Formatting::METHOD => to_string(&self.fixed()),
            FoldingRangeRequest::METHOD => to_string(&self.folds()),
            PrepareRenameRequest::METHOD => answer(params, |asked: TextDocumentPositionParams| {
                let digits = editor::index_at(self.source(), self.at(asked.position));
                to_string(&digits.map(|range| self.document.range(&range, self.units)))
            }),
            Rename::METHOD => answer(params, |asked: RenameParams| self.renamed(&asked)),
            _ => return None,
        })
    }

    /// The symbols whose name or description has this text in it.
    pub fn symbols(&self, query: &str) -> Vec<WorkspaceSymbol> {
        let query = query.to_lowercase();
        let all = editor::outline(self.source()).into_iter().flat_map(|mut symbol| {
            let entries = std::mem::take(&mut symbol.entries);
            std::iter::once(symbol).chain(entries)
        });
        let named = all.map(|symbol| {
            let name = format!("{} {}", symbol.name, symbol.detail).trim_end().to_owned();
            (name, symbol)
        });
        named
            .filter(|(name, _)| name.to_lowercase().contains(&query))
            .map(|(name, symbol)| WorkspaceSymbol {
                name,
                kind: kind_of(&symbol),
                tags: None,
                container_name: None,
                location: OneOf::Left(self.location(&symbol.selected)),
                data: None,
            })
            .collect()
    }

    /// Sections can be folded, and an object with its entries.
    fn folds(&self) -> Vec<FoldingRange> {
        let fold = |symbol: &Symbol| {
            let range = self.document.range(&symbol.whole, self.units);
            FoldingRange { start_line: range.start.line, end_line: range.end.line, ..FoldingRange::default() }
        };
        let all = editor::outline(self.source());
        let nested = all.iter().flat_map(|symbol| std::iter::once(symbol).chain(&symbol.entries));
        nested.map(fold).filter(|fold| fold.end_line > fold.start_line).collect()
    }

    /// The edits that give an object another index: four hexadecimal digits, as `2018`, `0x2018` or `2018h`.
    fn renamed(&self, asked: &RenameParams) -> Answer {
        let new = asked.new_name.trim();
        let digits = new.strip_prefix("0x").or_else(|| new.strip_suffix('h')).unwrap_or(new);
        let wrong = |text: String| <serde_json::Error as serde::de::Error>::custom(text);
        let index = u16::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 4);
        let index = index.ok_or_else(|| wrong(format!("expected an index such as 2018, found \"{new}\"")))?;
        let at = self.at(asked.text_document_position.position);
        let edits = editor::rename(self.source(), at, index);
        let edits = edits.ok_or_else(|| {
            wrong(format!(
                "expected the index of an object, and one that the file does not have yet, found {index:04X}h"
            ))
        })?;
        let edit = |(range, new_text)| TextEdit { range: self.document.range(&range, self.units), new_text };
        to_string(&self.workspace_edit(edits.into_iter().map(edit).collect()))
    }

    fn text(&self) -> &str {
        &self.document.text
    }

    fn at(&self, position: Position) -> usize {
        self.document.offset(position, self.units)
    }

    fn location(&self, range: &std::ops::Range<usize>) -> Location {
        Location::new(self.uri.clone(), self.document.range(range, self.units))
    }

    /// All findings that no comment in the file waives.
    pub fn findings(&self) -> Vec<Diagnostic> {
        self.open().map(|finding| self.diagnostic(finding)).collect()
    }

    /// The findings that no comment in the file waives.
    fn open(&self) -> impl Iterator<Item = &Finding> {
        self.checked().open()
    }

    fn checked(&self) -> &Checked<'static> {
        self.document.checked(|source| self.check(source))
    }

    fn source(&self) -> &Source<'static> {
        &self.checked().source
    }

    fn check(&self, source: Source<'static>) -> Checked<'static> {
        let path = self.path();
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        let folder = path.parent().filter(|folder| folder.is_dir()).map(|folder| Beside(folder.to_owned()));
        let beside = folder.as_ref().map(|folder| folder as &dyn Folder);
        check_source(source, name.as_deref(), beside)
    }

    /// The path of the file; empty if its URI is not a file's.
    fn path(&self) -> PathBuf {
        let path = self.uri.path().as_estr().decode().into_string_lossy().into_owned();
        // On Windows a drive letter follows the first slash.
        let drive = path.strip_prefix('/').filter(|rest| rest.as_bytes().get(1) == Some(&b':'));
        PathBuf::from(drive.unwrap_or(&path))
    }

    fn diagnostic(&self, finding: &Finding) -> Diagnostic {
        let problem = &finding.problem;
        let rule = problem.rule;
        let severity = match finding.severity() {
            Severity::Error => DiagnosticSeverity::ERROR,
            Severity::Warning => DiagnosticSeverity::WARNING,
            Severity::Hint => DiagnosticSeverity::HINT,
        };
        Diagnostic {
            range: self.document.range(&finding.span, self.units),
            severity: Some(severity),
            code: Some(NumberOrString::String(rule.id.to_owned())),
            source: Some("canvass".to_owned()),
            message: format!(
                "{}: expected {}, found \"{}\"",
                rule.title(),
                problem.expected,
                problem.found.escape_debug()
            ),
            ..Diagnostic::default()
        }
    }

    fn hover(&self, position: Position) -> Answer {
        let shown = editor::hover(self.source(), self.at(position));
        to_string(&shown.map(|hover| Hover {
            contents: HoverContents::Markup(MarkupContent { kind: MarkupKind::Markdown, value: hover.text }),
            range: Some(self.document.range(&hover.range, self.units)),
        }))
    }

    fn completion(&self, position: Position) -> Answer {
        let found = editor::complete(self.source(), self.at(position));
        let item = |(order, found): (usize, editor::Completion)| CompletionItem {
            label: found.label.clone(),
            kind: Some(CompletionItemKind::FIELD),
            documentation: Some(Documentation::String(found.detail))
                .filter(|text| *text != Documentation::String(String::new())),
            // The editor keeps this order instead of sorting by name.
            sort_text: Some(format!("{order:04}")),
            filter_text: Some(found.label),
            text_edit: Some(CompletionTextEdit::Edit(TextEdit {
                range: self.document.range(&found.range, self.units),
                new_text: found.text,
            })),
            ..CompletionItem::default()
        };
        to_string(&found.into_iter().enumerate().map(item).collect::<Vec<_>>())
    }

    #[expect(deprecated, reason = "the type has a deprecated member that is left unset")]
    fn symbol(&self, symbol: Symbol) -> DocumentSymbol {
        DocumentSymbol {
            kind: kind_of(&symbol),
            name: symbol.name,
            detail: Some(symbol.detail),
            tags: None,
            deprecated: None,
            range: self.document.range(&symbol.whole, self.units),
            selection_range: self.document.range(&symbol.selected, self.units),
            children: Some(symbol.entries.into_iter().map(|entry| self.symbol(entry)).collect()),
        }
    }

    /// The fixes of the findings at a place, and the action that fixes everything.
    fn actions(&self, asked: &CodeActionParams) -> Answer {
        let wanted = |kind: &CodeActionKind| {
            let asked = asked.context.only.as_ref();
            asked.is_none_or(|only| only.iter().any(|only| kind.as_str().starts_with(only.as_str())))
        };
        let (from, to) = (self.at(asked.range.start), self.at(asked.range.end));
        let mut actions = Vec::new();
        let here = |finding: &&Finding| finding.span.start <= to && from <= finding.span.end && finding.line > 0;
        for finding in self.open().filter(here).filter(|_| wanted(&CodeActionKind::QUICKFIX)) {
            let Some(fix) = finding.fix.as_ref().filter(|fix| !fix.edits.is_empty()) else { continue };
            let edit = |edit: &canvass_analyzer::dictionary::check::Edit| TextEdit {
                range: self.document.range(&edit.range, self.units),
                new_text: edit.text.clone(),
            };
            let diagnostics = Some(vec![self.diagnostic(finding)]);
            let edits = fix.edits.iter().map(edit).collect();
            actions.push(self.action(fix.title.clone(), CodeActionKind::QUICKFIX, edits, diagnostics));
        }
        if wanted(&CodeActionKind::SOURCE_FIX_ALL) {
            actions.extend(self.all_at_once());
        }
        to_string(&actions)
    }

    /// The action that fixes everything. Computing its edits takes several checks, and editors ask for actions at
    /// every move of the cursor; so editors that can do it fetch the edits later.
    fn all_at_once(&self) -> Option<CodeAction> {
        self.open().find(|finding| finding.fix.as_ref().is_some_and(|fix| !fix.edits.is_empty()))?;
        let (title, kind) = ("fix all that needs no guessing".to_owned(), CodeActionKind::SOURCE_FIX_ALL);
        if self.resolves {
            let data = Some(json!({ "uri": self.uri }));
            return Some(CodeAction { title, kind: Some(kind), data, ..CodeAction::default() });
        }
        let edits = self.fixed();
        (!edits.is_empty()).then(|| self.action(title, kind, edits, None))
    }

    /// The edits of a code action that was offered without edits.
    fn resolved(&self, offered: CodeAction) -> Answer {
        let all = self.action(offered.title.clone(), CodeActionKind::SOURCE_FIX_ALL, self.fixed(), None);
        to_string(&CodeAction { edit: all.edit, ..offered })
    }

    #[expect(
        clippy::mutable_key_type,
        reason = "lsp_types prescribes this map; its keys do not change while it is in use"
    )]
    fn workspace_edit(&self, edits: Vec<TextEdit>) -> WorkspaceEdit {
        let changes = HashMap::from([(self.uri.clone(), edits)]);
        WorkspaceEdit { changes: Some(changes), ..WorkspaceEdit::default() }
    }

    fn action(
        &self,
        title: String,
        kind: CodeActionKind,
        edits: Vec<TextEdit>,
        diagnostics: Option<Vec<Diagnostic>>,
    ) -> CodeAction {
        CodeAction {
            title,
            kind: Some(kind),
            diagnostics,
            edit: Some(self.workspace_edit(edits)),
            ..CodeAction::default()
        }
    }

    /// The edits that apply every fix without guessing; empty if there are none.
    fn fixed(&self) -> Vec<TextEdit> {
        let fixed =
            apply_fixes(self.text().as_bytes(), |_| true).ok().and_then(|fixed| String::from_utf8(fixed.bytes).ok());
        let Some(fixed) = fixed.filter(|fixed| fixed != self.text()) else { return Vec::new() };
        let (from, old, new) = changed(self.text(), &fixed);
        vec![TextEdit { range: self.document.range(&(from..from + old), self.units), new_text: new.to_owned() }]
    }
}

fn kind_of(symbol: &Symbol) -> SymbolKind {
    if symbol.is_object { SymbolKind::OBJECT } else { SymbolKind::NAMESPACE }
}

/// The first differing byte of two texts, and the differing part of each.
fn changed<'a>(old: &str, new: &'a str) -> (usize, usize, &'a str) {
    let same = |(a, b): &(char, char)| a == b;
    let start: usize = old.chars().zip(new.chars()).take_while(same).map(|(character, _)| character.len_utf8()).sum();
    let (old, new) = (old.get(start..).unwrap_or_default(), new.get(start..).unwrap_or_default());
    let backwards = old.chars().rev().zip(new.chars().rev()).take_while(same);
    let end: usize = backwards.map(|(character, _)| character.len_utf8()).sum();
    (start, old.len() - end, new.get(..new.len() - end).unwrap_or_default())
}

fn answer<T: DeserializeOwned>(params: Value, of: impl FnOnce(T) -> Answer) -> Answer {
    serde_json::from_value(params).and_then(of)
}
