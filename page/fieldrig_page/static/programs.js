// Programs: source with the current line and live values, task times; start, stop, reset, force.
import { html } from 'htm/preact';
import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import { api, inPath, useAnswer, useLive, useWish } from './live.js';
import { named } from './named.js';
import { numberOrText } from './fronts/words.js';
import { Refused, Rows } from './rows.js';

const NOTHING = { state: null, values: named(), tasks: {}, forced: [] };
const LINE = 20; // pixels
const MOST_NAMES = 400;
const STATES = { running: 'ok', paused: 'late', held: 'late', ended: 'quiet', failed: 'down', none: 'quiet' };
const NAME = /[A-Za-z_@][A-Za-z0-9_]*(?:\[\d+\]|\.[A-Za-z_][A-Za-z0-9_]*)*/g;

export function View({ path, role }) {
  const [devices] = useAnswer('programs');
  const chosen = path || devices?.[0];
  if (devices === null) return html`<p class="quiet" role="status">asking ...</p>`;
  if (!chosen) return html`<section><h2>Programs</h2><p class="quiet">no device of this rig has a program</p></section>`;
  return html`<div class="programs">
    ${devices.length > 1 && html`<div class="bar"><label for="program-device">device</label><select id="program-device" value=${chosen} onChange=${(event) => { location.hash = `#/programs/${encodeURIComponent(event.target.value)}`; }}>
      ${devices.map((name) => html`<option value=${name} selected=${name === chosen}>${name}</option>`)}</select></div>`}
    <${Program} key=${chosen} device=${chosen} role=${role} />
  </div>`;
}

function Program({ device, role }) {
  const [file, setFile] = useState(null);
  const [text, setText] = useState('');
  const [span, setSpan] = useState([0, 60]);
  const [pinned, setPinned] = useState([]);
  const [refusal, setRefusal] = useState(null);
  const lines = useMemo(() => text.split('\n'), [text]);
  const [place, setPlace] = useState(null);
  const now = useLive('program', (before, frame) => (frame.device === device ? { ...before, ...frame } : before), NOTHING);
  const { state, values, tasks, forced } = now;
  const code = useMemo(() => withoutComments(text, state?.language).split('\n'), [text, state?.language]);
  const scopes = useMemo(() => scopesOf(code), [code]);
  const names = namesIn(code, scopes, span);
  useWish('program', { device, names: [...new Set([...pinned, ...names.values()].flat())].slice(0, MOST_NAMES) });
  const loads = state?.loads;
  const at = placesOf(state).find((frame) => file === null || frame.file === file);
  useEffect(() => { if (state?.files && !state.files.includes(file)) setFile(at?.file ?? state.files[0] ?? null); }, [state]);
  useEffect(() => {
    let isHere = true;
    if (file) api('GET', `programs/${encodeURIComponent(device)}/source/${inPath(file)}`).then(({ text: whole }) => {
      if (!isHere) return;
      setText(whole);
      if (place === null && at?.file === file) setPlace({ index: at.line - 1 }); // a program opens where it is
    }, setRefusal);
    return () => { isHere = false; };
  }, [device, file, loads]);
  const act = async (action, orders = {}) => {
    try {
      await api('POST', `programs/${encodeURIComponent(device)}/${action}`, orders);
      setRefusal(null);
    } catch (cause) {
      setRefusal(cause);
    }
  };
  const current = currentLines(state, file);
  if (state === null) return html`<p class="quiet" role="status">asking ${device} ...</p>`;
  if (state.trouble) return html`<p class="refusal" role="alert">${state.trouble}</p>`;
  return html`
    <section aria-labelledby="program-title">
      <div class="bar">
        <h2 id="program-title">${device}: ${state.language}</h2>
        <span class=${`pill ${STATES[state.state] ?? ''}`} role="status">${state.state}${state.progress && `, ${state.progress}`}</span>
        ${role === 'operate' && html`
          <button onClick=${() => act('start')} disabled=${state.state === 'running'}>Start</button>
          <button onClick=${() => act('stop')} disabled=${state.state !== 'running'}>Stop</button>
          <button onClick=${() => act('reset', { kind: 'warm' })}>Reset</button>
          <button onClick=${() => act('reset', { kind: 'cold' })}>Cold reset</button>`}
        ${state.files.length > 1 && html`<label for="program-file">file</label><select id="program-file" onChange=${(event) => setFile(event.target.value)}>${state.files.map((name) => html`<option selected=${name === file}>${name}</option>`)}</select>`}
      </div>
      <${Refused} refusal=${refusal} />
      ${state.problem && html`<pre class="refusal">${state.problem}</pre>`}
      ${file && html`<${Rows} label=${`source ${file}`} count=${lines.length} height=${LINE} goal=${place} onShow=${(first, last) => setSpan([first, last])}
        columns=${[{ title: 'line', look: 'number quiet' }, { title: file, look: 'source' }, { title: 'values', look: 'live' }]}
        row=${(index) => ({
          key: `${file}:${index}`,
          look: current.has(index + 1) ? 'current' : '',
          cells: [index + 1, html`<code>${lines[index]}</code>${current.has(index + 1) && html` <span class="here">${current.get(index + 1).join(', ')}</span>`}`,
            html`<${LiveValues} names=${names.get(index) ?? []} scope=${scopes[index]} values=${values} forced=${forced} />`],
        })} />`}
    </section>
    <div class="beside">
      <${Tasks} threads=${state.threads} tasks=${tasks} onPlace=${(frame) => { setFile(frame.file); setPlace({ index: frame.line - 1 }); }} />
      <${Forcing} forced=${forced} pinned=${pinned} setPinned=${setPinned} values=${values} role=${role} act=${act} />
    </div>`;
}

// The units of the source: line -> name of the PROGRAM, FUNCTION_BLOCK ... that the line is in.
function scopesOf(lines) {
  let scope = '';
  return lines.map((line) => {
    const begin = /^\s*(?:PROGRAM|FUNCTION_BLOCK|FUNCTION)\s+(\w+)/i.exec(line);
    if (begin) scope = begin[1];
    if (/^\s*END_(?:PROGRAM|FUNCTION_BLOCK|FUNCTION)\b/i.test(line)) { const ended = scope; scope = ''; return ended; }
    return scope;
  });
}

// The text with comments, literals of text and those with a type, such as T#5s, as blanks, on the same lines.
function withoutComments(text, language) {
  if (language === 'ARP BASIC') return text.replace(/;.*/g, '');
  const blank = (found) => found.replace(/[^\n]/g, ' ');
  const bare = text.replace(/\(\*[\s\S]*?\*\)|\/\/.*|'[^'\n]*'|"[^"\n]*"/g, blank);
  return language === 'IEC 61131-3' ? bare.replace(/\b\w+#[\w.:#+-]+|\b(?:TRUE|FALSE)\b/gi, blank) : bare;
}

// The names on the lines of the screen, by line; the rig says which of them are variables.
function namesIn(lines, scopes, [first, last]) {
  const found = new Map();
  for (let index = first; index < Math.min(last, lines.length); index += 1) {
    const names = [...new Set(lines[index].match(NAME) ?? [])];
    if (names.length > 0) found.set(index, names.flatMap((name) => (scopes[index] ? [`${scopes[index]}.${name}`, name] : [name])));
  }
  return found;
}

// The places at which the tasks are, in files of the program.
function placesOf(state) {
  return (state?.threads ?? []).flatMap((thread) => thread.frames.slice(0, 1)).filter((frame) => state.files?.includes(frame.file));
}

function currentLines(state, file) {
  const found = new Map();
  for (const thread of state?.threads ?? []) {
    const [frame] = thread.frames;
    if (frame?.file === file) found.set(frame.line, [...(found.get(frame.line) ?? []), thread.name || `task ${thread.number}`]);
  }
  return found;
}

function LiveValues({ names, scope, values, forced }) {
  const known = names.filter((name) => values[name] !== null && values[name] !== undefined);
  return known.map((name) => html`<span class=${`live-value ${forced.some((one) => one.path === name) ? 'forced' : ''}`} key=${name}>${name.startsWith(`${scope}.`) ? name.slice(scope.length + 1) : name} = <b>${String(values[name])}</b></span>`);
}

function Tasks({ threads, tasks, onPlace }) {
  const rows = named();
  for (const [key, value] of Object.entries(tasks)) {
    const [name, figure] = key.split('/task/')[1].split('/');
    (rows[name] ??= named())[figure] = value;
  }
  const figures = [...new Set(Object.values(rows).flatMap(Object.keys))].filter((name) => name !== 'state');
  const units = { load: 'load (us)', cycle: 'cycle (us)', cpu: 'CPU (us)' };
  return html`<section aria-labelledby="tasks-title">
    <h2 id="tasks-title">Tasks</h2>
    <div class="wide" tabindex="0" role="region" aria-label="table of the tasks"><table>
      <thead><tr><th>task</th><th>state</th>${figures.map((name) => html`<th class="number">${units[name] ?? name}</th>`)}<th>at</th></tr></thead>
      <tbody>${threads.map((thread) => html`<tr key=${thread.number}><th scope="row">${thread.name}</th>
        <td><span class=${`pill ${STATES[thread.state] ?? ''}`}>${thread.state}</span></td>
        ${figures.map((name) => html`<td class="number">${rows[thread.name]?.[name] ?? ''}</td>`)}
        <td>${thread.frames[0] && html`<button onClick=${() => onPlace(thread.frames[0])}>${thread.frames[0].routine}, line ${thread.frames[0].line}</button> `}${thread.about}</td></tr>`)}</tbody>
    </table></div>
  </section>`;
}

function Forcing({ forced, role, act }) {
  const form = useRef(null);
  const send = (event) => {
    event.preventDefault();
    const { name, value } = form.current.elements;
    act(event.submitter?.value ?? 'force', { values: { [name.value.trim()]: typed(value.value.trim()) } });
  };
  return html`<section aria-labelledby="forced-title">
    <h2 id="forced-title">Forced variables</h2>
    ${role === 'operate' && html`<form ref=${form} class="bar" onSubmit=${send}>
      <label class="grow">variable <input name="name" required placeholder="Main.Count" spellcheck=${false} autocomplete="off" /></label>
      <label>value <input name="value" required size="8" spellcheck=${false} autocomplete="off" /></label>
      <button class="main" value="force">Force</button><button value="write">Write once</button>
    </form>`}
    ${forced.length === 0 ? html`<p class="quiet">none</p>` : html`<table>
      <thead><tr><th>variable</th><th>value</th>${role === 'operate' && html`<th>do</th>`}</tr></thead>
      <tbody>${forced.map((one) => html`<tr key=${one.path}><th scope="row"><code>${one.path}</code></th><td>${one.text || String(one.value)}</td>
        ${role === 'operate' && html`<td><button onClick=${() => act('release', { names: [one.path] })} aria-label=${`Release ${one.path}`}>Release</button></td>`}</tr>`)}</tbody>
    </table>`}
  </section>`;
}

// A literal as people type it; the rig knows the others, such as T#5s.
function typed(text) {
  if (/^(true|false)$/i.test(text)) return text.toLowerCase() === 'true';
  return numberOrText(text);
}
