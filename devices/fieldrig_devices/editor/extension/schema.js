// The JSON Schema of rig files, with all installed kinds of devices and buses, for the YAML extension of Red Hat.
"use strict";

const vscode = require("vscode");
const { isRig } = require("./languages");

const YAML = "redhat.vscode-yaml";
const SCHEMA = "fieldrig://schema/rig";

async function offer(fieldrig) {
  const api = await vscode.extensions.getExtension(YAML)?.activate();
  if (!api) return;
  let text; // the schema is made once, when the first rig file is open
  const schema = async () => (await fieldrig.run(undefined, ["schema"])).stdout;
  const open = (resource) => vscode.workspace.textDocuments.find((one) => one.uri.toString() === resource);
  api.registerContributor(
    "fieldrig",
    (resource) => (open(resource) && isRig(open(resource)) ? SCHEMA : undefined),
    () => (text ??= schema()),
  );
}

exports.register = (fieldrig) => {
  offer(fieldrig).catch((cause) => fieldrig.say(cause));
  return [];
};
