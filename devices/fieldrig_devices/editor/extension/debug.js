// The debugger: it starts `fieldrig debug-adapter` for a device, and before it the rig if the session is to start one.
"use strict";

const path = require("node:path");
const vscode = require("vscode");
const { isProgram, nameIn } = require("./languages");

const LOOK_MS = 1000; // between two questions to a rig that starts
const PATIENCE_MS = 120000;

class Debugging {
  constructor(fieldrig) {
    this._fieldrig = fieldrig;
    this._rigs = new Map(); // the processes of rigs that sessions have started, by a number in their configuration
    this._last = 0;
  }

  dispose() {
    this._rigs.forEach((rig) => rig.kill("SIGINT"));
  }

  // F5 without a configuration debugs the open program: in the running rig, or else in one that names it.
  resolveDebugConfiguration(folder, configuration) {
    const { type = "fieldrig", request = "attach", name = "fieldrig" } = configuration;
    return { ...configuration, type, request, name, isOpenFile: !configuration.type };
  }

  async resolveDebugConfigurationWithSubstitutedVariables(folder, configuration) {
    const document = vscode.window.activeTextEditor?.document;
    const file = document && isProgram(document) ? document.uri : undefined;
    const where = folder?.uri ?? file;
    const control = configuration.control || this._fieldrig.settings(where).get("control");
    try {
      return await this._resolved(where, { ...configuration, control }, file);
    } catch (cause) {
      this._end(configuration);
      vscode.window.showErrorMessage(cause.message, { modal: true });
      return undefined;
    }
  }

  async _resolved(where, configuration, file) {
    const { isOpenFile, ...chosen } = configuration;
    if (chosen.request === "launch") return this._launched(where, chosen, file);
    try {
      return await this._attached(where, chosen, file);
    } catch (cause) {
      const rigs = isOpenFile && file ? await this._fieldrig.json(where, ["editor", "rigs", file.fsPath]) : [];
      if (!rigs.length) throw cause;
      const rig = await picked(rigs, (one) => path.basename(one), "The rig to start");
      return rig && this._launched(where, { ...chosen, rig }, file);
    }
  }

  async _launched(where, configuration, file) {
    const rig = (this._last += 1);
    await this._start(rig, where, configuration);
    try {
      return await this._attached(where, { ...configuration, request: "launch", started: rig }, file);
    } catch (cause) {
      this._end({ started: rig });
      throw cause;
    }
  }

  // Add the device, and the folder with its sources, from the open file if they are not given.
  async _attached(where, configuration, file) {
    const { control } = configuration;
    const all = await this._fieldrig.json(where, ["editor", "programs", "--control", control]);
    const named = all.filter((one) => !configuration.device || one.device === configuration.device);
    const own = named.filter((one) => file && nameIn(one, file));
    if (!named.length) throw new Error(`The rig has no program to debug: expected ${configuration.device ?? "a device"}`);
    const program = await picked(own.length ? own : named, (one) => one.device, "The device to debug");
    if (!program) return undefined;
    const sources = configuration.sources || (await this._sources(program, file));
    return { ...configuration, device: program.device, ...(sources ? { sources } : {}) };
  }

  async _sources(program, file) {
    const name = file && nameIn(program, file);
    if (name) return file.fsPath.slice(0, -name.length - 1);
    const found = program.files.length ? await vscode.workspace.findFiles(`**/${program.files[0]}`, undefined, 1) : [];
    return found.length ? found[0].fsPath.slice(0, -program.files[0].length - 1) : "";
  }

  // ---- rigs

  async _start(number, where, { rig, control, arguments: further = [] }) {
    const process = this._fieldrig.start(where, ["up", rig, "--control", control, "--quiet", ...further]);
    this._rigs.set(number, process);
    const told = [];
    let ended = "";
    for (const output of [process.stdout, process.stderr]) {
      output.on("data", (data) => {
        told.push(data);
        this._fieldrig.log.append(data.toString("utf8"));
      });
    }
    process.on("error", (cause) => (ended = `fieldrig cannot be started: ${cause.message}`));
    process.on("close", () => {
      this._rigs.delete(number);
      ended ||= `The rig has not started. ${Buffer.concat(told).toString("utf8").trim()}`;
    });
    const words = ["status", "--ready", "all", "--control", control];
    const until = Date.now() + PATIENCE_MS;
    while ((await this._fieldrig.run(where, words)).code !== 0) {
      if (ended || Date.now() > until) {
        this._end({ started: number });
        throw new Error(ended || `The rig is not ready after ${PATIENCE_MS / 1000} s`);
      }
      await new Promise((resolve) => setTimeout(resolve, LOOK_MS));
    }
  }

  _end({ started }) {
    this._rigs.get(started)?.kill("SIGINT"); // as Ctrl-C: the rig ends in order
  }

  // ---- sessions

  createDebugAdapterDescriptor({ configuration, workspaceFolder }) {
    const { device, control } = configuration;
    const uri = workspaceFolder?.uri;
    const [program, ...first] = this._fieldrig.command(uri);
    const words = [...first, "debug-adapter", device, "--control", control];
    return new vscode.DebugAdapterExecutable(program, words, { cwd: this._fieldrig.folder(uri) });
  }

  // A session that has not begun is not told to end, so the adapter's own end counts.
  createDebugAdapterTracker({ configuration }) {
    const end = () => this._end(configuration);
    return { onError: end, onExit: end };
  }
}

async function picked(choices, label, title) {
  if (choices.length === 1) return choices[0];
  const items = choices.map((choice) => ({ label: label(choice), choice }));
  return (await vscode.window.showQuickPick(items, { title }))?.choice;
}

exports.register = (fieldrig) => {
  const debugging = new Debugging(fieldrig);
  return [
    debugging,
    vscode.debug.registerDebugConfigurationProvider("fieldrig", debugging),
    vscode.debug.registerDebugAdapterDescriptorFactory("fieldrig", debugging),
    vscode.debug.registerDebugAdapterTrackerFactory("fieldrig", debugging),
  ];
};
