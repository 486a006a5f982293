"use strict";
// The part of Visual Studio Code's API that the extension and its library for language clients use: the calls of the
// editor to them, and their calls to the editor. Positions and ranges are plain objects, files are texts in memory.

class Disposable {
  constructor(dispose) {
    this.dispose = dispose;
  }
  static from(...all) {
    return new Disposable(() => all.forEach((one) => one.dispose()));
  }
}

class EventEmitter {
  listeners = new Set();
  event = (listener, self) => {
    const bound = self ? listener.bind(self) : listener;
    this.listeners.add(bound);
    return new Disposable(() => this.listeners.delete(bound));
  };
  fire(value) {
    for (const listener of [...this.listeners]) listener(value);
  }
  dispose() {
    this.listeners.clear();
  }
}

class CancellationError extends Error {}

class CancellationTokenSource {
  token = { isCancellationRequested: false, onCancellationRequested: () => new Disposable(() => {}) };
  cancel() {}
  dispose() {}
}

class Position {
  constructor(line, character) {
    Object.assign(this, { line, character });
  }
}

class Range {
  constructor(...ends) {
    const [start, end] = ends.length === 4 ? [new Position(ends[0], ends[1]), new Position(ends[2], ends[3])] : ends;
    Object.assign(this, { start, end });
  }
}

class Uri {
  constructor(text) {
    const { protocol, pathname } = new URL(text);
    Object.assign(this, { text, scheme: protocol.slice(0, -1), path: pathname, fsPath: pathname });
  }
  static parse(text) {
    return new Uri(text);
  }
  static file(path) {
    return new Uri(`file://${path}`);
  }
  toString() {
    return this.text;
  }
}

class Diagnostic {
  constructor(range, message, severity) {
    Object.assign(this, { range, message, severity });
  }
}

class MarkdownString {
  constructor(value) {
    this.value = value;
  }
}

class Hover {
  constructor(contents, range) {
    Object.assign(this, { contents: [contents], range });
  }
}

class TextEdit {
  constructor(range, newText) {
    Object.assign(this, { range, newText });
  }
  static replace(range, text) {
    return new TextEdit(range, text);
  }
}

class Kind {
  constructor(value) {
    this.value = value;
  }
  append(more) {
    return new Kind(this.value ? `${this.value}.${more}` : more);
  }
}
const kinds = Object.assign(Kind, { Empty: new Kind(""), QuickFix: new Kind("quickfix") });

// Classes from which the library derives its own or which it distinguishes; their content does not matter here.
const plain = (name) => ({ [name]: class { constructor(...values) { this.values = values; } } })[name];
const PLAIN = [
  "CallHierarchyItem", "CodeAction", "CodeLens", "Color", "CompletionItem", "CompletionList", "DocumentLink",
  "DocumentSymbol", "FoldingRange", "InlayHint", "Location", "SymbolInformation", "TabInputCustom", "TabInputText",
  "TabInputTextDiff", "TypeHierarchyItem", "WorkspaceEdit", "SnippetString",
];

/// The state of the editor: open files, findings, and the features that the extension offers.
class Editor {
  opened = new EventEmitter();
  changed = new EventEmitter();
  closed = new EventEmitter();
  documents = [];
  /// Findings by the file's URI.
  findings = new Map();
  published = new EventEmitter();
  /// Registered providers by feature: `Hover`, `DocumentFormattingEdit`.
  providers = new Map();
  settings = {};
  messages = [];

  open(uri, languageId, text) {
    const lines = text.split("\n");
    const document = { uri: Uri.parse(uri), languageId, version: 1, isClosed: false, lineCount: lines.length, getText: () => text };
    this.documents.push(document);
    this.opened.fire(document);
    return document;
  }

  close(document) {
    document.isClosed = true;
    this.documents = this.documents.filter((other) => other !== document);
    this.closed.fire(document);
  }

  /// The API that `require("vscode")` returns.
  api() {
    const never = new EventEmitter().event;
    const register = (name) => (selector, provider) => {
      this.providers.set(name, { selector, provider });
      return new Disposable(() => this.providers.delete(name));
    };
    const registered = Object.fromEntries(
      [
        "CallHierarchy", "CodeActions", "CodeLens", "Color", "CompletionItem", "Declaration", "Definition",
        "DocumentFormattingEdit", "DocumentHighlight", "DocumentLink", "DocumentRangeFormattingEdit",
        "DocumentSymbol", "FoldingRange", "Hover", "Implementation", "InlayHints", "LinkedEditingRange",
        "OnTypeFormattingEdit", "Reference", "Rename", "SelectionRange", "SignatureHelp", "TypeDefinition",
      ].map((name) => [`register${name}Provider`, register(name)]),
    );
    // A provider for all files of the folder: it has no selector.
    registered.registerWorkspaceSymbolProvider = (provider) => register("WorkspaceSymbol")(undefined, provider);
    const matches = (selector, document) =>
      [selector].flat().some((filter) => (filter.language ?? filter) === document.languageId) ? 10 : 0;
    const say = (text) => {
      this.messages.push(text);
      return Promise.resolve();
    };
    const channel = { append: say, appendLine: say, show() {}, clear() {}, dispose() {} };
    const editor = this;
    return {
      version: "1.85.0",
      ...Object.fromEntries(PLAIN.map((name) => [name, plain(name)])),
      Disposable, EventEmitter, CancellationError, CancellationTokenSource, Position, Range, Uri, Diagnostic,
      MarkdownString, Hover, TextEdit, CodeActionKind: kinds,
      DiagnosticSeverity: { Error: 0, Warning: 1, Information: 2, Hint: 3 },
      DiagnosticTag: { Unnecessary: 1, Deprecated: 2 },
      SymbolKind: { File: 0 }, SymbolTag: { Deprecated: 1 }, CompletionItemKind: { Text: 0 },
      CompletionItemTag: { Deprecated: 1 }, ProgressLocation: { Window: 10 }, FileType: { File: 1, Directory: 2 },
      env: { language: "en", appName: "a stand-in" },
      commands: { registerCommand: () => new Disposable(() => {}) },
      languages: {
        ...registered,
        match: matches,
        createDiagnosticCollection: () => ({
          set: (uri, found) => {
            this.findings.set(uri.toString(), found);
            this.published.fire(uri.toString());
          },
          delete: (uri) => this.findings.delete(uri.toString()),
          clear: () => this.findings.clear(),
          dispose() {},
        }),
      },
      window: {
        createOutputChannel: () => channel,
        showErrorMessage: say, showWarningMessage: say, showInformationMessage: say,
        withProgress: (_, task) => task({ report() {} }, new CancellationTokenSource().token),
        onDidChangeActiveTextEditor: never,
        tabGroups: { all: [], onDidChangeTabs: never },
      },
      workspace: {
        get textDocuments() {
          return editor.documents;
        },
        workspaceFolders: [],
        notebookDocuments: [],
        getConfiguration: (section) => ({ get: (name) => this.settings[`${section}.${name}`] }),
        createFileSystemWatcher: () => ({ onDidCreate: never, onDidChange: never, onDidDelete: never, dispose() {} }),
        onDidOpenTextDocument: this.opened.event,
        onDidChangeTextDocument: this.changed.event,
        onDidCloseTextDocument: this.closed.event,
        onWillSaveTextDocument: never, onDidSaveTextDocument: never, onDidChangeConfiguration: never,
        onDidChangeWorkspaceFolders: never, onDidCreateFiles: never, onDidRenameFiles: never,
        onDidDeleteFiles: never, onWillCreateFiles: never, onWillRenameFiles: never, onWillDeleteFiles: never,
        onDidOpenNotebookDocument: never, onDidCloseNotebookDocument: never, onDidChangeNotebookDocument: never,
        onDidSaveNotebookDocument: never,
      },
    };
  }
}

module.exports = { Editor, Position };
