// A stand-in for the module `vscode`, as far as the extension uses it: values, and registries that a test looks into.
"use strict";

const { fileURLToPath, pathToFileURL } = require("node:url");

class Position {
  constructor(line, character) {
    Object.assign(this, { line, character });
  }
  with(change) {
    return new Position(change.line ?? this.line, change.character ?? this.character);
  }
}

class Range {
  constructor(...at) {
    const [start, end] = at.length === 4 ? [new Position(at[0], at[1]), new Position(at[2], at[3])] : at;
    Object.assign(this, { start, end });
  }
}

class Uri {
  constructor(text) {
    this._text = text;
    this.scheme = text.slice(0, text.indexOf(":"));
  }
  static file(path) {
    return new Uri(pathToFileURL(path).href);
  }
  get fsPath() {
    return fileURLToPath(this._text);
  }
  toString() {
    return this._text;
  }
}

class Emitter {
  constructor() {
    this._heard = [];
    this.event = (listener) => {
      this._heard.push(listener);
      return { dispose: () => this._heard.splice(this._heard.indexOf(listener), 1) };
    };
  }
  fire(value) {
    return Promise.all(this._heard.map((listener) => listener(value)));
  }
}

class CancellationTokenSource {
  constructor() {
    const emitter = new Emitter();
    this.token = { isCancellationRequested: false, onCancellationRequested: emitter.event };
    this.cancel = () => {
      this.token.isCancellationRequested = true;
      return emitter.fire();
    };
  }
}

class TestMessage {
  constructor(message) {
    this.message = message;
  }
  static diff(message, expectedOutput, actualOutput) {
    return Object.assign(new TestMessage(message), { expectedOutput, actualOutput });
  }
}

class Items extends Map {
  add(item) {
    this.set(item.id, item);
  }
  replace(items) {
    this.clear();
    items.forEach((item) => this.add(item));
  }
  forEach(callback) {
    [...this.values()].forEach((item) => callback(item));
  }
}

// A class that only has what it is made of, under these names.
const record = (...names) =>
  class {
    constructor(...values) {
      names.forEach((name, at) => (this[name] = values[at]));
    }
  };

class Document {
  constructor(uri, languageId, text) {
    Object.assign(this, { uri, languageId, lines: text.split("\n") });
  }
  get lineCount() {
    return this.lines.length;
  }
  getText(range) {
    if (!range) return this.lines.join("\n");
    const inside = this.lines.slice(range.start.line, range.end.line + 1);
    inside[inside.length - 1] = inside[inside.length - 1].slice(0, range.end.character);
    return inside.join("\n");
  }
  lineAt(line) {
    return { text: this.lines[line] };
  }
  positionAt(offset) {
    const before = this.getText().slice(0, offset).split("\n");
    return new Position(before.length - 1, before[before.length - 1].length);
  }
  getWordRangeAtPosition({ line, character }) {
    const found = [...(this.lines[line] ?? "").matchAll(/\w+/g)].find(
      (one) => one.index <= character && character <= one.index + one[0].length,
    );
    return found && new Range(line, found.index, line, found.index + found[0].length);
  }
}

const FileCoverage = record("uri", "details");
FileCoverage.fromDetails = (uri, details) => new FileCoverage(uri, details);

const events = {
  opened: new Emitter(),
  saved: new Emitter(),
  closed: new Emitter(),
  changed: new Emitter(),
};
const registered = { diagnostics: new Map(), controllers: [], formatters: [], hovers: [], debuggers: {}, log: [], errors: [] };
const settings = {};

const diagnostics = {
  set: (uri, found) => registered.diagnostics.set(uri.fsPath, found),
  clear: () => registered.diagnostics.clear(),
  dispose: () => registered.diagnostics.clear(),
};

function createTestController(id) {
  const controller = { id, items: new Items(), profiles: [], dispose() {} };
  controller.createTestItem = (itemId, label, uri) => ({ id: itemId, label, uri, children: new Items() });
  controller.createRunProfile = (name, kind, run) => {
    const profile = { name, kind, run };
    controller.profiles.push(profile);
    return profile;
  };
  controller.createTestRun = () => {
    const run = { outcomes: [], output: [], covered: [], isOver: false };
    for (const verdict of ["passed", "failed", "errored", "skipped"]) {
      run[verdict] = (item, messages) => run.outcomes.push({ verdict, name: item.label, messages });
    }
    run.enqueued = run.started = () => {};
    run.appendOutput = (text) => run.output.push(text);
    run.addCoverage = (covered) => run.covered.push(covered);
    run.end = () => (run.isOver = true);
    controller.lastRun = run;
    return run;
  };
  registered.controllers.push(controller);
  return controller;
}

const disposable = { dispose() {} };

module.exports = {
  Position, Range, Uri, CancellationTokenSource, TestMessage, FileCoverage,
  Location: record("uri", "position"),
  Diagnostic: record("range", "message", "severity"),
  DiagnosticSeverity: { Error: 0, Warning: 1, Information: 2 },
  TestRunProfileKind: { Run: 1, Debug: 2, Coverage: 3 },
  StatementCoverage: record("executed", "location", "branches"),
  BranchCoverage: record("executed", "location", "label"),
  TextEdit: { replace: (range, newText) => ({ range, newText }) },
  MarkdownString: class {
    appendCodeblock(text) {
      this.value = text;
    }
  },
  Hover: record("contents", "range"),
  EvaluatableExpression: record("range", "expression"),
  DebugStackFrame: record(),
  DebugAdapterExecutable: record("command", "args", "options"),
  window: {
    createOutputChannel: () => ({ append: (text) => registered.log.push(text), appendLine: (text) => registered.log.push(text) }),
    setStatusBarMessage: (text) => registered.log.push(text),
    showErrorMessage: (text) => registered.errors.push(text),
    showQuickPick: async (items) => items[0],
    activeTextEditor: undefined,
  },
  workspace: {
    workspaceFolders: [],
    textDocuments: [],
    getConfiguration: () => ({ get: (name) => settings[name] }),
    getWorkspaceFolder(uri) {
      return this.workspaceFolders.find((folder) => uri.fsPath.startsWith(folder.uri.fsPath));
    },
    findFiles: async () => [],
    createFileSystemWatcher: () => ({
      onDidCreate: events.changed.event, onDidChange: events.changed.event, onDidDelete: events.changed.event, dispose() {},
    }),
    onDidOpenTextDocument: events.opened.event,
    onDidSaveTextDocument: events.saved.event,
    onDidCloseTextDocument: events.closed.event,
  },
  languages: {
    createDiagnosticCollection: () => diagnostics,
    registerDocumentFormattingEditProvider: (_languages, provider) => (registered.formatters.push(provider), disposable),
    registerHoverProvider: (_languages, provider) => (registered.hovers.push(provider), disposable),
    registerEvaluatableExpressionProvider: (_languages, provider) => (registered.evaluatable = provider, disposable),
  },
  tests: { createTestController },
  extensions: { getExtension: () => undefined },
  debug: {
    activeDebugSession: undefined,
    activeStackItem: undefined,
    registerDebugConfigurationProvider: (_type, provider) => (registered.debuggers.configurations = provider, disposable),
    registerDebugAdapterDescriptorFactory: (_type, factory) => (registered.debuggers.adapters = factory, disposable),
    registerDebugAdapterTrackerFactory: (_type, factory) => (registered.debuggers.trackers = factory, disposable),
  },
  // What only tests use.
  Document, events, registered, settings,
};
