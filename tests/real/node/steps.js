// Visual Studio Code's own test support steps in a program and back: node steps.js ADAPTER SOURCE LINE EXPRESSION
// ADAPTER is a shell script that starts the debug adapter; prints the session, a line for each request and its stop.

const { DebugClient } = require("@vscode/debugadapter-testsupport");

async function main([adapter, source, line, expression]) {
  const lines = [];
  const client = new DebugClient("/bin/sh", adapter, "fieldrig");
  client.defaultTimeout = 120000;
  await client.start();
  const initialized = client.waitForEvent("initialized");
  await client.initializeRequest();
  await initialized;
  await client.attachRequest({ sources: source.replace(/\/[^/]*$/, "") });

  // Send requests after which the program stops, and note where it does, and the value of the expression there.
  const stops = async (asked, send) => {
    const stopped = client.waitForEvent("stopped");
    await send();
    const { reason, threadId } = (await stopped).body;
    const [top] = (await client.stackTraceRequest({ threadId })).body.stackFrames;
    const { body } = await client.evaluateRequest({ expression, frameId: top.id });
    lines.push(`${asked} -> ${reason}: ${top.name} at ${top.source.name}:${top.line}, ${expression} = ${body.result}`);
    return threadId;
  };
  const threadId = await stops(`setBreakpoints ${line}`, async () => {
    await client.setBreakpointsRequest({ source: { path: source }, breakpoints: [{ line: Number(line) }] });
    await client.configurationDoneRequest();
  });
  await stops("next", () => client.nextRequest({ threadId }));
  await stops("stepBack", () => client.stepBackRequest({ threadId }));
  await stops("reverseContinue", () => client.reverseContinueRequest({ threadId }));
  await client.stop();
  return lines;
}

main(process.argv.slice(2)).then(
  (lines) => { console.log(lines.join("\n")); process.exit(0); },
  (cause) => { console.error(cause); process.exit(1); },
);
