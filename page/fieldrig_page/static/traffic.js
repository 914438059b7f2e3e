// The messages of buses by name: filter, pause, load, time between, and download.
import { html } from 'htm/preact';
import { useEffect, useRef, useState } from 'preact/hooks';
import { live, useAnswer, useWish } from './live.js';
import { named } from './named.js';
import { Rows } from './rows.js';

const ROW = 26; // pixels
const MOST_ROWS = 5000;
const RINGS = ['ring', 'pamring']; // each cycle is a message, and most of them say nothing new
const NARROW = '(max-width: 600px)';
// What the usual formats of downloads are, in the order in which they are offered.
const TITLES = {
  pcapng: 'for Wireshark', pcap: 'for older tools', log: 'as of candump -L', asc: 'as of CANoe, in text', blf: 'as of CANoe',
  trc: 'as of PCAN-View', mf4: 'ASAM MDF 4', csv: 'for spreadsheets', db: 'SQLite', vcd: 'waveforms', jsonl: 'JSON lines',
};
const TIME_OF_DAY = 31536e12; // instants above count from 1970, those below from the start of a rig in virtual time

export function View({ path }) {
  const [rig] = useAnswer('rig');
  if (rig === null) return html`<p class="quiet" role="status">asking ...</p>`;
  const names = Object.keys(rig.buses);
  if (names.length === 0) return html`<section><h2>Traffic</h2><p class="quiet">this rig has no bus</p></section>`;
  return html`<${Traffic} key=${path} buses=${rig.buses} first=${path || names[0]} />`;
}

function Traffic({ buses, first }) {
  const [chosen, setChosen] = useState([first]);
  const [filter, setFilter] = useState({ text: '', node: '', kind: '' });
  const [isPaused, setPaused] = useState(false);
  const [, setTick] = useState(0);
  const state = useRef({ rows: kept(), waiting: kept(), lost: 0, leftOut: 0, loads: named() });
  const [formats] = useAnswer('traces/formats');
  const paused = useRef(false);
  paused.current = isPaused;
  const [wish, setWish] = useState(null);
  const folds = wish ?? chosen.some((name) => RINGS.includes(buses[name]?.family));
  useWish('traffic', { buses: chosen, folds, ...filter });
  useEffect(() => live.on('traffic', (frame) => { take(state.current, frame, paused.current); setTick((tick) => tick + 1); }), []);
  const now = state.current;
  const order = useNarrow() ? SHORT : WHOLE;
  const pause = () => {
    if (isPaused) { append(now.rows, now.waiting.list); now.waiting = kept(); }
    setPaused(!isPaused);
  };
  const choose = (name) => setChosen((before) => (before.includes(name) ? before.filter((one) => one !== name) : [...before, name]));
  const change = (key) => (event) => setFilter((before) => ({ ...before, [key]: event.target.value }));
  return html`<section class="tall" aria-labelledby="traffic-title">
    <div class="bar">
      <h2 id="traffic-title">Traffic</h2>
      <fieldset class="choices"><legend class="hidden">buses</legend>${Object.keys(buses).map((name) => html`
        <button aria-pressed=${chosen.includes(name)} onClick=${() => choose(name)}>${name}${now.loads[name] && html`<small> ${now.loads[name]}</small>`}</button>`)}</fieldset>
    </div>
    <div class="bar">
      <label class="grow">find <input type="search" placeholder="words in the message" onInput=${change('text')} /></label>
      <label>node <input size="10" onInput=${change('node')} /></label>
      <label>kind <input size="10" list="traffic-kinds" onInput=${change('kind')} /></label>
      <datalist id="traffic-kinds">${kindsIn(now.rows.list).map((kind) => html`<option value=${kind}></option>`)}</datalist>
      <button aria-pressed=${folds} title="messages that say the same as the last one of their sort are counted in its row" onClick=${() => setWish(!folds)}>Fold repeats</button>
      <button aria-pressed=${isPaused} onClick=${pause}>${isPaused ? `Go on (${now.waiting.messages} wait)` : 'Pause'}</button>
      <button onClick=${() => { now.rows = kept(); now.waiting = kept(); setTick((tick) => tick + 1); }}>Clear</button>
    </div>
    <div class="bar">
      <p class="quiet" role="status">${now.rows.messages} messages${folds && now.rows.messages > now.rows.list.length && ` in ${now.rows.list.length} rows`}${gaps(now)}</p>
      ${chosen.map((name) => html`<span class="downloads">save ${name}: ${formatsOf(formats, buses[name]).map(({ ending }) => html` <a href=${`/api/v1/traces/${encodeURIComponent(name)}.${ending}`} download title=${TITLES[ending]}>${ending}</a>`)}</span>`)}
    </div>
    <${Rows} label="messages" count=${now.rows.list.length} height=${ROW} follows=${!isPaused}
      columns=${order.map((at) => COLUMNS[at])} row=${(index) => rowOf(now.rows.list[index], order)} />
  </section>`;
}

// The formats that can hold the messages of a bus.
function formatsOf(formats, bus) {
  const order = Object.keys(TITLES);
  const place = ({ ending }) => (order.includes(ending) ? order.indexOf(ending) : order.length);
  return (formats ?? []).filter(({ families }) => families.length === 0 || families.includes(bus.family)).sort((a, b) => place(a) - place(b));
}

function take(state, frame, isPaused) {
  if (frame.whole) { state.rows = kept(); state.waiting = kept(); }
  append(isPaused ? state.waiting : state.rows, frame.rows ?? []);
  for (const gap of Object.values(frame.gaps ?? {})) { state.lost += gap.lost ?? 0; state.leftOut += gap.left_out ?? 0; }
  if (frame.loads) state.loads = frame.loads;
}

// Rows as they came, also by their keys: messages that only repeat one count on in its row.
const kept = () => ({ list: [], byKey: new Map(), messages: 0 });

function append(rows, more) {
  for (const row of more) {
    rows.messages += row[COUNT];
    const before = rows.byKey.get(keyOf(row));
    if (before) before.splice(SINCE, 3, row[SINCE], before[COUNT] + row[COUNT], row[UNTIL]);
    else {
      rows.byKey.set(keyOf(row), row);
      rows.list.push(row);
    }
  }
  for (const row of rows.list.splice(0, Math.max(rows.list.length - MOST_ROWS, 0))) {
    rows.byKey.delete(keyOf(row));
    rows.messages -= row[COUNT];
  }
}

const SINCE = 8, COUNT = 9, UNTIL = 10; // places in a row
const keyOf = ([number, , bus]) => `${bus}/${number}`;

const COLUMNS = [{ title: 'time', look: 'number' }, { title: 'since', look: 'number' }, { title: 'bus' }, { title: 'from' }, { title: 'node' }, { title: 'kind' }, { title: 'message', look: 'about' }, { title: 'as on the bus', look: 'bytes' }];
// The order of the columns; on a telephone, what a message says comes before where it is from.
const WHOLE = [0, 1, 2, 3, 4, 5, 6, 7], SHORT = [4, 5, 6, 0, 1, 2, 3, 7];

function useNarrow() {
  const [isNarrow, setNarrow] = useState(matchMedia(NARROW).matches);
  useEffect(() => {
    const query = matchMedia(NARROW), look = () => setNarrow(query.matches);
    query.addEventListener('change', look);
    return () => query.removeEventListener('change', look);
  }, []);
  return isNarrow;
}

function rowOf(row, order) {
  const [, time, bus, sender, node, kind, text, raw, since, count, until] = row;
  const times = count > 1 && html`<b class="times" title=${`the last at ${instant(until)}`}>${count} times</b> `;
  const cells = [instant(time), since === null ? '' : duration(since), bus, sender, node, kind, html`<span title=${text}>${times}${text}</span>`, html`<code title=${raw}>${raw}</code>`];
  return {
    key: keyOf(row),
    look: kind.includes('abort') || kind.includes('exception') || kind === 'EMCY' ? 'wrong' : '',
    cells: order.map((at) => cells[at]),
  };
}

function gaps(state) {
  const lost = state.lost ? `; ${state.lost} were lost on the way` : '';
  return lost + (state.leftOut ? `; ${state.leftOut} were too many to show` : '');
}

const kindsIn = (rows) => [...new Set(rows.slice(-500).map((row) => row[5]).filter(Boolean))].sort();

export function instant(ns) {
  if (ns < TIME_OF_DAY) return (ns / 1e9).toFixed(6);
  return `${new Date(ns / 1e6).toLocaleTimeString('en-GB', { hour12: false })}.${String(Math.floor(ns / 1e3) % 1e6).padStart(6, '0')}`;
}

function duration(ns) {
  if (ns < 1e6) return `${(ns / 1e3).toFixed(0)} us`;
  return ns < 1e9 ? `${(ns / 1e6).toFixed(1)} ms` : `${(ns / 1e9).toFixed(2)} s`;
}
