// The languages of programs: what `fieldrig` calls them.
"use strict";

const path = require("node:path");

exports.LANGUAGES = ["st", "pam", "arp"];

// The command that formats the standard input.
exports.FORMATTERS = {
  st: (dialect) => ["iec", "fmt", "-", "--dialect", dialect],
  pam: () => ["pam", "fmt", "-"],
  arp: () => ["arp", "fmt", "-"],
};

// A YAML file is a rig if it has one of these keys at its top, as `fieldrig editor problems` judges it.
exports.isRig = (document) =>
  document.languageId === "yaml" && /^(?:devices|buses|extends)\s*:/m.test(document.getText());

exports.isProgram = (document) => exports.LANGUAGES.includes(document.languageId);

// The name that a program of a rig has for a file; nothing for a file that is not its own.
exports.nameIn = ({ files }, uri) => {
  const there = uri.fsPath.split(path.sep).join("/");
  return files.find((name) => there.endsWith(`/${name}`));
};
