// Faults: what each part can suffer as a form made from its schema, what is active, what it did, and a time line.
import { html } from 'htm/preact';
import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import { api, useLive, useWish } from './live.js';
import { Refused } from './rows.js';

const STATES = { on: 'fault', waiting: 'late', over: 'quiet' };
const MOST_LINES = 500;
// Keys that every fault may have, in a group of their own: when it begins, how long it lasts, how often it acts.
const TIMING = ['start_ms', 'duration_ms', 'when', 'nth', 'count', 'probability'];
const MEMBER_KEYS = ['node', 'receivers', 'after', 'station']; // their values are devices at the bus
const TITLES = {
  start_ms: 'begins after (ms)', duration_ms: 'lasts (ms)', when: 'begins when', nth: 'from message number',
  count: 'how many times', probability: 'probability',
};

export function View({ path, role }) {
  const { faults, lines } = useFaults();
  return html`<div class="faults">
    ${role === 'operate' && html`<${Adding} part=${path} />`}
    <${Active} faults=${faults} role=${role} />
    <${TimeLine} lines=${lines} />
  </div>`;
}

// The faults that are active, and the time line; for other views too.
export function useFaults() {
  useWish('faults', true);
  return useLive('faults', (before, frame) => ({
    faults: frame.faults ?? before.faults,
    lines: [...(frame.whole ? [] : before.lines), ...frame.lines].slice(-MOST_LINES),
  }), { faults: [], lines: [] });
}

export function Active({ faults, role, part }) {
  const [refusal, setRefusal] = useState(null);
  const shown = part === undefined ? faults : faults.filter((fault) => fault.part === part);
  const clear = async (of, number) => {
    try {
      await api('DELETE', `faults/${encodeURIComponent(of)}/${number}`);
      setRefusal(null);
    } catch (cause) {
      setRefusal(cause);
    }
  };
  return html`<section aria-labelledby="faults-active">
    <h2 id="faults-active">Given faults</h2>
    <${Refused} refusal=${refusal} />
    ${shown.length === 0 ? html`<p class="quiet">none</p>` : html`<div class="wide" tabindex="0" role="region" aria-label="table of the faults"><table>
      <thead><tr><th>part</th><th class="number">no.</th><th>fault</th><th>how</th><th>state</th><th class="number">left</th><th class="number">applied</th>${role === 'operate' && html`<th>do</th>`}</tr></thead>
      <tbody>${shown.map((fault) => html`<tr key=${`${fault.part}/${fault.number}`}>
        <th scope="row">${fault.part}</th><td class="number">${fault.number}</td><td>${fault.what}</td><td>${how(fault)}</td>
        <td><span class=${`pill ${STATES[fault.state] ?? ''}`}>${fault.state}</span></td><td class="number">${left(fault)}</td><td class="number">${times(fault.applied)}</td>
        ${role === 'operate' && html`<td><button onClick=${() => clear(fault.part, fault.number)} aria-label=${`Clear fault ${fault.number} of ${fault.part}`}>Clear</button></td>`}
      </tr>`)}</tbody></table></div>`}
  </section>`;
}

// What is left of a fault: time, if it lasts for some, and messages, if it acts on so many.
const left = ({ state, left_ms: ms, count, applied }) => [
  ms === undefined ? '' : ms < 10000 ? `${(ms / 1000).toFixed(1)} s` : `${Math.ceil(ms / 1000)} s`,
  count === undefined || count === null || state === 'over' ? '' : times(Math.max(count - applied, 0)),
].filter(Boolean).join(', ');
const times = (count) => `${count} ×`;
const how = (fault) => Object.entries(fault)
  .filter(([key]) => !['part', 'number', 'what', 'state', 'applied', 'left_ms'].includes(key))
  .map(([key, value]) => `${key}=${['identifier', 'mask'].includes(key) ? `0x${value.toString(16)}` : value}`).join(' ');

function Adding({ part: given }) {
  const [kinds, setKinds] = useState(null);
  const [part, setPart] = useState('');
  const [what, setWhat] = useState('');
  const [refusal, setRefusal] = useState(null);
  const [done, setDone] = useState('');
  const form = useRef(null);
  useEffect(() => { api('GET', 'faults/kinds').then(setKinds, setRefusal); }, []);
  const parts = useMemo(() => Object.keys(kinds?.parts ?? {}), [kinds]);
  const chosen = part || given || parts[0];
  const known = kinds?.kinds[kinds.parts[chosen]?.kind] ?? {};
  const fault = what in known ? what : Object.keys(known)[0];
  if (kinds === null) return html`<section><h2>New fault</h2><p class="quiet" role="status">asking ...</p><${Refused} refusal=${refusal} /></section>`;
  const send = async (event) => {
    event.preventDefault();
    const body = { part: chosen, what: fault };
    for (const [key, text] of new FormData(form.current)) if (text.trim() !== '') body[key] = text.trim();
    try {
      const { number } = await api('POST', 'faults', body);
      setRefusal(null);
      setDone(`fault ${number} of ${chosen} is given`);
    } catch (cause) {
      setDone('');
      setRefusal(cause);
    }
  };
  const groups = { bus: [], device: [] };
  for (const name of parts) groups[kinds.parts[name].sort]?.push(name);
  return html`<section aria-labelledby="faults-new">
    <h2 id="faults-new">New fault</h2>
    <div class="fields">
      <div class="field"><label for="fault-part">part</label><select id="fault-part" onChange=${(event) => { setPart(event.target.value); setWhat(''); }}>
        ${Object.entries(groups).map(([sort, names]) => names.length > 0 && html`<optgroup label=${sort === 'bus' ? 'buses' : 'devices'}>${names.map((name) => html`<option selected=${name === chosen}>${name}</option>`)}</optgroup>`)}</select></div>
      <div class="field"><label for="fault-what">fault</label><select id="fault-what" disabled=${!fault} onChange=${(event) => setWhat(event.target.value)}>${Object.keys(known).map((name) => html`<option selected=${name === fault}>${name}</option>`)}</select></div>
    </div>
    ${fault ? html`<${Form} key=${`${chosen}/${fault}`} schema=${known[fault]} members=${kinds.parts[chosen].members} form=${form} onSubmit=${send} />`
      : html`<p class="quiet">${kinds.parts[chosen]?.none || 'this part takes no faults'}</p>`}
    <${Refused} refusal=${refusal} />
    <p class="quiet" role="status">${done}</p>
  </section>`;
}

function Form({ schema, members, form, onSubmit }) {
  const keys = Object.keys(schema.properties);
  const own = keys.filter((key) => !TIMING.includes(key));
  const timing = keys.filter((key) => TIMING.includes(key));
  const field = (key) => html`<${Field} key=${key} name=${key} schema=${schema} offers=${MEMBER_KEYS.includes(key) ? members : []} isNeeded=${schema.required.includes(key)} />`;
  return html`<form ref=${form} onSubmit=${onSubmit}>
    <p>${withCode(schema.about)}</p>
    ${own.length > 0 && html`<fieldset><legend>what and where</legend><div class="fields">${own.map(field)}</div></fieldset>`}
    <fieldset><legend>when, how long, how often</legend><div class="fields">${timing.map(field)}</div></fieldset>
    <button class="main">Give the fault</button>
  </form>`;
}

// Words between backticks are keys or values.
const withCode = (text) => text.split('`').map((part, at) => (at % 2 ? html`<code>${part}</code>` : part));

// A field for one key.  Everything goes as a text, as on the command line, so the rig itself says what is wrong.
function Field({ name, schema, offers, isNeeded }) {
  const property = schema.properties[name];
  const id = `fault-${name}`;
  const choices = choicesOf(property, schema.$defs);
  const described = property.description ? `${id}-about` : null;
  const hint = property.default === undefined || property.default === null ? '' : String(property.default);
  const list = offers.length > 0 ? `${id}-list` : null;
  return html`<div class="field">
    <label for=${id}>${TITLES[name] ?? name.replaceAll('_', ' ')}${isNeeded && html` <span class="quiet">(needed)</span>`}</label>
    ${choices
      ? html`<select id=${id} name=${name} required=${isNeeded} aria-describedby=${described}>${!isNeeded && html`<option value="">${hint || 'left out'}</option>`}${choices.map((choice) => html`<option>${choice}</option>`)}</select>`
      : html`<input id=${id} name=${name} required=${isNeeded} placeholder=${hint} aria-describedby=${described} list=${list} spellcheck=${false} autocomplete="off" />`}
    ${list && html`<datalist id=${list}>${offers.map((name) => html`<option value=${name}></option>`)}</datalist>`}
    ${described && html`<small id=${described} class="quiet">${withCode(property.description)}</small>`}
  </div>`;
}

// The choices of a property that is an enumeration or a truth, also if it may be left out; null for any other.
function choicesOf(property, definitions) {
  const forms = [property, ...(property.anyOf ?? [])].map((form) => (form.$ref ? definitions[form.$ref.split('/').pop()] : form));
  const listed = forms.flatMap((form) => form?.enum ?? (form?.const === undefined ? [] : [form.const]));
  const kinds = forms.map((form) => form?.type).filter((type) => type && type !== 'null');
  if (listed.length > 0 && kinds.every((type) => type === 'string')) return listed;
  return kinds.length > 0 && kinds.every((type) => type === 'boolean') ? ['true', 'false'] : null;
}

export function TimeLine({ lines }) {
  const newest = [...lines].reverse();
  return html`<section aria-labelledby="faults-line">
    <h2 id="faults-line">What happened</h2>
    ${newest.length === 0 ? html`<p class="quiet">nothing since this page’s server has started</p>` : html`<div class="line" role="log" tabindex="0" aria-label="what happened, newest first"><ol>${newest.map((line) => html`
      <li key=${line.number}><time datetime=${new Date(line.time_ns / 1e6).toISOString()}>${clock(line.time_ns)}</time>
        <span class=${`pill ${line.is_over ? 'ok' : line.kind === 'event' ? 'quiet' : 'fault'}`}>${line.is_over ? 'over' : line.kind}</span>
        <span><b>${line.part}</b> ${[line.key, line.text].filter(Boolean).join(': ')}</span></li>`)}</ol></div>`}
  </section>`;
}

const clock = (ns) => new Date(ns / 1e6).toLocaleTimeString('en-GB', { hour12: false });
