// Loaded first, by `node --require`: `require("vscode")` is the stand-in beside this file.
"use strict";

const Module = require("node:module");
const path = require("node:path");

const resolve = Module._resolveFilename;
Module._resolveFilename = (name, ...others) =>
  name === "vscode" ? path.join(__dirname, "vscode.js") : resolve(name, ...others);
