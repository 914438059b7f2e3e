// The connection to the page's server: what this page wants to see, what comes of it, and calls of the HTTP API.
// It reconnects by itself and asks again for everything that is wanted; the first frame of each topic is whole.
import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks';
import { asNamed } from './named.js';
import { decode, encode } from './wire.js';

const FIRST_PAUSE_MS = 250;
const LONGEST_PAUSE_MS = 4000;
const SILENT_MS = 5000; // without a word of the server, until it is asked whether it is there
const UNSUPPORTED = 1003; // the close code for a message that is not understood

export let role = 'look';

class Live {
  // connecting, open, silent (the server does not answer), away (its connection is closed), refused (the token is no longer good)
  state = 'connecting';
  greeting = null;
  #handlers = new Map();
  #wishes = new Map();
  #socket = null;
  #pause = FIRST_PAUSE_MS;
  #last = null; // the topic that was wanted last
  #heardMs = 0;
  #isLooking = false;

  constructor() {
    setInterval(() => this.#look(), SILENT_MS / 5);
  }

  // Calls `handler(message)` for each message of a type, which is the name of its topic, or "state".
  on(type, handler) {
    if (!this.#handlers.has(type)) this.#handlers.set(type, new Set());
    this.#handlers.get(type).add(handler);
    return () => this.#handlers.get(type).delete(handler);
  }

  // Shows a topic from now on, and returns what ends that, unless another wish for the topic has replaced this one: what
  // is drawn no longer is cleaned up after what is drawn in its place has begun.
  want(topic, wish) {
    const own = { wish };
    this.#wishes.set(topic, own);
    this.#askNow(topic, wish);
    return () => {
      if (this.#wishes.get(topic) !== own) return;
      this.#wishes.delete(topic);
      this.#askNow(topic, null);
    };
  }

  #askNow(topic, wish) {
    if (this.state === 'open' || this.state === 'silent') this.#ask(topic, wish);
  }

  #ask(topic, wish) {
    this.#last = topic;
    this.#send({ t: 'want', topic, wish });
  }

  open() {
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    const socket = new WebSocket(`${scheme}://${location.host}/live`);
    this.#socket = socket;
    socket.binaryType = 'arraybuffer';
    socket.onmessage = (event) => this.#take(event.data);
    socket.onclose = (event) => this.#onClose(event);
  }

  // A server that hangs keeps its connections, and what it has sent before would pass for the present.
  async #look() {
    const heardMs = this.#heardMs;
    const isThere = this.state === 'open' || this.state === 'silent';
    if (!isThere || this.#isLooking || performance.now() - heardMs < SILENT_MS) return;
    this.#isLooking = true;
    const status = await statusOf(AbortSignal.timeout(SILENT_MS));
    this.#isLooking = false;
    if (this.#heardMs !== heardMs) return;
    if (status !== null) this.#hear();
    else if (this.state === 'open') this.#become('silent');
  }

  #hear() {
    this.#heardMs = performance.now();
    if (this.state === 'silent') this.#become('open');
  }

  #take(data) {
    this.#hear();
    const [number, ...messages] = decode(data);
    for (const message of messages) {
      if (message.t === 'hello') this.#greet(message);
      else this.#tell(message.t, message);
    }
    this.#send({ t: 'seen', number });
  }

  #greet(hello) {
    if (this.greeting !== null && this.greeting.build !== hello.build) location.reload();
    this.greeting = hello;
    role = hello.role;
    this.#pause = FIRST_PAUSE_MS;
    this.#become('open');
    for (const [topic, { wish }] of this.#wishes) this.#ask(topic, wish);
  }

  async #onClose({ code, reason }) {
    if (code === UNSUPPORTED) this.#drop(reason);
    this.#become((await isRefused()) ? 'refused' : 'away');
    setTimeout(() => this.open(), this.#pause);
    this.#pause = Math.min(2 * this.#pause, LONGEST_PAUSE_MS);
  }

  // What the server does not understand is not wanted again: every further connection would end by it.
  #drop(reason) {
    const [named] = reason.split(': ', 1), isNamed = this.#wishes.has(named);
    const topic = isNamed ? named : this.#last;
    this.#wishes.delete(topic);
    this.#tell('refused', { topic, what: isNamed ? reason.slice(named.length + 2) : reason });
  }

  #become(state) {
    this.state = state;
    this.#tell('state', { t: 'state', state });
  }

  #tell(type, message) {
    for (const handler of this.#handlers.get(type) ?? []) handler(message);
  }

  #send(message) {
    if (this.#socket.readyState === WebSocket.OPEN) this.#socket.send(encode(message));
  }
}

const isRefused = async () => (await statusOf()) === 401;

// The status of a small question to the server; null if there is no server that answers.
async function statusOf(signal) {
  try {
    return (await fetch('/api/v1/openapi.json', { method: 'HEAD', signal })).status;
  } catch {
    return null;
  }
}

export const live = new Live();

// A value that each message of a type changes: `reduce(value, message)`.  It listens from the moment it is drawn: an
// effect after the next picture may come later than the greeting of a server that is near.
export function useLive(type, reduce, initial) {
  const [value, setValue] = useState(initial);
  const latest = useRef(reduce);
  latest.current = reduce;
  useLayoutEffect(() => live.on(type, (message) => setValue((before) => latest.current(before, message))), [type]);
  return value;
}

// Wants a topic for as long as the component is shown.
export function useWish(topic, wish) {
  useEffect(() => live.want(topic, wish), [topic, JSON.stringify(wish)]);
}

// Why the server refused topics that the page wanted, as pairs of both, until there is a frame of the topic.
export function useRefusals() {
  const [refusals, setRefusals] = useState({});
  useLayoutEffect(() => live.on('refused', ({ topic, what }) => {
    setRefusals((before) => ({ ...before, [topic]: what }));
    const off = live.on(topic, () => { off(); setRefusals(({ [topic]: _, ...others }) => others); });
  }), []);
  return Object.entries(refusals);
}

// What a GET of the API gives, as [answer, refusal].  Asked again when `path` or `times` changes, and after a reconnect.
export function useAnswer(path, times = 0) {
  const [known, setKnown] = useState({ path, answer: NONE });
  useEffect(() => {
    if (path === null) return undefined; // not known yet
    let isShown = true;
    const ask = () => api('GET', path).then(
      (given) => { if (isShown) setKnown({ path, answer: [given, null] }); },
      (cause) => { if (isShown) setKnown((before) => ({ path, answer: [before.path === path ? before.answer[0] : null, cause] })); },
    );
    ask();
    const off = live.on('state', ({ state }) => { if (state === 'open') ask(); });
    return () => { isShown = false; off(); };
  }, [path, times]);
  return known.path === path ? known.answer : NONE;
}
const NONE = [null, null];

// A module that is loaded when it is shown, as [module, trouble].  A browser does not ask for one that has failed again,
// so the page is loaded again when its server is back.
export function useModule(load) {
  const [loaded, setLoaded] = useState([null, '']);
  useEffect(() => {
    let off = () => {};
    load().then(
      (module) => setLoaded([module, '']),
      (cause) => {
        setLoaded([null, cause.message]);
        off = live.on('state', ({ state }) => { if (state === 'open') location.reload(); });
      },
    );
    return () => off();
  }, []);
  return loaded;
}

export class Refusal extends Error {
  constructor(status, what, remedy) {
    super(what);
    Object.assign(this, { status, what, remedy });
  }
}

// A name or key in a path of the API: its slashes stay.
export const inPath = (name) => name.split('/').map(encodeURIComponent).join('/');

// A call of the HTTP API, such as api('PUT', 'devices/tank/points/level', {value: 1.25}).  Throws a Refusal.
export async function api(method, path, body) {
  const options = { method };
  if (body !== undefined) Object.assign(options, { body: JSON.stringify(body), headers: { 'content-type': 'application/json' } });
  let answer;
  try {
    answer = await fetch(`/api/v1/${path}`, options);
  } catch {
    throw new Refusal(0, 'the page’s server does not answer', 'the page connects again by itself; or start the rig again');
  }
  const type = answer.headers.get('content-type') ?? '';
  const given = type.startsWith('application/json') ? JSON.parse(await answer.text(), asNamed) : { what: await answer.text(), remedy: '' };
  if (!answer.ok) throw new Refusal(answer.status, given.what, given.remedy);
  return given;
}
