// The extension without an editor and without fieldrig: what it asks for, and what it makes of the answers.
"use strict";

const assert = require("node:assert");
const fs = require("node:fs");
const os = require("node:os");
const path = require("node:path");
const { test, beforeEach } = require("node:test");
const vscode = require("vscode");

const EXTENSION = process.env.EXTENSION;
const load = (name) => require(path.join(EXTENSION, name));
const { expressionAt, scopeAt } = load("expressions.js");
const { coverageOf } = load("coverage.js");
const { Fieldrig } = load("fieldrig.js");
const { isRig, nameIn } = load("languages.js");

const FOLDER = "/work";
const uri = (name) => vscode.Uri.file(`${FOLDER}/${name}`);
const document = (name, text, language = "st") => new vscode.Document(uri(name), language, text);

// A fieldrig whose answers are given: by the words of the question, or all of them.
class Answers {
  constructor(answers) {
    this.asked = [];
    this.said = [];
    this._answers = answers;
  }
  settings() {
    return { get: (name) => ({ dialect: "epas-4", control: "tcp/127.0.0.1:7447" })[name] };
  }
  folder() {
    return FOLDER;
  }
  command() {
    return ["fieldrig"];
  }
  say(cause) {
    this.said.push(cause.message ?? cause);
  }
  async run(_uri, words, options = {}) {
    this.asked.push(words);
    return this._answers(words, options);
  }
  async each(where, words, options, take) {
    for (const value of await this.json(where, words, options)) take(value);
  }

  json(where, words, options) {
    return this.run(where, words, options);
  }
}

beforeEach(() => {
  vscode.registered.controllers.length = 0;
  vscode.registered.diagnostics.clear();
  vscode.registered.errors.length = 0;
  vscode.workspace.workspaceFolders = [{ uri: vscode.Uri.file(FOLDER) }];
  vscode.workspace.textDocuments = [];
  vscode.window.activeTextEditor = undefined;
  vscode.debug.activeDebugSession = vscode.debug.activeStackItem = undefined;
});

// ---- expressions

for (const [language, line, under, expected] of [
  ["st", "a := up.total[2].x;", "up", "up"],
  ["st", "a := up.total[2].x;", "total", "up.total"],
  ["st", "a := up.total[2].x;", "x;", "up.total[2].x"],
  ["st", "p^.value := 3;", "value", "p^.value"],
  ["st", "list[i + 1] := 2;", "list", "list"],
  ["st", "a := 'text';", "text", undefined],
  ["st", "a := 1; // count", "count", undefined],
  ["st", "(* count *) a := 1;", "count", undefined],
  ["st", "(* count *) a := 1;", "a", "a"],
  ["pam", "AXI_Belt <- speed(3);", "AXI", "AXI_Belt"],
  ["pam", "// AXI_Belt", "AXI", undefined],
  ["arp", "  SPEED == V1 ; of V2", "V1", "V1"],
  ["arp", "  SPEED == V1 ; of V2", "V2", undefined],
  ["arp", "  V2 == @POS1", "POS1", "@POS1"],
]) {
  test(`the expression of ${language} at ${under} in ${line}`, () => {
    assert.strictEqual(expressionAt(language, line, line.indexOf(under))?.text, expected);
  });
}

test("the program, block or function of a place is the last one that has begun", () => {
  const text = "FUNCTION_BLOCK FINAL Counter\nVAR a : INT; END_VAR\nEND_FUNCTION_BLOCK\nprogram Main\n";
  assert.deepStrictEqual(scopeAt(text), { kind: "PROGRAM", name: "Main" });
  assert.deepStrictEqual(scopeAt(text.slice(0, 40)), { kind: "FUNCTION_BLOCK", name: "Counter" });
  assert.strictEqual(scopeAt("VAR_GLOBAL a : INT; END_VAR"), undefined);
});

// ---- files

test("a rig file is a YAML file with devices, buses or a rig that it extends", () => {
  assert.ok(isRig(document("a.yaml", "time: virtual\ndevices: {}\n", "yaml")));
  assert.ok(isRig(document("a.yaml", "extends: lab.yaml\n", "yaml")));
  assert.ok(!isRig(document("a.yaml", "services:\n  devices: 1\n", "yaml")));
  assert.ok(!isRig(document("a.st", "devices:\n")));
});

test("a file is one of a program by the end of its path", () => {
  const program = { files: ["main.st", "parts/count.st"] };
  assert.strictEqual(nameIn(program, uri("project/parts/count.st")), "parts/count.st");
  assert.strictEqual(nameIn(program, uri("project/xmain.st")), undefined);
});

test("coverage has the hits of each line, and the branches behind it", () => {
  const text = "TN:\nSF:a.st\nBRDA:3,0,0,1\nBRDA:3,0,1,-\nDA:3,5\nDA:4,0\nend_of_record\nSF:/other/b.st\nDA:1,1\nend_of_record\n";
  const [first, second] = coverageOf(text, FOLDER);
  assert.deepStrictEqual([first.file, second.file], [path.resolve(FOLDER, "a.st"), path.resolve("/other/b.st")]);
  assert.deepStrictEqual(first.details.map((one) => [one.location.line, one.executed]), [[2, 5], [3, 0]]);
  assert.deepStrictEqual(first.details[0].branches.map((one) => one.executed), [1, 0]);
});

// ---- the command line

test("the command is that of the settings, the folder's own, the installer's, or the one on the path", () => {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "editor-"));
  vscode.workspace.workspaceFolders = [{ uri: vscode.Uri.file(folder) }];
  const fieldrig = new Fieldrig(folder);
  const where = vscode.Uri.file(path.join(folder, "a.st"));
  const made = (name, text = "") => {
    const file = path.join(folder, name);
    fs.mkdirSync(path.dirname(file), { recursive: true });
    fs.writeFileSync(file, text);
    return file;
  };
  try {
    assert.deepStrictEqual(fieldrig.command(where), ["fieldrig"]);
    made("installed.json", JSON.stringify({ command: [path.join(folder, "gone"), "-m", "fieldrig"] }));
    assert.deepStrictEqual(fieldrig.command(where), ["fieldrig"]);
    made("installed.json", JSON.stringify({ command: [process.execPath, "-m", "fieldrig"] }));
    assert.deepStrictEqual(fieldrig.command(where), [process.execPath, "-m", "fieldrig"]);
    const own = made(".venv/bin/fieldrig");
    assert.deepStrictEqual(fieldrig.command(where), [own]);
    vscode.settings.command = ["/opt/fieldrig"];
    assert.deepStrictEqual(fieldrig.command(where), ["/opt/fieldrig"]);
  } finally {
    delete vscode.settings.command;
    fs.rmSync(folder, { recursive: true });
  }
});

test("a program that prints no JSON is an error with its own words", async () => {
  vscode.settings.command = [process.execPath, "-e", "console.error('error: no rig'); process.exit(4)"];
  vscode.workspace.workspaceFolders = [];
  try {
    const here = vscode.Uri.file(__filename);
    await assert.rejects(new Fieldrig(FOLDER).json(here, ["status"]), /^Error: error: no rig$/);
    vscode.settings.command = ["/nowhere/fieldrig"];
    await assert.rejects(new Fieldrig(FOLDER).json(here, ["status"]), /cannot be started/);
  } finally {
    delete vscode.settings.command;
  }
});

test("each value of a list is taken as soon as it is printed, before the program has ended", async () => {
  const program = `
    console.log('[{"id": "one"}');
    process.stdin.on("end", () => console.log(',{"id": "two"}\\n]')).resume();
  `;
  vscode.settings.command = [process.execPath, "-e", program];
  vscode.workspace.workspaceFolders = [];
  try {
    const taken = [];
    await new Fieldrig(FOLDER).each(vscode.Uri.file(__filename), [], {}, (value) => taken.push(value.id));
    assert.deepStrictEqual(taken, ["one", "two"]);
    vscode.settings.command = [process.execPath, "-e", "console.error('error: no tests'); process.exit(2)"];
    await assert.rejects(new Fieldrig(FOLDER).each(vscode.Uri.file(__filename), [], {}, () => {}), /^Error: error: no tests$/);
  } finally {
    delete vscode.settings.command;
  }
});

// ---- problems

test("problems of several files are shown, once, and go with the file that was closed", async () => {
  const one = { file: `${FOLDER}/b.st`, line: 2, column: 6, severity: "error", message: "b is not declared" };
  const fieldrig = new Answers((words) => (words[2].endsWith("a.st") ? [one, { ...one, severity: "note" }] : [one]));
  const [a, b] = [document("a.st", ""), document("b.st", "x\nc := bad + 1;\n")];
  vscode.workspace.textDocuments = [b];
  load("problems.js").register(fieldrig);
  await vscode.events.saved.fire(a);
  await vscode.events.opened.fire(b);
  await vscode.events.opened.fire(document("c.txt", "", "plaintext"));
  const shown = () => vscode.registered.diagnostics.get(`${FOLDER}/b.st`) ?? [];
  assert.deepStrictEqual(shown().map((found) => found.severity), [0, 2]);
  assert.deepStrictEqual({ ...shown()[0].range.end }, { line: 1, character: 8 });
  assert.ok(fieldrig.asked.every((words) => words[0] === "editor" && !words[2].endsWith("c.txt")));
  await vscode.events.closed.fire(a);
  assert.deepStrictEqual(shown().map((found) => found.severity), [0]);
});

// ---- formatting

test("a formatted text takes the place of all, and a text with mistakes stays", async () => {
  const answers = { right: { code: 0, stdout: "a;\n" }, same: { code: 0, stdout: "same" }, bad: { code: 2, stderr: "-:1:1: got b" } };
  const fieldrig = new Answers((_words, { input }) => answers[input]);
  load("formatting.js").register(fieldrig);
  const provider = vscode.registered.formatters.pop();
  const edits = (text) => provider.provideDocumentFormattingEdits(document("a.st", text));
  assert.deepStrictEqual((await edits("right")).map((edit) => edit.newText), ["a;\n"]);
  assert.deepStrictEqual(await edits("same"), []);
  assert.deepStrictEqual(await edits("bad"), []);
  assert.deepStrictEqual(fieldrig.said, ["-:1:1: got b"]);
  assert.deepStrictEqual(fieldrig.asked[0], ["iec", "fmt", "-", "--dialect", "epas-4"]);
});

// ---- tests

const FILE = `${FOLDER}/a_test.st`;
const listed = (name, line, suite = FILE, file = FILE) => ({ id: `${suite}::${name}`, name, suite, file, line });
const outcome = (one, verdict, failures = []) => ({ ...one, verdict, failures, output: [], wall_s: 0.5 });
const failure = { kind: "ASSERT_EQ", expected: "4", actual: "3", message: "a is wrong", file: FILE, line: 7, diagram: ["a 3"] };

async function explorer(cases, outcomes) {
  const fieldrig = new Answers((words) => (words.includes("--list") ? cases : outcomes(words)));
  load("tests.js").register(fieldrig);
  await new Promise((resolve) => setImmediate(resolve));
  return { fieldrig, controller: vscode.registered.controllers[0] };
}

test("tests are listed by their files with their lines", async () => {
  const { controller } = await explorer([listed("one", 1), listed("two", 9)], () => []);
  const [suite] = [...controller.items.values()];
  assert.strictEqual(suite.label, "a_test.st");
  assert.deepStrictEqual([...suite.children.values()].map((item) => [item.label, item.range.start.line]), [["one", 0], ["two", 8]]);
});

test("a run asks for each file once, and reports failures with values, file and line", async () => {
  const [one, two, third] = [listed("one", 1), listed("two", 9), listed("gone", 20)];
  const fault = { ...failure, kind: "mistake", expected: "a variable", actual: "got ;", message: "", diagram: [] };
  const { fieldrig, controller } = await explorer([one, two, third], () => [
    outcome(one, "failed", [failure]),
    outcome(two, "error", [fault]),
  ]);
  const { token } = new vscode.CancellationTokenSource();
  await controller.profiles[0].run({}, token);
  const run = controller.lastRun;
  assert.ok(run.isOver);
  assert.deepStrictEqual(run.outcomes.map(({ verdict, name }) => [verdict, name]), [["failed", "one"], ["errored", "two"], ["errored", "gone"]]);
  const [message] = run.outcomes[0].messages;
  assert.strictEqual(message.message, "a is wrong: expected 4, got 3\na 3");
  assert.deepStrictEqual([message.expectedOutput, message.location.position.line], [undefined, 6]);
  assert.strictEqual(run.outcomes[1].messages[0].message, "got ;; expected a variable");
  const ran = fieldrig.asked.filter((words) => !words.includes("--list"));
  assert.deepStrictEqual(ran, [["iec", "test", one.id, two.id, third.id, "--dialect", "epas-4", "--json"]]);
});

test("long values are shown beside each other", async () => {
  const one = listed("one", 1);
  const [expected, actual] = ["(a := 1, b := 2, c := 3, d := 4, e := 5, f := 6)", "(a := 1)"];
  const { controller } = await explorer([one], () => [outcome(one, "failed", [{ ...failure, expected, actual }])]);
  await controller.profiles[0].run({}, new vscode.CancellationTokenSource().token);
  const [message] = controller.lastRun.outcomes[0].messages;
  assert.deepStrictEqual([message.expectedOutput, message.actualOutput], [expected, actual]);
});

test("suites of a project are run by their names, and what is excluded is not", async () => {
  const suite = [listed("one", 1, "PRG.suite", `${FOLDER}/FB.TcPOU`), listed("two", 2, "PRG.suite", `${FOLDER}/FB.TcPOU`)];
  const { fieldrig, controller } = await explorer(suite, () => [outcome(suite[0], "passed"), outcome(suite[1], "passed")]);
  const [item] = [...controller.items.values()];
  const { token } = new vscode.CancellationTokenSource();
  await controller.profiles[0].run({ include: [item], exclude: [item.children.get(suite[1].id)] }, token);
  assert.deepStrictEqual(controller.lastRun.outcomes.map((one) => one.name), ["one"]);
  assert.deepStrictEqual(fieldrig.asked.pop(), ["iec", "test", FOLDER, "--dialect", "epas-4", "-k", suite[0].id, "--json"]);
});

test("a run that cannot start marks its tests, and a cancelled one skips them", async () => {
  const one = listed("one", 1);
  const cancelling = new vscode.CancellationTokenSource();
  const { controller } = await explorer([one], () => {
    throw new Error("fieldrig cannot be started");
  });
  await controller.profiles[0].run({}, cancelling.token);
  assert.deepStrictEqual(controller.lastRun.outcomes[0].messages.message, "fieldrig cannot be started");
  cancelling.cancel();
  await controller.profiles[0].run({}, cancelling.token);
  assert.deepStrictEqual([controller.lastRun.outcomes, controller.lastRun.isOver], [[], true]);
});

test("a run for coverage adds what the report says", async () => {
  const one = listed("one", 1);
  const { controller } = await explorer([one], (words) => {
    fs.writeFileSync(words[words.indexOf("--lcov") + 1], "SF:a.st\nDA:1,2\nend_of_record\n");
    return [outcome(one, "passed")];
  });
  const { token } = new vscode.CancellationTokenSource();
  await controller.profiles[1].run({}, token);
  const [covered] = controller.lastRun.covered;
  assert.strictEqual(covered.uri.fsPath, `${FOLDER}/a.st`);
  const details = await controller.profiles[1].loadDetailedCoverage(controller.lastRun, covered);
  assert.deepStrictEqual(details.map((line) => line.executed), [2]);
});

// ---- the debugger

function debugging(answers) {
  const fieldrig = new Answers(answers);
  load("debug.js").register(fieldrig);
  const provider = vscode.registered.debuggers.configurations;
  const resolved = async (configuration) => {
    const first = provider.resolveDebugConfiguration(undefined, configuration);
    return provider.resolveDebugConfigurationWithSubstitutedVariables(vscode.workspace.workspaceFolders[0], first);
  };
  return { fieldrig, resolved, factory: vscode.registered.debuggers.adapters };
}

const PROGRAMS = [
  { device: "other", language: "PAM", files: ["a.pam"] },
  { device: "controller", language: "IEC 61131-3", files: ["count.st"] },
];

test("without a configuration, the device of the open file is debugged, with the file's folder", async () => {
  vscode.window.activeTextEditor = { document: document("programs/count.st", "") };
  const { resolved, factory } = debugging(() => PROGRAMS);
  const configuration = await resolved({});
  assert.deepStrictEqual([configuration.device, configuration.sources], ["controller", `${FOLDER}/programs`]);
  const adapter = factory.createDebugAdapterDescriptor({ configuration });
  assert.deepStrictEqual(adapter.args, ["debug-adapter", "controller", "--control", "tcp/127.0.0.1:7447"]);
});

test("a device and an endpoint that are given are taken", async () => {
  const { fieldrig, resolved } = debugging(() => PROGRAMS);
  const given = { type: "fieldrig", request: "attach", name: "x", device: "other", control: "tcp/127.0.0.1:1", sources: "/s" };
  assert.deepStrictEqual(await resolved(given), given);
  assert.deepStrictEqual(fieldrig.asked, [["editor", "programs", "--control", "tcp/127.0.0.1:1"]]);
});

test("a device that has no program, and a rig that is not there, are said", async () => {
  const { resolved } = debugging((words) => {
    if (words[1] === "programs") return PROGRAMS;
    throw new Error("no rig answers");
  });
  assert.strictEqual(await resolved({ type: "fieldrig", request: "attach", name: "x", device: "panel" }), undefined);
  assert.match(vscode.registered.errors[0], /expected panel/);
  const gone = debugging(() => {
    throw new Error("no rig answers");
  });
  assert.strictEqual(await gone.resolved({ type: "fieldrig", request: "attach", name: "x" }), undefined);
  assert.deepStrictEqual(vscode.registered.errors.slice(1), ["no rig answers"]);
});

// ---- live values

async function hovered(text, line, word, values, groups = {}) {
  const asked = [];
  vscode.debug.activeDebugSession = {
    type: "fieldrig",
    customRequest: async (command, question) => {
      asked.push(question);
      if (command === "fieldrig.variables") return { variables: groups[question.path] ?? [] };
      return { variables: question.names.map((name) => values[name] ?? { path: name, error: "unknown" }) };
    },
  };
  load("hover.js").register(new Answers(() => []));
  const where = document("a.st", text);
  const position = new vscode.Position(line, where.lines[line].indexOf(word));
  const hover = await vscode.registered.hovers.pop().provideHover(where, position);
  return { text: hover?.contents.value, asked };
}

const value = (path, content, type = "INT") => ({ path, name: path, type, value: content, text: "", is_forced: false });

test("a variable of a program has the program's name in front", async () => {
  const text = "PROGRAM Main\nVAR a : INT; END_VAR\na := 1;\nEND_PROGRAM\n";
  const { text: shown, asked } = await hovered(text, 2, "a", { "Main.a": value("Main.a", 7) });
  assert.strictEqual(shown, "Main.a = 7");
  assert.deepStrictEqual(asked, [{ names: ["Main.a", "a"] }]);
});

test("a variable of a block is shown for each instance", async () => {
  const text = "FUNCTION_BLOCK Counter\nVAR on : BOOL; END_VAR\non := TRUE;\nEND_FUNCTION_BLOCK\n";
  const groups = {
    "": [value("Main", null, "PROGRAM")],
    Main: [value("Main.up", null, "COUNTER"), value("Main.list", null, "ARRAY"), value("Main.n", 1)],
    "Main.list": [value("Main.list[1]", null, "Counter")],
  };
  const values = {
    "Main.up.on": value("Main.up.on", true, "BOOL"),
    "Main.list[1].on": { ...value("Main.list[1].on", false, "BOOL"), is_forced: true },
  };
  const { text: shown } = await hovered(text, 2, "on", values, groups);
  assert.strictEqual(shown, "Main.up.on = TRUE\nMain.list[1].on = FALSE  (forced)");
});

test("what is no variable has no hover, and while a program stands the editor asks itself", async () => {
  assert.strictEqual((await hovered("PROGRAM Main\nIF a THEN\n", 1, "IF", {})).text, undefined);
  vscode.debug.activeStackItem = new vscode.DebugStackFrame();
  const { text: shown, asked } = await hovered("PROGRAM Main\na := 1;\n", 1, "a", { "Main.a": value("Main.a", 7) });
  assert.deepStrictEqual([shown, asked], [undefined, []]);
});

// ---- rig files

test("the YAML extension gets the schema for rig files only, and it is made once", async () => {
  const given = {};
  vscode.extensions.getExtension = (id) => ({
    activate: async () => ({ registerContributor: (...parts) => (given[id] = parts) }),
  });
  const fieldrig = new Answers(() => ({ code: 0, stdout: "{}" }));
  load("schema.js").register(fieldrig);
  await new Promise((resolve) => setImmediate(resolve));
  const [scheme, schemaOf, contentOf] = given["redhat.vscode-yaml"];
  const [rig, other] = [document("rig.yaml", "devices: {}", "yaml"), document("a.yaml", "services: {}", "yaml")];
  vscode.workspace.textDocuments = [rig, other];
  const [found, nothing] = [rig, other].map((one) => schemaOf(one.uri.toString()));
  assert.deepStrictEqual([new URL(found).protocol, nothing], [`${scheme}:`, undefined]);
  assert.deepStrictEqual([await contentOf(found), await contentOf(found)], ["{}", "{}"]);
  assert.deepStrictEqual(fieldrig.asked, [["schema"]]);
});
