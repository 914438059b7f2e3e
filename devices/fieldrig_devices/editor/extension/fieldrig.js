// The command line of fieldrig: which command is started for a file, and its answer as JSON.
"use strict";

const childProcess = require("node:child_process");
const fs = require("node:fs");
const path = require("node:path");
const readline = require("node:readline");
const vscode = require("vscode");

const IN_FOLDER = [".venv/bin/fieldrig", ".venv/Scripts/fieldrig.exe"];

class Fieldrig {
  constructor(extensionPath) {
    this._installed = path.join(extensionPath, "installed.json");
    this.log = vscode.window.createOutputChannel("fieldrig");
  }

  settings(uri) {
    return vscode.workspace.getConfiguration("fieldrig", uri);
  }

  // The folder of the workspace that has the file, or else the file's own.
  folder(uri) {
    const folder = uri && vscode.workspace.getWorkspaceFolder(uri);
    if (folder) return folder.uri.fsPath;
    return uri ? path.dirname(uri.fsPath) : (vscode.workspace.workspaceFolders ?? [])[0]?.uri.fsPath ?? process.cwd();
  }

  // The words that start fieldrig: those of the settings, the folder's own, those that installed the extension, or the path's.
  command(uri) {
    const chosen = this.settings(uri).get("command") ?? [];
    if (chosen.length) return chosen;
    const own = IN_FOLDER.map((name) => path.join(this.folder(uri), name)).find((file) => fs.existsSync(file));
    if (own) return [own];
    if (fs.existsSync(this._installed)) {
      const { command } = JSON.parse(fs.readFileSync(this._installed, "utf8"));
      if (fs.existsSync(command[0])) return command;
    }
    return ["fieldrig"];
  }

  // Start fieldrig, without waiting for it.
  start(uri, words, options = {}) {
    const [program, ...first] = this.command(uri);
    this.log.appendLine(["fieldrig", ...words].join(" "));
    const environment = { ...process.env, PYTHONIOENCODING: "utf-8" };
    return childProcess.spawn(program, [...first, ...words], { cwd: this.folder(uri), env: environment, ...options });
  }

  // Run fieldrig to its end: { code, stdout, stderr }. A cancelled run has the code null; an error if it cannot be started.
  run(uri, words, { input = "", token, onLine } = {}) {
    return new Promise((resolve, reject) => {
      const child = this.start(uri, words);
      const out = { stdout: [], stderr: [] };
      for (const name of Object.keys(out)) child[name].on("data", (data) => out[name].push(data));
      if (onLine) readline.createInterface({ input: child.stdout }).on("line", onLine);
      const cancelled = token?.onCancellationRequested(() => child.kill());
      child.on("error", (cause) => reject(new Error(`fieldrig cannot be started: ${cause.message}`)));
      child.on("close", (code) => {
        cancelled?.dispose();
        const text = (name) => Buffer.concat(out[name]).toString("utf8");
        resolve({ code, stdout: text("stdout"), stderr: text("stderr") });
      });
      child.stdin.on("error", () => {}); // it has ended before it read all; its exit code says why
      child.stdin.end(input);
    });
  }

  // Run fieldrig, and return what it prints as JSON; an error with its own words if it prints something else.
  async json(uri, words, options) {
    const { stdout, stderr } = await this.run(uri, words, options);
    try {
      return JSON.parse(stdout);
    } catch {
      throw new Error(stderr.trim() || `fieldrig ${words[0]} has answered ${JSON.stringify(stdout.slice(0, 100))}`);
    }
  }

  // Run fieldrig, and give each value of the list that it prints to `take`, as soon as it is there.
  async each(uri, words, { token }, take) {
    const onLine = (line) => {
      if (/^[[,]{/.test(line)) take(JSON.parse(line.slice(1)));
    };
    await this.json(uri, words, { token, onLine });
  }

  // Say what went wrong, without stopping the user.
  say(cause) {
    this.log.appendLine(`${cause.message ?? cause}`);
  }
}

exports.Fieldrig = Fieldrig;
