// Values of a program in the running rig, without a session of the editor: questions to a debug adapter that attaches
// to nothing, so that the program and the breakpoints of others stay as they are.
"use strict";

const IDLE_MS = 60000; // after which the adapter is ended
const AGAIN_MS = 10000; // between two looks for a rig that is not there

class Live {
  constructor(fieldrig) {
    this._fieldrig = fieldrig;
    this._adapters = new Map(); // by the device and the endpoint
    this._programs = undefined; // the answer about the running rig, or its failure
    this._asked = 0;
  }

  dispose() {
    this._adapters.forEach((adapter) => adapter.end());
  }

  // Return a function that asks the device with a file's program, or nothing if no rig runs it.
  async asker(uri, nameIn) {
    const control = this._fieldrig.settings(uri).get("control");
    const programs = await this._known(uri, control);
    const program = programs.find((one) => nameIn(one, uri));
    if (!program) return undefined;
    const key = `${program.device} ${control}`;
    if (!this._adapters.has(key)) {
      const process = this._fieldrig.start(uri, ["debug-adapter", program.device, "--control", control]);
      this._adapters.set(key, new Adapter(process, () => this._adapters.delete(key)));
    }
    return (command, question) => this._adapters.get(key)?.ask(command, question);
  }

  async _known(uri, control) {
    if (!this._programs || Date.now() - this._asked > AGAIN_MS) {
      this._asked = Date.now();
      this._programs = this._fieldrig.json(uri, ["editor", "programs", "--control", control]).catch(() => []);
    }
    return this._programs;
  }
}

// One process that speaks the Debug Adapter Protocol.
class Adapter {
  constructor(process, onEnd) {
    this._process = process;
    this._waiting = new Map();
    this._sequence = 0;
    this._data = Buffer.alloc(0);
    process.stdout.on("data", (data) => this._take(data));
    process.stdin.on("error", () => {}); // its end is told by "close"
    process.on("error", () => this._over(onEnd));
    process.on("close", () => this._over(onEnd));
  }

  ask(command, question) {
    clearTimeout(this._timer);
    this._timer = setTimeout(() => this.end(), IDLE_MS);
    this._timer.unref?.();
    const seq = (this._sequence += 1);
    const text = JSON.stringify({ seq, type: "request", command, arguments: question });
    return new Promise((resolve) => {
      this._waiting.set(seq, resolve);
      this._process.stdin.write(`Content-Length: ${Buffer.byteLength(text)}\r\n\r\n${text}`);
    });
  }

  end() {
    clearTimeout(this._timer);
    this._process.stdin.end();
    this._process.kill();
  }

  _over(onEnd) {
    clearTimeout(this._timer);
    this._waiting.forEach((resolve) => resolve(undefined));
    this._waiting.clear();
    onEnd();
  }

  _take(data) {
    this._data = Buffer.concat([this._data, data]);
    for (;;) {
      const end = this._data.indexOf("\r\n\r\n");
      const length = /Content-Length: *(\d+)/i.exec(this._data.subarray(0, Math.max(end, 0)).toString());
      if (!length || this._data.length < end + 4 + Number(length[1])) return;
      const message = JSON.parse(this._data.subarray(end + 4, end + 4 + Number(length[1])).toString("utf8"));
      this._data = this._data.subarray(end + 4 + Number(length[1]));
      if (message.type !== "response") continue;
      this._waiting.get(message.request_seq)?.(message.success ? message.body : undefined);
      this._waiting.delete(message.request_seq);
    }
  }
}

exports.Live = Live;
