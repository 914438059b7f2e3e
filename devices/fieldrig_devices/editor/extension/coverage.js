// Coverage in LCOV's form, as the editor shows it: how often each line ran, and which branches.
"use strict";

const path = require("node:path");
const vscode = require("vscode");

// Yield { file, details } for each file of a report, whose relative names are those of the folder.
exports.coverageOf = function* (text, folder) {
  for (const record of text.split("end_of_record")) {
    const lines = record.split(/\r?\n/);
    const name = lines.find((line) => line.startsWith("SF:"))?.slice(3);
    if (name) yield { file: path.resolve(folder, name), details: details(lines) };
  }
};

function details(lines) {
  const branches = new Map();
  for (const [line, block, branch, taken] of values(lines, "BRDA:")) {
    const found = new vscode.BranchCoverage(taken === "-" ? 0 : Number(taken), undefined, `${block}.${branch}`);
    branches.set(line, [...(branches.get(line) ?? []), found]);
  }
  return values(lines, "DA:").map(
    ([line, hits]) =>
      new vscode.StatementCoverage(Number(hits), new vscode.Position(Number(line) - 1, 0), branches.get(line) ?? []),
  );
}

function values(lines, mark) {
  return lines.filter((line) => line.startsWith(mark)).map((line) => line.slice(mark.length).split(","));
}
