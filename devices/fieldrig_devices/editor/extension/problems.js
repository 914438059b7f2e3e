// Problems of rig files and programs, from `fieldrig editor problems`, when a file is opened or saved.
"use strict";

const vscode = require("vscode");
const { isProgram, isRig } = require("./languages");

const SEVERITIES = {
  error: vscode.DiagnosticSeverity.Error,
  warning: vscode.DiagnosticSeverity.Warning,
  note: vscode.DiagnosticSeverity.Information,
};

// A problem goes from its column to the end of the word there; of a line without one, to the end of the line.
function diagnostic(problem, document) {
  const start = new vscode.Position(problem.line - 1, problem.column - 1);
  const inside = document && problem.line <= document.lineCount;
  const range =
    (inside && document.getWordRangeAtPosition(start)) || new vscode.Range(start, start.with({ character: 1000 }));
  const found = new vscode.Diagnostic(range, problem.message, SEVERITIES[problem.severity]);
  found.source = "fieldrig";
  return found;
}

class Problems {
  constructor(fieldrig) {
    this._fieldrig = fieldrig;
    this._shown = vscode.languages.createDiagnosticCollection("fieldrig");
    this._found = new Map(); // the problems by the file that was judged; they may be in other files
    this._runs = new Map(); // what cancels the judgement of a file that still goes on
  }

  dispose() {
    this._shown.dispose();
  }

  async judge(document) {
    if (document.uri.scheme !== "file" || !(isProgram(document) || isRig(document))) return;
    const { uri } = document;
    const key = uri.toString();
    this._runs.get(key)?.cancel();
    const run = new vscode.CancellationTokenSource();
    this._runs.set(key, run);
    const dialect = this._fieldrig.settings(uri).get("dialect");
    try {
      const words = ["editor", "problems", uri.fsPath, "--dialect", dialect];
      const problems = await this._fieldrig.json(uri, words, { token: run.token });
      if (!run.token.isCancellationRequested) this._show(key, problems);
    } catch (cause) {
      if (!run.token.isCancellationRequested) this._fieldrig.say(cause);
    } finally {
      if (this._runs.get(key) === run) this._runs.delete(key);
    }
  }

  forget(document) {
    if (this._found.has(document.uri.toString())) this._show(document.uri.toString(), []);
  }

  // Two files that belong together have problems in common, which are shown once.
  _show(judged, problems) {
    if (problems.length) this._found.set(judged, problems);
    else this._found.delete(judged);
    const byFile = new Map();
    for (const problem of [...this._found.values()].flat()) {
      if (!byFile.has(problem.file)) byFile.set(problem.file, new Map());
      byFile.get(problem.file).set(JSON.stringify(problem), problem);
    }
    this._shown.clear();
    for (const [file, found] of byFile) {
      const document = vscode.workspace.textDocuments.find((open) => open.uri.fsPath === file);
      this._shown.set(vscode.Uri.file(file), [...found.values()].map((problem) => diagnostic(problem, document)));
    }
  }
}

exports.register = (fieldrig) => {
  const problems = new Problems(fieldrig);
  vscode.workspace.textDocuments.forEach((document) => problems.judge(document));
  return [
    problems,
    vscode.workspace.onDidOpenTextDocument((document) => problems.judge(document)),
    vscode.workspace.onDidSaveTextDocument((document) => problems.judge(document)),
    vscode.workspace.onDidCloseTextDocument((document) => problems.forget(document)),
  ];
};
