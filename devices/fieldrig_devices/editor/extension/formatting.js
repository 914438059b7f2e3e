// Formatting by `fieldrig iec fmt`, `pam fmt` and `arp fmt`; a text with mistakes stays as it is.
"use strict";

const vscode = require("vscode");
const { FORMATTERS } = require("./languages");

const SHOWN_MS = 5000;

async function edits(fieldrig, document, token) {
  const text = document.getText();
  const words = FORMATTERS[document.languageId](fieldrig.settings(document.uri).get("dialect"));
  const { code, stdout, stderr } = await fieldrig.run(document.uri, words, { input: text, token });
  if (code !== 0) {
    fieldrig.say(stderr.trim());
    vscode.window.setStatusBarMessage("fieldrig: a file with mistakes is not formatted", SHOWN_MS);
    return [];
  }
  const all = new vscode.Range(document.positionAt(0), document.positionAt(text.length));
  return stdout === text ? [] : [vscode.TextEdit.replace(all, stdout)];
}

exports.register = (fieldrig) => [
  vscode.languages.registerDocumentFormattingEditProvider(Object.keys(FORMATTERS), {
    provideDocumentFormattingEdits: (document, _options, token) => edits(fieldrig, document, token),
  }),
];
