// The extension with the real fieldrig, and a stand-in for the editor: what it shows of a folder, as JSON.
// node --require with_vscode.js extension.js EXTENSION FOLDER CONTROL COMMAND...
"use strict";

const fs = require("node:fs");
const path = require("node:path");
const vscode = require("vscode");

const [extension, folder, control, ...command] = process.argv.slice(2);
const LOOK_MS = 100;

async function until(what) {
  for (;;) {
    const found = await what();
    if (found) return found;
    await new Promise((resolve) => setTimeout(resolve, LOOK_MS));
  }
}

function opened(name, language) {
  const file = path.join(folder, name);
  const document = new vscode.Document(vscode.Uri.file(file), language, fs.readFileSync(file, "utf8"));
  vscode.workspace.textDocuments.push(document);
  return document;
}

async function problems(document) {
  await vscode.events.opened.fire(document);
  const found = vscode.registered.diagnostics.get(document.uri.fsPath) ?? [];
  return found.map(({ range, message, severity }) => [range.start.line + 1, range.start.character + 1, severity, message]);
}

async function outcomes() {
  const [controller] = vscode.registered.controllers;
  await until(() => controller.items.size);
  await controller.profiles[1].run({}, new vscode.CancellationTokenSource().token);
  const { outcomes: seen, covered } = controller.lastRun;
  const failures = (messages) => (Array.isArray(messages) ? messages : []); // of a passed test it is the time
  const told = ({ message, location }) => [message.split("\n")[0], location.position.line + 1];
  return {
    tests: seen.map(({ verdict, name, messages }) => [verdict, name, ...failures(messages).map(told)]),
    covered: covered.map((one) => path.basename(one.uri.fsPath)),
  };
}

async function formatted(document) {
  const [edit] = await vscode.registered.formatters[0].provideDocumentFormattingEdits(document);
  return edit.newText;
}

// F5 starts the rig that names the open program; its values are under the cursor; the rig ends with the session.
async function debugged(document) {
  vscode.window.activeTextEditor = { document };
  const { configurations, adapters } = vscode.registered.debuggers;
  const asked = configurations.resolveDebugConfiguration(undefined, {});
  const [workspaceFolder] = vscode.workspace.workspaceFolders;
  const configuration = await configurations.resolveDebugConfigurationWithSubstitutedVariables(workspaceFolder, asked);
  if (!configuration) throw new Error(vscode.registered.errors.join("\n"));
  const adapter = adapters.createDebugAdapterDescriptor({ configuration, workspaceFolder });
  const position = new vscode.Position(2, 0);
  const hover = await until(() => vscode.registered.hovers[0].provideHover(document, position));
  vscode.registered.debuggers.trackers.createDebugAdapterTracker({ configuration }).onExit();
  return {
    request: configuration.request,
    device: configuration.device,
    sources: path.relative(folder, configuration.sources),
    adapter: adapter.args.slice(adapter.args.indexOf("debug-adapter")),
    hover: hover.contents.value,
  };
}

async function main() {
  Object.assign(vscode.settings, { command, control, dialect: "epas-4" });
  vscode.workspace.workspaceFolders = [{ uri: vscode.Uri.file(folder) }];
  const context = { extensionPath: extension, subscriptions: [] };
  require(path.join(extension, "extension.js")).activate(context);
  const count = opened("programs/count.st", "st");
  const seen = {
    ...(await outcomes()),
    wrong: await problems(opened("bad.st", "st")),
    formatted: await formatted(opened("bad.st", "st")),
    ...(await debugged(count)),
  };
  context.subscriptions.forEach((one) => one.dispose());
  return seen;
}

main().then(
  (seen) => console.log(JSON.stringify(seen)),
  (cause) => {
    console.error(cause, vscode.registered.log.join("\n"));
    process.exit(1);
  },
);
