// Live values under the cursor: from the debugging session, or from the running rig. While a program stands, the editor
// itself asks the session for the values of the frame.
"use strict";

const vscode = require("vscode");
const { expressionAt, scopeAt } = require("./expressions");
const { LANGUAGES, nameIn } = require("./languages");
const { Live } = require("./live");

const MOST_INSTANCES = 5; // of a block, whose values are shown together
const MOST_GROUPS = 100; // of variables, in which instances are searched

async function hover(live, document, position) {
  const session = vscode.debug.activeDebugSession;
  const isOurs = session?.type === "fieldrig";
  if (isOurs && vscode.debug.activeStackItem instanceof vscode.DebugStackFrame) return undefined;
  const found = expressionAt(document.languageId, document.lineAt(position.line).text, position.character);
  if (!found) return undefined;
  const ask = isOurs ? (command, question) => session.customRequest(command, question) : await live.asker(document.uri, nameIn);
  if (!ask) return undefined;
  const before = document.getText(new vscode.Range(0, 0, position.line, 0));
  const names = await namesOf(ask, document.languageId === "st" ? scopeAt(before) : undefined, found.text);
  const values = (await ask("fieldrig.read", { names }))?.variables.filter((one) => !one.error) ?? [];
  if (!values.length) return undefined;
  const shown = new vscode.MarkdownString();
  shown.appendCodeblock(values.map(line).join("\n"), document.languageId);
  return new vscode.Hover(shown, new vscode.Range(position.line, found.start, position.line, found.end));
}

// A variable of a program has its name in front; one of a block is in each instance.
async function namesOf(ask, scope, text) {
  if (scope?.kind !== "FUNCTION_BLOCK" && scope?.kind !== "CLASS") return scope ? [`${scope.name}.${text}`, text] : [text];
  return [...(await instances(ask, scope.name)).map((path) => `${path}.${text}`), text];
}

async function instances(ask, type) {
  const found = [];
  const open = [""];
  for (let asked = 0; open.length && asked < MOST_GROUPS && found.length < MOST_INSTANCES; asked += 1) {
    const answer = await ask("fieldrig.variables", { path: open.shift() });
    for (const one of answer?.variables ?? []) {
      if (one.value !== null) continue;
      if (one.type.toUpperCase() === type.toUpperCase()) found.push(one.path);
      else open.push(one.path);
    }
  }
  return found.slice(0, MOST_INSTANCES);
}

function line({ path: name, value, text, type, is_forced: isForced }) {
  const shown = value === null ? type : text || (typeof value === "boolean" ? String(value).toUpperCase() : String(value));
  return `${name} = ${shown}${isForced ? "  (forced)" : ""}`;
}

// What the editor evaluates by itself while a program stands.
function evaluatable(document, position) {
  const found = expressionAt(document.languageId, document.lineAt(position.line).text, position.character);
  if (!found) return undefined;
  const range = new vscode.Range(position.line, found.start, position.line, found.end);
  return new vscode.EvaluatableExpression(range, found.text);
}

exports.register = (fieldrig) => {
  const live = new Live(fieldrig);
  return [
    live,
    vscode.languages.registerHoverProvider(LANGUAGES, {
      provideHover: (document, position) => hover(live, document, position),
    }),
    vscode.languages.registerEvaluatableExpressionProvider(LANGUAGES, { provideEvaluatableExpression: evaluatable }),
  ];
};
