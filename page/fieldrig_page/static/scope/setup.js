// The set-up of a scope: its signals, its trigger, and its files.
import { html } from 'htm/preact';
import { useEffect, useState } from 'preact/hooks';
import { api } from '../live.js';
import { Typed } from '../typed.js';

export const WINDOWS = [1e6, 2e6, 5e6, 1e7, 2e7, 5e7, 1e8, 2e8, 5e8, 1e9, 2e9, 5e9, 1e10, 2e10, 6e10, 3e11, 6e11];
export const MOST_DRAWN = 32;
const MOST_FOUND = 60;

export const USUAL = { signals: [], recorded: [], rhythm: 'cycle', window_ns: 1e10, before: 0.5, mode: 'run', trigger: null, xy: null };

const WHATS = {
  edge: [['rising', 'rises through'], ['falling', 'falls below'], ['both', 'crosses']],
  level: [['above', 'is at or above'], ['below', 'is below']],
  window: [['inside', 'enters'], ['outside', 'leaves']],
  fault: [['begin', 'begins'], ['end', 'ends']],
};
const KINDS = [['edge', 'edge of a signal'], ['level', 'level of a signal'], ['window', 'window of a signal'], ['state', 'state of a signal'], ['message', 'message on a bus'], ['fault', 'fault']];
const ON_SIGNALS = ['edge', 'level', 'window', 'state'];

// Searches all signals of the rig, and adds or removes them.
export function Signals({ setup, onChange }) {
  const [all, setAll] = useState([]);
  const [words, setWords] = useState('');
  const [trouble, setTrouble] = useState('');
  const look = () => api('GET', 'scope/signals').then((found) => { setAll(found); setTrouble(''); }, (refusal) => setTrouble(refusal.what));
  useEffect(() => { look(); }, []);
  const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
  const found = all.filter((signal) => wanted.every((word) => `${signal.name} ${signal.about ?? ''}`.toLowerCase().includes(word)));
  const toggle = (name) => {
    const signals = setup.signals.includes(name) ? setup.signals.filter((one) => one !== name) : [...setup.signals, name];
    onChange({ ...setup, signals: signals.slice(0, MOST_DRAWN) });
  };
  const typed = words.trim();
  const isNew = typed.includes('/') && !typed.includes(' ') && !all.some((signal) => signal.name === typed) && !setup.signals.includes(typed);
  return html`
    <div class="scope-signals">
      <label>Search signals <input type="search" value=${words} onFocus=${look} onInput=${(event) => setWords(event.currentTarget.value)}
        placeholder="part of a name or description" /></label>
      ${trouble && html`<p class="refusal" role="alert">${trouble}</p>`}
      <p class="quiet" role="status">${found.length > MOST_FOUND ? `the first ${MOST_FOUND} of ${found.length} signals` : `${found.length} ${found.length === 1 ? 'signal' : 'signals'}`}, ${setup.signals.length} of at most ${MOST_DRAWN} drawn</p>
      ${isNew && html`<button type="button" onClick=${() => { toggle(typed); setWords(''); }}>Add ${typed}</button>`}
      <ul class="scope-found">${found.slice(0, MOST_FOUND).map((signal) => html`<li key=${signal.name}>
        <label><input type="checkbox" checked=${setup.signals.includes(signal.name)} onChange=${() => toggle(signal.name)} />
          <span><b>${signal.name}</b>${signal.unit ? ` (${signal.unit})` : ''} <span class="quiet">${signal.about}</span></span></label></li>`)}</ul>
      ${setup.signals.length > 0 && html`<h3>Drawn, from the top</h3>
      <ol class="scope-chosen">${setup.signals.map((name, place) => html`<li key=${name}><span>${name}</span>
        <button type="button" aria-label=${`${name} up`} disabled=${place === 0} onClick=${() => onChange({ ...setup, signals: swapped(setup.signals, place) })}>↑</button>
        <button type="button" aria-label=${`remove ${name}`} onClick=${() => toggle(name)}>×</button></li>`)}</ol>`}
    </div>`;
}

function swapped(names, place) {
  const moved = [...names];
  [moved[place - 1], moved[place]] = [moved[place], moved[place - 1]];
  return moved;
}

// What the scope waits for.
export function Trigger({ setup, columns, middles, onChange }) {
  const [parts, setParts] = useState({ devices: [], buses: [] });
  useEffect(() => { api('GET', 'scope/parts').then(setParts, () => {}); }, []);
  const trigger = setup.trigger;
  const change = (changes) => onChange({ ...setup, trigger: { ...trigger, ...changes }, mode: setup.mode === 'run' ? 'normal' : setup.mode });
  const begin = (kind) => {
    if (kind === 'none') return onChange({ ...setup, trigger: null, mode: 'run' });
    const signal = trigger?.signal || setup.signals[0] || '';
    const level = middles[setup.signals.indexOf(signal)] ?? 0.5;
    const column = columns.find((one) => one.name === signal);
    const usual = { edge: { signal, level }, level: { signal, level }, window: { signal, level: level - 1, high: level + 1 }, state: { signal, what: column?.states[0] ?? '' }, message: { part: parts.buses[0] ?? '', words: [] }, fault: { part: '' } };
    return onChange({ ...setup, trigger: { kind, what: WHATS[kind]?.[0][0] ?? '', ...usual[kind] }, mode: setup.mode === 'run' ? 'normal' : setup.mode });
  };
  const hasNoSignal = setup.signals.length === 0 && !trigger?.signal;
  const isOnSignal = trigger !== null && ON_SIGNALS.includes(trigger.kind);
  const column = columns.find((one) => one.name === trigger?.signal);
  const select = (label, value, options, key) => html`<label>${label} <select value=${value} onChange=${(event) => change({ [key]: event.currentTarget.value })}>
    ${options.map(([one, words]) => html`<option value=${one}>${words}</option>`)}</select></label>`;
  const numeric = (label, key) => html`<label>${label} <${Typed} type="number" step="any" size="8" value=${trigger[key]} onGiven=${(text) => { if (text !== '') change({ [key]: Number(text) }); }} /></label>`;
  return html`
    <div class="scope-row" role="group" aria-label="trigger">
      <label>Trigger <select value=${trigger?.kind ?? 'none'} onChange=${(event) => begin(event.currentTarget.value)}>
        <option value="none">none</option>${KINDS.map(([kind, words]) => html`<option value=${kind} disabled=${ON_SIGNALS.includes(kind) && hasNoSignal}>${words}</option>`)}</select></label>
      ${isOnSignal && select('Signal', trigger.signal, [...new Set([...setup.signals, ...setup.recorded, trigger.signal])].filter(Boolean).map((name) => [name, name]), 'signal')}
      ${trigger && WHATS[trigger.kind] && select('When it', trigger.what, WHATS[trigger.kind], 'what')}
      ${trigger && ['edge', 'level'].includes(trigger.kind) && numeric('Level', 'level')}
      ${trigger?.kind === 'window' && html`${numeric('From', 'level')}${numeric('To', 'high')}`}
      ${trigger?.kind === 'state' && (column?.states.length && !column.is_open
        ? select('Enters', trigger.what, column.states.map((state) => [state, state]), 'what')
        : html`<label>Enters <${Typed} list="scope-texts" value=${trigger.what} onGiven=${(what) => change({ what })} /></label>
          <datalist id="scope-texts">${(column?.states ?? []).map((text) => html`<option value=${text} />`)}</datalist>`)}
      ${trigger?.kind === 'message' && html`${select('Bus', trigger.part, parts.buses.map((name) => [name, name]), 'part')}
        <label>With the words <${Typed} value=${trigger.words.join(' ')} onGiven=${(text) => change({ words: text.split(/\s+/).filter(Boolean) })} /></label>`}
      ${trigger?.kind === 'fault' && select('Of', trigger.part, [['', 'any part'], ...[...parts.devices, ...parts.buses].map((name) => [name, name])], 'part')}
      ${trigger && html`<label>Before it <select value=${setup.before} onChange=${(event) => onChange({ ...setup, before: Number(event.currentTarget.value) })}>
        ${[...new Set([0, 0.1, 0.25, 0.5, 0.75, 0.9, setup.before])].sort().map((part) => html`<option value=${part}>${Math.round(part * 100)} %</option>`)}</select></label>`}
    </div>`;
}

// Set-ups by name, in the run folder of the rig.
export function Files({ setup, role, onOpen }) {
  const [names, setNames] = useState([]);
  const [chosen, setChosen] = useState('');
  const [said, setSaid] = useState('');
  const look = () => api('GET', 'scope/setups').then(setNames, () => {});
  useEffect(() => { look(); }, []);
  const tell = (refusal) => setSaid(refusal.remedy ? `${refusal.what}: ${refusal.remedy}` : refusal.what);
  const path = `scope/setups/${encodeURIComponent(chosen.trim())}`;
  const save = () => api('PUT', path, setup).then(() => { setSaid(`saved as ${chosen.trim()}`); look(); }, tell);
  const remove = () => api('DELETE', path).then(() => { setSaid(`deleted ${chosen.trim()}`); look(); }, tell);
  const open = () => api('GET', path).then((found) => {
    const away = found.missing.map((signal) => signal.name);
    onOpen(found.setup);
    setSaid(away.length ? `opened; this rig does not have ${away.join(', ')}` : `opened ${chosen.trim()}`);
  }, tell);
  const isThere = names.includes(chosen.trim());
  return html`
    <div class="scope-row" role="group" aria-label="set-ups">
      <label>Set-up <input list="scope-setups" value=${chosen} maxlength="64" onInput=${(event) => setChosen(event.currentTarget.value)} /></label>
      <datalist id="scope-setups">${names.map((name) => html`<option value=${name} />`)}</datalist>
      <button type="button" disabled=${!isThere} onClick=${open}>Open</button>
      ${role === 'operate' && html`<button type="button" disabled=${!chosen.trim()} onClick=${save}>Save</button>
      <button type="button" disabled=${!isThere} onClick=${remove}>Delete</button>`}
      <span role="status" class="quiet">${said}</span>
    </div>`;
}
