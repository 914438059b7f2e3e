// Visual Studio Code's own test support goes back in time: node back.js ADAPTER SOURCE
// ADAPTER is a shell script that starts the debug adapter; prints the session, a line for each request and each stop.

const { DebugClient } = require("@vscode/debugadapter-testsupport");

const lines = [];

class Session {
  constructor(adapter, source) {
    this.client = new DebugClient("/bin/sh", adapter, "fieldrig");
    this.client.defaultTimeout = 120000;
    this.source = source;
  }

  // Send a request after which the program stops, and note where it does, and the value of `a` there.
  async stops(asked, send) {
    lines.push(`-> ${asked}`);
    const stopped = this.client.waitForEvent("stopped");
    await send();
    const { reason, threadId } = (await stopped).body;
    const [top] = (await this.client.stackTraceRequest({ threadId })).body.stackFrames;
    const { body } = await this.client.evaluateRequest({ expression: "PLC_PRG.a", frameId: top.id });
    lines.push(`<- ${reason}: ${top.name} at ${top.source.name}:${top.line}, a = ${body.result}`);
    return threadId;
  }

  breakpoint(line, condition) {
    const breakpoints = [{ line, condition }];
    return this.client.setBreakpointsRequest({ source: { path: this.source }, breakpoints });
  }
}

async function main([adapter, source]) {
  const session = new Session(adapter, source);
  const { client } = session;
  await client.start();
  const initialized = client.waitForEvent("initialized");
  const { body: can } = await client.initializeRequest();
  lines.push("-> initialize", `<- supportsStepBack: ${can.supportsStepBack}`);
  await initialized;
  await client.attachRequest({ sources: source.replace(/\/[^/]*$/, "") });
  const first = client.waitForEvent("stopped"); // the running program can stop as soon as the breakpoint is there
  const { body: set } = await session.breakpoint(8, "a > 100");
  await client.configurationDoneRequest();
  const { threadId } = (await first).body;
  lines.push("-> setBreakpoints: 8 if a > 100", `<- line ${set.breakpoints[0].line}, and the program stops`);
  await session.stops("setBreakpoints: 8 if a = 20; reverseContinue", async () => {
    await session.breakpoint(8, "a = 20");
    await client.reverseContinueRequest({ threadId });
  });
  await session.stops("stepIn", () => client.stepInRequest({ threadId }));
  await session.stops("stepBack", () => client.stepBackRequest({ threadId }));
  await session.stops("stepBack", () => client.stepBackRequest({ threadId }));
  await session.stops("setExpression: PLC_PRG.a := 50; setBreakpoints: 8 if a > 50; continue", async () => {
    await client.send("setExpression", { expression: "PLC_PRG.a", value: "50" });
    await session.breakpoint(8, "a > 50");
    await client.continueRequest({ threadId });
  });
  await client.stop();
}

main(process.argv.slice(2)).then(
  () => { console.log(lines.join("\n")); process.exit(0); },
  (cause) => { console.error(cause, lines); process.exit(1); },
);
