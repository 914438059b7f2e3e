// The scope: signals of the rig over time, as their devices sampled them, with a trigger and what was before it.
import { html } from 'htm/preact';
import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import { live } from '../live.js';
import { Buckets } from './buckets.js';
import { Axes, GUTTER, colour, draw, drawXy, duration, exactly, heightOf, lanes } from './canvas.js';
import { Sliders, Values } from './cursors.js';
import { Files, Signals, Trigger, USUAL, WINDOWS } from './setup.js';

const TALK_MS = 200; // between two changes of the numbers beside the canvas
const HEIGHT = 420;
const COMPACT = 240;
const EMPTY = 160; // without a signal, what can be chosen is nearer
const MOST_EVENTS = 500;
const LIVE = { isStopped: false, capture: null, view: null, cursors: [], arm: 0 };

// `path` has names of signals with commas between them, such as `#/scope/tank/level`; beside a picture it is compact.
export function View({ path, role, isBeside = false }) {
  const signals = typeof path === 'string' ? path.split(',').filter(Boolean) : [];
  return html`<${Scope} key=${path} role=${role} signals=${signals} isAddressed=${signals.length > 0} isCompact=${isBeside} />`;
}

// A scope beside something else is compact.  `signals` are drawn, with `usual` in the set-up, if this tab had none before,
// or if the address has them and the set-up of this tab has not.
export function Scope({ role, signals = [], usual = {}, isAddressed = false, isCompact = false }) {
  const rig = live.greeting?.rig ?? '';
  const place = `scope:${rig}`;
  const [before] = useState(() => {
    const kept = remembered(place);
    return isAddressed && !signals.every((name) => kept?.setup.signals.includes(name)) ? null : kept;
  });
  const [setup, setSetup] = useState(before?.setup ?? { ...USUAL, ...usual, signals });
  const [look, setLook] = useState(before?.look ?? LIVE);
  const [width, setWidth] = useState(0);
  const [status, setStatus] = useState({ state: 'asking', lost: [], pauses: [], away_ns: [], hits: 0, capture: null, trouble: '', messages_lost: 0 });
  const [columns, setColumns] = useState([]);
  const [talk, setTalk] = useState({ newest: [], values: [], events: [] });
  const [isChoosing, setChoosing] = useState(setup.signals.length === 0 && !isCompact);
  const held = useRef(null);
  held.current ??= { buckets: new Buckets(), axes: new Axes(), columns: [], gaps: [], events: [], status: null, xy: null };
  const canvas = useRef(null);
  const xyCanvas = useRef(null);
  const isDark = useDark();
  const colours = useMemo(() => Array.from({ length: 64 }, (_, row) => colour(row, isDark)), [isDark]);
  const isStill = status.capture !== null && status.capture !== undefined;
  const zeroNs = isStill ? status.capture.trigger_ns ?? status.capture.first_ns : 0;
  const height = heightOf(columns, isCompact ? COMPACT : setup.signals.length > 0 ? HEIGHT : EMPTY);

  useEffect(() => { sessionStorage.setItem(place, JSON.stringify({ setup, look })); }, [setup, look]);
  const wish = {
    setup,
    pixels: Math.max(Math.round((width - GUTTER) * Math.min(devicePixelRatio || 1, 2)), 16),
    arm: look.arm,
    is_stopped: look.isStopped,
    capture: look.capture,
    view_ns: look.view,
    cursors_ns: look.cursors,
  };
  // A wish replaces the one before it.  To want nothing in between would end the recording and disarm the trigger.
  const ends = useRef(() => {});
  useEffect(() => { if (width > 0) ends.current = live.want('scope', wish); }, [JSON.stringify(wish)]);
  useEffect(() => () => ends.current(), []);

  const drawing = useRef(null); // the newest way to draw, for frames that come between two renderings
  drawing.current = () => {
    const kept = held.current;
    if (canvas.current === null || width === 0) return;
    const g = scaled(canvas.current, width, height);
    const style = styleOf(canvas.current, colours);
    draw(g, width, height, { ...kept, lanes: lanes(kept.columns, height), trigger: triggerOf(kept.status), cursors: look.cursors, zeroNs }, style);
    if (kept.xy && xyCanvas.current) drawXy(scaled(xyCanvas.current, 280, 280), 280, 280, kept.xy, style);
  };
  const request = useFrames(drawing);
  useEffect(request, [width, height, isDark, look, columns, status]);

  useEffect(() => {
    let talkedMs = 0;
    return live.on('scope', (frame) => {
      const kept = held.current;
      if (frame.whole) {
        Object.assign(kept, { columns: frame.columns, events: [] });
        setColumns(frame.columns);
      }
      kept.buckets.take(frame);
      if (frame.events) kept.events = [...kept.events, ...frame.events].slice(-MOST_EVENTS);
      if (frame.xy !== undefined) kept.xy = frame.xy;
      if (frame.gaps) kept.gaps = frame.gaps;
      const nowMs = performance.now();
      const isNews = frame.status && !isAlike(frame.status, kept.status);
      if (frame.status) kept.status = frame.status;
      if (isNews || frame.whole || frame.events || nowMs - talkedMs > TALK_MS) {
        talkedMs = nowMs;
        if (kept.status) setStatus(kept.status);
        setTalk((before) => ({ values: frame.cursors ?? before.values, events: kept.events, newest: kept.columns.map((_, row) => kept.buckets.newest(row)) }));
      }
      request();
    });
  }, []);

  // The first picture of `single`, and what was recorded when the scope was stopped, stay over a reload.
  useEffect(() => {
    const number = status.capture?.number ?? null;
    if (status.state === 'caught' && !look.isStopped) setLook({ ...look, isStopped: true, capture: number });
    else if (look.isStopped && number !== null && look.capture !== number) setLook({ ...look, capture: number });
  }, [status]);

  const change = (next) => { setSetup(next); setLook((before) => ({ ...LIVE, arm: before.arm + 1 })); };
  const run = (changes = {}) => { setSetup({ ...setup, ...changes }); setLook({ ...LIVE, arm: look.arm + 1 }); };
  const stop = () => setLook({ ...look, isStopped: true, capture: status.capture?.number ?? null });
  const view = look.view ?? (isStill ? [status.capture.first_ns, status.capture.end_ns] : [held.current.buckets.firstNs, held.current.buckets.endNs]);
  const show = (next) => setLook({ ...look, view: limited(next, status.capture) });
  const zoom = (factor, at = 0.5) => {
    const span = (view[1] - view[0]) * factor;
    const middle = view[0] + (view[1] - view[0]) * at;
    show([middle - span * at, middle + span * (1 - at)]);
  };
  const pan = (part) => show([view[0] + part * (view[1] - view[0]), view[1] + part * (view[1] - view[0])]);
  const place2 = () => setLook({ ...look, cursors: look.cursors.length ? [] : [view[0] + (view[1] - view[0]) / 3, view[0] + (2 * (view[1] - view[0])) / 3].map(Math.round) });
  const move = (number, instantNs) => setLook({ ...look, cursors: look.cursors.map((one, at) => (at === number ? instantNs : one)) });
  const pointer = usePointer({ isStill, view, look, setLook, show, zoom, width });
  const middles = columns.map((_, row) => middle(held.current.buckets.range(row)));

  return html`
    <section class=${`scope ${isCompact ? 'compact' : ''}`} aria-label="scope">
      <div class="scope-row">
        <h2>Scope</h2>
        <${State} status=${status} />
        ${look.isStopped
          ? html`<button type="button" class="main" onClick=${() => run(setup.mode === 'single' ? { mode: 'run' } : {})}>Run</button>`
          : html`<button type="button" class="main" onClick=${stop}>Stop</button>`}
        <button type="button" disabled=${setup.trigger === null} onClick=${() => run({ mode: 'single' })}>Single</button>
        <label>Mode <select value=${setup.mode} onChange=${(event) => run({ mode: event.currentTarget.value })}>
          <option value="run">roll</option>${['auto', 'normal', 'single'].map((mode) => html`<option value=${mode} disabled=${setup.trigger === null}>${mode}</option>`)}</select></label>
        <label>Window <select value=${setup.window_ns} onChange=${(event) => change({ ...setup, window_ns: Number(event.currentTarget.value) })}>
          ${[...new Set([...WINDOWS, setup.window_ns])].sort((a, b) => a - b).map((ns) => html`<option value=${ns}>${duration(ns, ns)}</option>`)}</select></label>
        <label>Sampled <select value=${String(setup.rhythm)} onChange=${(event) => change({ ...setup, rhythm: rhythmOf(event.currentTarget.value) })}>
          <option value="cycle">each cycle</option><option value="change">each change</option>
          ${[...new Set([100000, 1000000, 10000000, 100000000, 1000000000, ...(Number.isInteger(setup.rhythm) ? [setup.rhythm] : [])])].map((ns) => html`<option value=${String(ns)}>every ${duration(ns, ns)}</option>`)}</select></label>
      </div>
      <${Trigger} setup=${setup} columns=${columns} middles=${middles} onChange=${change} />
      ${status.trouble && html`<p class="refusal" role="alert">${status.trouble.replace(/\n\s*/g, ': ')}</p>`}
      ${status.messages_lost > 0 && html`<p class="refusal" role="alert">${status.messages_lost} ${status.messages_lost === 1 ? 'message' : 'messages'} did not get here: the trigger may have missed one</p>`}
      <div class="scope-body">
        <div class="scope-plot" ref=${useWidth(setWidth)}>
          <canvas ref=${canvas} class=${isStill ? 'still' : ''} role="img" style=${{ height: `${height}px` }} tabindex="0"
            aria-label=${`${columns.length} signals over ${exactly(isStill ? view[1] - view[0] : setup.window_ns)}, ${stateOf(status)}`}
            aria-describedby="scope-values" ...${pointer}></canvas>
          ${columns.length === 0 && html`<p class="quiet scope-empty">Choose signals below: any value of a device, wire, object or variable of a program.</p>`}
          ${isStill && html`<div class="scope-row" role="group" aria-label="look around">
            <button type="button" onClick=${() => zoom(0.5)}>Zoom in</button><button type="button" onClick=${() => zoom(2)}>Zoom out</button>
            <button type="button" onClick=${() => pan(-0.5)}>Earlier</button><button type="button" onClick=${() => pan(0.5)}>Later</button>
            <button type="button" onClick=${() => setLook({ ...look, view: null })}>All</button>
            <button type="button" aria-pressed=${look.cursors.length > 0} onClick=${place2}>Cursors</button>
            <${Sliders} cursors=${look.cursors} firstNs=${view[0]} endNs=${view[1]} zeroNs=${zeroNs} onMove=${move} />
          </div>`}
        </div>
        <${Values} id="scope-values" isStill=${isStill} columns=${columns} colours=${colours} lost=${status.lost} pauses=${status.pauses} away=${status.away_ns} newest=${talk.newest}
          cursors=${isStill ? look.cursors : []} values=${talk.values} zeroNs=${zeroNs} />
      </div>
      <div class="scope-row" role="group" aria-label="exports">
        <${Exports} capture=${status.capture} onStop=${stop} onPng=${() => savePng(canvas.current, rig)} />
        <${Xy} setup=${setup} onChange=${(xy) => setSetup({ ...setup, xy })} />
      </div>
      ${setup.xy && html`<canvas ref=${xyCanvas} class="scope-xy" role="img" aria-label=${`${setup.xy[1]} over ${setup.xy[0]}`} style=${{ width: '280px', height: '280px' }}></canvas>
        ${held.current.xy?.each > 1 && html`<p class="quiet">each ${held.current.xy.each}th sample is drawn</p>`}`}
      <${Timeline} events=${talk.events} zeroNs=${zeroNs} />
      <details open=${isChoosing} onToggle=${(event) => setChoosing(event.currentTarget.open)}><summary>Signals</summary><${Signals} setup=${setup} onChange=${(next) => { setSetup(next); if (look.isStopped) setLook({ ...LIVE, arm: look.arm + 1 }); }} /></details>
      <details><summary>Set-ups</summary><${Files} setup=${setup} role=${role} onOpen=${change} /></details>
    </section>`;
}

// Counters alone are not worth another rendering at once.
function isAlike(one, other) {
  return other !== null && one.state === other.state && one.trouble === other.trouble && one.capture?.number === other.capture?.number;
}

const WORDS = { running: ['ok', 'rolling'], armed: ['late', 'waiting for the trigger'], triggered: ['fault', 'triggered'], caught: ['ok', 'caught'], stopped: ['down', 'stopped'], asking: ['late', 'asking'] };

// A scope that has stopped with a trigger has caught something.
const stateOf = (status) => (status.state === 'stopped' && typeof status.capture?.trigger_ns === 'number' ? 'caught' : status.state);

function State({ status }) {
  const [look, words] = WORDS[stateOf(status)] ?? ['late', status.state];
  const hits = status.hits > 0 ? `, ${status.hits} ${status.hits === 1 ? 'trigger' : 'triggers'}` : '';
  const lost = status.capture ? status.capture.lost : Math.max(0, ...status.lost);
  const after = status.capture?.trigger_ns !== null && status.capture?.trigger_ns !== undefined && status.capture.after_ns < status.capture.trigger_ns;
  return html`<p class=${`pill ${look}`} role="status">${words}${hits}</p>
    ${lost > 0 && html`<p class="pill down">${lost} ${lost === 1 ? 'sample' : 'samples'} lost</p>`}
    ${after && html`<p class="pill late">the trigger is up to ${exactly(status.capture.trigger_ns - status.capture.after_ns)} earlier</p>`}`;
}

function Exports({ capture, onStop, onPng }) {
  return html`${capture
    ? html`<a class="button" href=${`/api/v1/scope/captures/${capture.number}/csv`} download>CSV</a><a class="button" href=${`/api/v1/scope/captures/${capture.number}/vcd`} download>VCD</a>`
    : html`<button type="button" onClick=${onStop}>Stop to export samples</button>`}<button type="button" onClick=${onPng}>PNG</button>`;
}

function Xy({ setup, onChange }) {
  const names = setup.signals;
  const at = (number) => html`<select aria-label=${number ? 'up' : 'across'} value=${setup.xy[number]}
    onChange=${(event) => onChange(setup.xy.map((name, place) => (place === number ? event.currentTarget.value : name)))}>${names.map((name) => html`<option value=${name}>${name}</option>`)}</select>`;
  return html`<button type="button" aria-pressed=${setup.xy !== null} disabled=${names.length < 2} onClick=${() => onChange(setup.xy ? null : [names[0], names[1]])}>XY</button>
    ${setup.xy && html`<span>${at(1)} over ${at(0)}</span>`}`;
}

function Timeline({ events, zeroNs }) {
  if (events.length === 0) return null;
  return html`<details><summary>Faults and events (${events.length})</summary><ol class="scope-events">
    ${events.slice(-50).reverse().map((event) => html`<li><span class=${`pill ${event.is_over ? 'ok' : event.sort === 'event' ? '' : 'fault'}`}>${event.sort}${event.is_over ? ' over' : ''}</span>
      ${exactly(event.at_ns - zeroNs)} <b>${event.part}</b> ${event.text}</li>`)}</ol></details>`;
}

function triggerOf(status) {
  const capture = status?.capture;
  return capture && capture.trigger_ns !== null ? { ns: capture.trigger_ns, afterNs: capture.after_ns } : null;
}

function rhythmOf(text) {
  return Number.isNaN(Number(text)) ? text : Number(text);
}

function middle(range) {
  return range === null ? undefined : Number(((range[0] + range[1]) / 2).toPrecision(4));
}

function limited([first, end], capture) {
  const least = 1000;
  const span = Math.max(end - first, least);
  const [from, to] = capture ? [capture.first_ns, capture.end_ns] : [first, first + span];
  const begin = Math.min(Math.max(first, from), Math.max(to - span, from));
  return [Math.round(begin), Math.round(Math.min(begin + span, Math.max(to, begin + least)))];
}

function remembered(place) {
  try {
    return JSON.parse(sessionStorage.getItem(place));
  } catch {
    return null; // of an earlier version
  }
}

function useDark() {
  const query = useMemo(() => matchMedia('(prefers-color-scheme: dark)'), []);
  const [isDark, setDark] = useState(query.matches);
  useEffect(() => {
    const take = () => setDark(query.matches);
    query.addEventListener('change', take);
    return () => query.removeEventListener('change', take);
  }, []);
  return isDark;
}

// Returns a function that draws once in the next frame of the browser, however often it is called.
function useFrames(drawing) {
  const due = useRef(0);
  useEffect(() => () => cancelAnimationFrame(due.current), []);
  return () => {
    if (due.current) return;
    due.current = requestAnimationFrame(() => { due.current = 0; drawing.current(); });
  };
}

function useWidth(setWidth) {
  const [element, setElement] = useState(null);
  useEffect(() => {
    if (element === null) return undefined;
    const observer = new ResizeObserver(([entry]) => setWidth(Math.round(entry.contentRect.width)));
    observer.observe(element);
    return () => observer.disconnect();
  }, [element]);
  return setElement;
}

function scaled(canvas, width, height) {
  const ratio = devicePixelRatio || 1;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const g = canvas.getContext('2d');
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  return g;
}

// The colours of the page as the browser resolves them: a canvas does not know variables.
function styleOf(element, colours) {
  const probe = element.parentElement;
  const style = getComputedStyle(probe);
  const found = { colours, font: `11px ${style.fontFamily}` };
  for (const name of ['ink', 'quiet', 'edge', 'card', 'accent', 'ok', 'late', 'fault', 'down']) found[name] = resolved(style.getPropertyValue(`--${name}`).trim());
  return found;
}

const known = new Map();

function resolved(value) {
  const key = `${value} ${matchMedia('(prefers-color-scheme: dark)').matches}`;
  if (!known.has(key)) {
    const probe = document.createElement('span');
    probe.style.color = value;
    document.body.append(probe);
    known.set(key, getComputedStyle(probe).color);
    probe.remove();
  }
  return known.get(key);
}

function savePng(canvas, rig) {
  const picture = document.createElement('canvas');
  picture.width = canvas.width;
  picture.height = canvas.height;
  const g = picture.getContext('2d');
  g.fillStyle = resolved(getComputedStyle(canvas).getPropertyValue('--card').trim());
  g.fillRect(0, 0, picture.width, picture.height);
  g.drawImage(canvas, 0, 0);
  picture.toBlob((blob) => {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(blob);
    link.download = `${rig || 'rig'}-scope.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  });
}

// A click puts cursor A, with shift B; a drag moves a cursor that is near, else the picture; the wheel zooms.
function usePointer({ isStill, view, look, setLook, show, zoom, width }) {
  const drag = useRef(null);
  if (!isStill) return {};
  const atOf = (event) => (event.offsetX - GUTTER) / Math.max(width - GUTTER, 1);
  const instantOf = (event) => Math.round(view[0] + atOf(event) * (view[1] - view[0]));
  return {
    onPointerDown: (event) => {
      event.currentTarget.setPointerCapture(event.pointerId);
      const reach = (8 / width) * (view[1] - view[0]);
      const near = look.cursors.findIndex((one) => Math.abs(one - instantOf(event)) < reach);
      drag.current = { x: event.offsetX, view, near, hasMoved: false };
    },
    onPointerMove: (event) => {
      const begun = drag.current;
      if (begun === null) return;
      if (Math.abs(event.offsetX - begun.x) > 4) begun.hasMoved = true;
      if (!begun.hasMoved) return;
      if (begun.near >= 0) setLook({ ...look, cursors: look.cursors.map((one, place) => (place === begun.near ? instantOf(event) : one)) });
      else {
        const shift = ((begun.x - event.offsetX) / Math.max(width - GUTTER, 1)) * (begun.view[1] - begun.view[0]);
        show([begun.view[0] + shift, begun.view[1] + shift]);
      }
    },
    onPointerUp: (event) => {
      const begun = drag.current;
      drag.current = null;
      if (begun === null || begun.hasMoved) return;
      const [a, b] = look.cursors.length ? look.cursors : [view[0] + (view[1] - view[0]) / 3, view[0] + (2 * (view[1] - view[0])) / 3].map(Math.round);
      setLook({ ...look, cursors: event.shiftKey ? [a, instantOf(event)] : [instantOf(event), b] });
    },
    onWheel: (event) => {
      event.preventDefault();
      zoom(event.deltaY > 0 ? 1.25 : 0.8, Math.min(Math.max(atOf(event), 0), 1));
    },
    onKeyDown: (event) => {
      const step = { ArrowLeft: -0.1, ArrowRight: 0.1 }[event.key];
      if (step !== undefined) show([view[0] + step * (view[1] - view[0]), view[1] + step * (view[1] - view[0])]);
      else if (event.key === '+') zoom(0.5);
      else if (event.key === '-') zoom(2);
      else return;
      event.preventDefault();
    },
  };
}
