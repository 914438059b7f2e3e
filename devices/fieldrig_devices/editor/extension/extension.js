// The extension: it registers its features, each of which is a file, and gives them the command line of fieldrig.
"use strict";

const { Fieldrig } = require("./fieldrig");

const FEATURES = ["./problems", "./formatting", "./tests", "./debug", "./hover", "./schema"];

exports.activate = (context) => {
  const fieldrig = new Fieldrig(context.extensionPath);
  for (const feature of FEATURES) {
    context.subscriptions.push(...require(feature).register(fieldrig));
  }
};
