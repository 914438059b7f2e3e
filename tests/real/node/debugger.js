// A debugger of Visual Studio Code's own test support: node debugger.js ADAPTER SOURCE ASKED LINE CONDITION
// ADAPTER is a shell script that starts the debug adapter, and a breakpoint that is asked for at line ASKED stops at LINE;
// prints what it has seen as JSON.

const { DebugClient } = require("@vscode/debugadapter-testsupport");

async function main([adapter, source, asked, line, condition]) {
  const client = new DebugClient("/bin/sh", adapter, "fieldrig");
  client.defaultTimeout = 60000;
  await client.start();
  const initialized = client.waitForEvent("initialized");
  const { body: can } = await client.initializeRequest();
  await initialized;
  await client.attachRequest({ sources: source.replace(/\/[^/]*$/, "") });
  // The running program can stop as soon as the breakpoint is there.
  const stopped = client.assertStoppedLocation("breakpoint", { path: source, line: +line });
  const set = await client.setBreakpointsRequest({ source: { path: source }, breakpoints: [{ line: +asked, condition }] });
  await client.configurationDoneRequest();
  const stack = (await stopped).body.stackFrames;
  const thread = (await client.threadsRequest()).body.threads[0];
  const value = await client.evaluateRequest({ expression: "a", frameId: stack[0].id });
  const stepped = client.waitForEvent("stopped");
  await client.stepInRequest({ threadId: thread.id });
  const reason = (await stepped).body.reason;
  const inside = (await client.stackTraceRequest({ threadId: thread.id })).body.stackFrames;
  const scopes = (await client.scopesRequest({ frameId: inside[0].id })).body.scopes;
  const roots = await client.variablesRequest({ variablesReference: scopes[scopes.length - 1].variablesReference });
  await client.setBreakpointsRequest({ source: { path: source }, breakpoints: [] });
  await client.continueRequest({ threadId: thread.id });
  await client.stop();
  return {
    conditions: can.supportsConditionalBreakpoints,
    verified: set.body.breakpoints.map((breakpoint) => breakpoint.verified),
    lines: set.body.breakpoints.map((breakpoint) => breakpoint.line),
    thread: thread.name,
    above: Number(value.body.result),
    reason,
    stack: inside.map((frame) => [frame.name, frame.line]),
    roots: roots.body.variables.map((variable) => variable.name),
  };
}

main(process.argv.slice(2)).then(
  (seen) => { console.log(JSON.stringify(seen)); process.exit(0); },
  (cause) => { console.error(cause); process.exit(1); },
);
