// The values of devices: search, units, what they are now, and edit with the reason of a refusal beside the field.
import { html } from 'htm/preact';
import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import { nameOf, numberOrText } from './fronts/words.js';
import { api, inPath, live, useAnswer, useWish } from './live.js';
import { Rows } from './rows.js';

const ROW = 34; // pixels
const PROGRAM = 'program:';

export function View({ path, role }) {
  const [rig] = useAnswer('rig');
  const [device, setDevice] = useState(path);
  const devices = Object.keys(rig?.devices ?? {});
  useEffect(() => setDevice(path), [path]);
  const chosen = device || devices[0];
  return html`<section class="tall" aria-labelledby="values-title">
    <div class="bar">
      <h2 id="values-title">Values</h2>
      <label for="values-device">device</label><select id="values-device" value=${chosen} onChange=${(event) => { location.hash = `#/values/${encodeURIComponent(event.target.value)}`; }}>
        ${devices.map((name) => html`<option value=${name} selected=${name === chosen}>${name}</option>`)}</select>
    </div>
    ${chosen && html`<${Values} key=${chosen} device=${chosen} role=${role} />`}
  </section>`;
}

// The values of one device, also for the view of that device.
export function Values({ device, role }) {
  const [points, setPoints] = useState(null);
  const [trouble, setTrouble] = useState(null);
  const [search, setSearch] = useState('');
  const [only, setOnly] = useState(false);
  const [span, setSpan] = useState([0, 40]);
  const [, setTick] = useState(0);
  const values = useRef(new Map());
  const troubles = useRef(new Map());
  useEffect(() => {
    let isHere = true;
    load(device).then(
      (all) => {
        if (!isHere) return;
        for (const point of all) if (point.value !== undefined && isWhole(point.value)) values.current.set(point.key, point.value);
        setPoints(all);
      },
      (cause) => isHere && setTrouble(cause),
    );
    return () => { isHere = false; };
  }, [device]);
  useEffect(() => live.on('values', (frame) => {
    const own = `${device}/`;
    for (const [name, value] of Object.entries(frame.values)) {
      if (name.startsWith(own)) { values.current.set(name.slice(own.length), value); troubles.current.delete(name.slice(own.length)); }
    }
    for (const [name, text] of Object.entries(frame.troubles)) if (name.startsWith(own)) troubles.current.set(name.slice(own.length), text);
    setTick((tick) => tick + 1);
  }), [device]);
  const found = useMemo(() => filtered(points ?? [], search, only), [points, search, only]);
  const onScreen = found.slice(span[0], span[1]).map((point) => `${device}/${point.key}`);
  useWish('values', { points: onScreen });
  if (trouble) return html`<p class="refusal" role="alert">${trouble.what}</p>`;
  if (points === null) return html`<p class="quiet" role="status">asking ${device} ...</p>`;
  const put = (key, value) => {
    if (!isWhole(value)) return;
    values.current.set(key, value);
    setTick((tick) => tick + 1);
  };
  return html`
    <div class="bar">
      <label class="grow">find <input type="search" value=${search} placeholder="name, index or description" onInput=${(event) => setSearch(event.target.value)} /></label>
      <label><input type="checkbox" checked=${only} onChange=${(event) => setOnly(event.target.checked)} /> writable only</label>
      <span class="quiet" role="status">${found.length} of ${points.length} values</span>
    </div>
    <${Rows} label=${`values of ${device}`} count=${found.length} height=${ROW} onShow=${(first, last) => setSpan([first, last])}
      columns=${[{ title: 'name' }, { title: 'value', look: 'value' }, { title: 'unit' }, { title: 'type' }, { title: 'description', look: 'about' }]}
      row=${(index) => {
        const point = found[index];
        return {
          key: point.key,
          cells: [
            html`<code>${point.key}</code>`,
            html`<${Value} device=${device} point=${point} value=${values.current.get(point.key)} trouble=${troubles.current.get(point.key)} role=${role} onWritten=${put} />`,
            point.unit, typeOf(point), point.about,
          ],
        };
      }} />`;
}

async function load(device) {
  const name = encodeURIComponent(device);
  const [points, front, variables] = await Promise.all([
    api('GET', `devices/${name}/points`),
    api('GET', `devices/${name}/front`).catch(() => ({ groups: [] })), // without power it does not answer
    api('GET', `programs/${name}/values`).catch(() => []), // it has no program
  ]);
  const names = new Map(front.groups.flatMap((group) => group.parts).filter((part) => part.names?.length).map((part) => [part.point, part.names]));
  return [...points.map((point) => ({ ...point, names: names.get(point.key) })), ...variables];
}

// What a number means, as the front of the device has it, such as the name of a state.
function meaning(point, value) {
  const name = typeof value === 'number' && nameOf(value, point.names);
  return name ? html` <span class="quiet">${name}</span>` : '';
}

// Every word of the search is in the name, the type (which has the address) or the description.
function filtered(points, search, only) {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  return points.filter((point) => {
    if (only && !point.writable) return false;
    const text = `${point.key} ${point.type ?? ''} ${point.about} ${point.unit}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
}

function typeOf(point) {
  const limits = point.low !== undefined || point.high !== undefined ? `${point.low ?? ''} to ${point.high ?? ''}` : '';
  return html`<span title=${limits}>${point.type ?? ''}</span>`;
}

function Value({ device, point, value, trouble, role, onWritten }) {
  const [isOpen, setOpen] = useState(false);
  if (trouble) return html`<span class="late-text">${trouble}</span>`;
  const text = shown(value);
  if (text.includes('\n') && !point.writable) return html`<${Lines} name=${`${device}/${point.key}`} text=${text} />`;
  if (!point.writable || role !== 'operate') return html`<span title=${whole(value)}>${text}</span>${meaning(point, value)}`;
  return html`
    <button class="quietly" title=${whole(value)} aria-label=${`${point.key}, ${`${text} ${point.unit}`.trim()}, change`} onClick=${() => setOpen(true)}>${text === '' ? '(empty)' : text}</button>${meaning(point, value)}
    ${isOpen && html`<${Edit} device=${device} point=${point} value=${value} onWritten=${onWritten} onClose=${() => setOpen(false)} />`}`;
}

// A value of several lines, such as a message logger: its first line, and all of them, as they come, in a window.
function Lines({ name, text }) {
  const box = useRef(null);
  const lines = text.split('\n');
  const id = `lines-${name}`;
  return html`<button class="quietly" title=${text} aria-label=${`${name}, ${lines.length} lines, show`} onClick=${() => box.current.showModal()}>${lines[0]} (${lines.length} lines)</button>
    <dialog class="lines" ref=${box} aria-labelledby=${id}><h3 id=${id}>${name}</h3><pre tabindex="0">${text}</pre><button onClick=${() => box.current.close()}>Close</button></dialog>`;
}

// A small window over the list with the field, the limits, and the reason of a refusal.
function Edit({ device, point, value, onWritten, onClose }) {
  const box = useRef(null);
  const field = useRef(null);
  const [first] = useState(value); // what comes meanwhile does not change what is being typed
  const [refusal, setRefusal] = useState(null);
  useEffect(() => { box.current.showModal(); field.current?.select?.(); }, []);
  const send = async (event) => {
    event.preventDefault();
    try {
      onWritten(point.key, await write(device, point.key, typed(field.current, first)));
      box.current.close();
    } catch (cause) {
      setRefusal(cause);
    }
  };
  const id = `edit-${device}-${point.key}`;
  const limits = [point.low, point.high].some((limit) => limit !== undefined) ? `${point.low ?? '...'} to ${point.high ?? '...'} ${point.unit}` : '';
  return html`<dialog ref=${box} onClose=${onClose} aria-labelledby=${id}>
    <form onSubmit=${send}>
      <h3 id=${id}>${device}/${point.key}</h3>
      ${point.about && html`<p class="quiet">${point.about}</p>`}
      <label>new value ${fieldOf(point, first, field)} ${point.unit}</label>
      <p class="quiet">${[point.type, limits].filter(Boolean).join(', ')}</p>
      ${refusal && html`<p class="refusal" role="alert">${refusal.what}${refusal.remedy && html`<br />${refusal.remedy}`}</p>`}
      <div class="bar"><button class="main">Write</button><button type="button" onClick=${() => box.current.close()}>Close</button></div>
    </form>
  </dialog>`;
}

function fieldOf(point, value, field) {
  if (point.states) return html`<select ref=${field}>${point.states.map((state) => html`<option selected=${state === value}>${state}</option>`)}</select>`;
  if (typeof value === 'boolean') return html`<select ref=${field}><option selected=${value}>true</option><option selected=${!value}>false</option></select>`;
  return html`<input ref=${field} type="text" inputmode=${typeof value === 'number' ? 'decimal' : 'text'} defaultValue=${whole(value)} spellcheck=${false} />`;
}

// What is in the field, in the type of the present value; a text that is no number goes as it is, and the rig says why not.
function typed(field, present) {
  const text = field.value.trim();
  if (typeof present === 'boolean') return text === 'true';
  if (typeof present !== 'number') return field.value;
  const number = /^-?0x[0-9a-f]+$/i.test(text) ? Math.sign(text[0] === '-' ? -1 : 1) * parseInt(text.replace('-', ''), 16) : Number(text);
  return numberOrText(text, number);
}

async function write(device, key, value) {
  const name = encodeURIComponent(device);
  if (!key.startsWith(PROGRAM)) return (await api('PUT', `devices/${name}/points/${inPath(key)}`, { value })).value;
  const variable = key.slice(PROGRAM.length);
  const [written] = (await api('POST', `programs/${name}/write`, { values: { [variable]: value } })).variables;
  return written.text || written.value;
}

// False for a number that has lost digits in JSON; the topic has all of them.
const isWhole = (value) => !Number.isInteger(value) || Number.isSafeInteger(value);

function shown(value) {
  return typeof value === 'number' && !Number.isInteger(value) ? String(Number(value.toPrecision(7))) : whole(value);
}

// With all its digits: what a person writes without a change has to be what was there.
const whole = (value) => (value === undefined || value === null ? '' : String(value));
