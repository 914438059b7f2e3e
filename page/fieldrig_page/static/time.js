// Time: virtual time is paused, stepped and run from here; in real time it shows how late the host was, and for what.
import { html } from 'htm/preact';
import { useState } from 'preact/hooks';
import { Events } from './events.js';
import { api, useAnswer, useLive, useWish } from './live.js';
import { named } from './named.js';
import { EMPTY, reduce } from './picture/life.js';
import { View as Processes } from './processes.js';

const STEPS = ['1 ms', '4 ms', '10 ms', '100 ms', '1 s', '10 s', '1 min'];
const SPEEDS = [0.01, 0.1, 1, 10, 100, 'max'];
const S = 1e9;

export function View({ rig, role }) {
  const life = useLive('life', reduce, EMPTY), [graph] = useAnswer('rig');
  useWish('life', true);
  return html`${rig.time === 'virtual' ? html`<${Virtual} rig=${rig} mayOperate=${role === 'operate'} />` : html`<${Real} rig=${rig} />`}
    <${Processes} rig=${rig} role=${role} kept=${keptBy(rig, life)} />${graph && html`<${Events} events=${life.events} buses=${graph.buses} />`}`;
}

// The share of the cycles of its rings that each process keeps: the lowest of its devices.
function keptBy(rig, life) {
  const kept = named();
  for (const [name, process] of Object.entries(rig.processes ?? {})) {
    const own = (process.devices ?? []).map(device => life.parts[device]?.kept).filter(share => share !== undefined);
    if (own.length > 0) kept[name] = Math.min(...own);
  }
  return kept;
}

function Virtual({ rig, mayOperate }) {
  const [step, setStep] = useState('10 ms'), [until, setUntil] = useState(''), [refusal, setRefusal] = useState(null);
  const act = async (path, body) => {
    try { await api('POST', `rig/${path}`, body); setRefusal(null); } catch (cause) { setRefusal(cause); }
  };
  const isPaused = rig.state === 'paused', isOff = !mayOperate; // a long step is ended by Pause
  const left = Number(until) - (rig.now_ns ?? 0) / S;
  const goUntil = event => { event.preventDefault(); act('step', { for: `${Math.round(left * S)} ns` }); };
  return html`<section aria-labelledby="time"><h2 id="time">Virtual time</h2>
    <p class="clock" aria-live="off">${clock((rig.now_ns ?? 0) / S)}</p>
    <p class="row"><span class=${`pill ${isPaused ? 'late' : 'ok'}`}>${isPaused ? 'paused' : 'running'}</span>
      <span class="quiet">${rig.speed === null || rig.speed === undefined ? 'as fast as possible' : `${rig.speed} s per second`}, up for ${clock(rig.uptime_s ?? 0)}</span></p>
    ${refusal && html`<p class="refusal" role="alert"><b>${refusal.what}</b> ${refusal.remedy}</p>`}
    <div class="row">
      ${isPaused ? html`<button class="main" disabled=${isOff} onClick=${() => act('run')}>Run</button>` : html`<button class="main" disabled=${isOff} onClick=${() => act('pause')}>Pause</button>`}
      <label class="field">speed<select disabled=${isOff} value=${rig.speed ?? 'max'} onChange=${event => act('run', { speed: event.target.value === 'max' ? 'max' : Number(event.target.value) })}>
        ${[...new Set([...SPEEDS, rig.speed ?? 'max'])].map(speed => html`<option key=${speed} value=${speed}>${speed === 'max' ? 'as fast as possible' : `${speed} s per second`}</option>`)}</select></label>
      <label class="field">step<select disabled=${isOff} value=${step} onChange=${event => setStep(event.target.value)}>${STEPS.map(one => html`<option key=${one}>${one}</option>`)}</select></label>
      <button disabled=${isOff} onClick=${() => act('step', { for: step })}>Step</button>
      <form class="row" onSubmit=${goUntil}><label class="field">run until (s)<input type="number" min="0" step="any" disabled=${isOff} value=${until} onInput=${event => setUntil(event.target.value)} /></label>
        <button disabled=${isOff || !(left > 0)}>Go</button></form>
    </div></section>`;
}

function Real({ rig }) {
  const late = Object.entries(rig.late ?? {});
  return html`<section aria-labelledby="time"><h2 id="time">Real time</h2>
    <p class="clock"><small class="quiet">up</small> ${clock(rig.uptime_s ?? 0)}</p>
    ${late.length === 0 ? html`<p class="row"><span class="pill ok">on time</span><span class="quiet">The host keeps up with every process.</span></p>`
      : html`<ul>${late.map(([name, words]) => html`<li key=${name} class="row"><span class="pill late">late</span><b>${name}</b> <span>${words}</span></li>`)}</ul>`}</section>`;
}

// Hours, minutes, and seconds with milliseconds.
function clock(seconds) {
  const rest = (seconds % 60).toFixed(3).padStart(6, '0'), minutes = Math.floor(seconds / 60);
  return `${String(Math.floor(minutes / 60)).padStart(2, '0')}:${String(minutes % 60).padStart(2, '0')}:${rest}`;
}
