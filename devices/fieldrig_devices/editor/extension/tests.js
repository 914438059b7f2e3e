// The test explorer: tests of programs as `fieldrig iec test` lists and runs them.
"use strict";

const fs = require("node:fs");
const os = require("node:os");
const path = require("node:path");
const vscode = require("vscode");
const { coverageOf } = require("./coverage");

const WATCHED = "**/*.{st,ST,il,TcPOU,plcproj}";
const LONG = 40; // characters of a value, such as a structure, that is better shown beside the expected one
const SETTLED_MS = 300; // a save of several files is one change

class Tests {
  constructor(fieldrig) {
    this._fieldrig = fieldrig;
    this._cases = new Map(); // what the list says of a test, by its id
    this._details = new WeakMap(); // the lines and branches of a covered file
    this._controller = vscode.tests.createTestController("fieldrig", "fieldrig");
    this._controller.refreshHandler = (token) => this.find(token);
    const kinds = vscode.TestRunProfileKind;
    const add = (name, kind) =>
      this._controller.createRunProfile(name, kind, (request, token) => this.run(request, token, kind), true);
    add("Run", kinds.Run);
    add("Coverage", kinds.Coverage).loadDetailedCoverage = async (_run, file) => this._details.get(file) ?? [];
    this._watcher = vscode.workspace.createFileSystemWatcher(WATCHED);
    for (const event of ["onDidCreate", "onDidChange", "onDidDelete"]) this._watcher[event](() => this._findSoon());
  }

  dispose() {
    clearTimeout(this._timer);
    this._watcher.dispose();
    this._controller.dispose();
  }

  _findSoon() {
    clearTimeout(this._timer);
    this._timer = setTimeout(() => this.find(), SETTLED_MS);
  }

  // ---- the list

  async find(token) {
    const found = [];
    for (const folder of vscode.workspace.workspaceFolders ?? []) {
      try {
        const cases = await this._fieldrig.json(folder.uri, [...this._words(folder.uri), "--list", "--json"], { token });
        found.push(...cases.map((one) => ({ ...one, folder: folder.uri })));
      } catch (cause) {
        this._fieldrig.say(cause); // a folder without tests has none to show
      }
    }
    if (!token?.isCancellationRequested) this._show(found);
  }

  _words(folder, ...chosen) {
    const dialect = this._fieldrig.settings(folder).get("dialect");
    return ["iec", "test", ...(chosen.length ? chosen : [folder.fsPath]), "--dialect", dialect];
  }

  _show(cases) {
    this._cases = new Map(cases.map((one) => [one.id, one]));
    const suites = new Map();
    for (const one of cases) {
      if (!suites.has(one.suite)) suites.set(one.suite, this._suite(one));
      suites.get(one.suite).children.add(this._item(one));
    }
    this._controller.items.replace([...suites.values()]);
  }

  _suite({ suite, file, folder }) {
    const isFile = suite === file;
    const label = isFile ? path.relative(folder.fsPath, file) : suite;
    return this._controller.createTestItem(suite, label, vscode.Uri.file(file));
  }

  _item({ id, name, file, line }) {
    const item = this._controller.createTestItem(id, name, vscode.Uri.file(file));
    if (line > 0) item.range = new vscode.Range(line - 1, 0, line - 1, 0);
    return item;
  }

  // ---- a run

  async run(request, token, kind) {
    const run = this._controller.createTestRun(request);
    const groups = this._groups(this._wanted(request));
    for (const { items } of groups) items.forEach((item) => run.enqueued(item));
    for (const group of groups) {
      if (token.isCancellationRequested) break;
      await this._runGroup(run, group, token, kind === vscode.TestRunProfileKind.Coverage);
    }
    run.end();
  }

  _wanted(request) {
    const excluded = new Set((request.exclude ?? []).map((item) => item.id));
    const leaves = [];
    const visit = (item) => {
      if (excluded.has(item.id)) return;
      if (item.children.size) item.children.forEach(visit);
      else leaves.push(item);
    };
    (request.include ?? []).forEach(visit);
    if (!request.include) this._controller.items.forEach(visit);
    return leaves.filter((item) => this._cases.has(item.id));
  }

  // The tests of a file run together, as do all suites of a folder, whose project is compiled once.
  _groups(items) {
    const groups = new Map();
    for (const item of items) {
      const { id, name, file, folder } = this._cases.get(item.id);
      const isBlock = id === `${file}::${name}`;
      const key = isBlock ? file : folder.fsPath;
      if (!groups.has(key)) groups.set(key, { folder, items: [], paths: [], words: [] });
      const group = groups.get(key);
      group.items.push(item);
      if (isBlock) group.paths.push(id);
      else group.words.push("-k", id);
    }
    return [...groups.values()];
  }

  async _runGroup(run, { folder, items, paths, words }, token, isCovered) {
    items.forEach((item) => run.started(item));
    const open = new Map(items.map((item) => [item.id, item]));
    const lcov = isCovered ? path.join(fs.mkdtempSync(path.join(os.tmpdir(), "fieldrig-")), "lcov.info") : "";
    try {
      const further = [...words, "--json", ...(lcov ? ["--lcov", lcov] : [])];
      await this._fieldrig.each(folder, [...this._words(folder, ...paths), ...further], { token }, (outcome) => {
        const item = open.get(outcome.id);
        if (item && open.delete(outcome.id)) report(run, item, outcome);
      });
      if (lcov && fs.existsSync(lcov)) this._cover(run, folder, fs.readFileSync(lcov, "utf8"));
      open.forEach((item) => run.errored(item, new vscode.TestMessage("fieldrig has not reported this test")));
    } catch (cause) {
      if (token.isCancellationRequested) open.forEach((item) => run.skipped(item));
      else open.forEach((item) => run.errored(item, new vscode.TestMessage(cause.message)));
    } finally {
      if (lcov) fs.rmSync(path.dirname(lcov), { recursive: true });
    }
  }

  _cover(run, folder, text) {
    for (const { file, details } of coverageOf(text, this._fieldrig.folder(folder))) {
      const covered = vscode.FileCoverage.fromDetails(vscode.Uri.file(file), details);
      this._details.set(covered, details);
      run.addCoverage(covered);
    }
  }
}

// ---- an outcome

function report(run, item, outcome) {
  const milliseconds = outcome.wall_s * 1000;
  for (const line of [...outcome.output, ...outcome.failures.flatMap((failure) => failure.diagram)]) {
    run.appendOutput(`${line}\r\n`, undefined, item);
  }
  const messages = outcome.failures.map(message);
  if (outcome.verdict === "passed") run.passed(item, milliseconds);
  else if (outcome.verdict === "skipped") run.skipped(item);
  else if (outcome.verdict === "failed") run.failed(item, messages, milliseconds);
  else run.errored(item, messages, milliseconds);
}

// The first line is shown beside the source, so it has the values too.
function message(failure) {
  const { kind, expected, actual, file, line, diagram } = failure;
  const isCompared = kind !== "mistake" && Math.max(expected.length, actual.length) > LONG;
  const text = [kind === "mistake" ? mistake(failure) : assertion(failure), ...diagram].join("\n");
  const shown = isCompared ? vscode.TestMessage.diff(text, expected, actual) : new vscode.TestMessage(text);
  shown.location = new vscode.Location(vscode.Uri.file(file), new vscode.Position(Math.max(line, 1) - 1, 0));
  return shown;
}

function assertion({ kind, expected, actual, message: words }) {
  return [words || kind, expected ? `expected ${expected}, got ${actual}` : actual].filter(Boolean).join(": ");
}

function mistake({ expected, actual, message: hint }) {
  return [expected ? `${actual}; expected ${expected}` : actual, hint].filter(Boolean).join("\n");
}

exports.register = (fieldrig) => {
  const tests = new Tests(fieldrig);
  tests.find();
  return [tests];
};
