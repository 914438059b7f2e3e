// One device: its front, its buses and faults, and all its values.
import { html } from 'htm/preact';
import { useEffect, useState } from 'preact/hooks';
import { api, useLive, useWish } from './live.js';
import { Front } from './fronts/front.js';
import { operate } from './fronts/operate.js';

export function View({ path, role }) {
  return path ? html`<${Device} key=${path} name=${path} mayOperate=${role === 'operate'} />` : html`<${Choice} />`;
}

// All devices, for an address without a name.
function Choice() {
  const [rig, refusal] = useAnswer('rig');
  return html`<section><h2>Devices</h2><${Refused} refusal=${refusal} />
    <ul>${Object.values(rig?.devices ?? {}).map((device) => html`<li key=${device.name}><a href=${`#/device/${encodeURIComponent(device.name)}`}>${device.name}</a> <span class="quiet">${device.about}</span></li>`)}</ul></section>`;
}

function Device({ name, mayOperate }) {
  const [answered, setAnswered] = useState(0);
  const [front, refusal] = useAnswer(`devices/${encodeURIComponent(name)}/front`, answered);
  const [rig] = useAnswer('rig');
  const [refused, setRefused] = useState(null);
  const state = useLive('front', (before, message) => merged(before, message, name), { values: {}, why: '' });
  useWish('front', { devices: [name] });
  // After a restart the device may have another front, such as that of another program.
  useEffect(() => { if (!state.why) setAnswered((before) => before + 1); }, [state.why]);
  const onOperate = (part, value) => operate(name, part.name, value).then(() => setRefused(null), setRefused);
  const buses = rig?.devices?.[name]?.buses ?? [];
  return html`<section class="device" aria-labelledby="device">
    <h2 id="device">${name} ${state.why && html`<span class="pill down">${state.why}</span>`}</h2>
    <p class="ways">${buses.map((bus) => html`<a key=${bus} href=${`#/bus/${encodeURIComponent(bus)}`}>${bus}</a>`)}
      <a href="#/faults">Faults</a> <a href="#/values">Values</a></p>
    <${Refused} refusal=${refusal ?? refused} />
    ${front && html`<${Front} front=${front} values=${state.values} mayOperate=${mayOperate && !state.why} onOperate=${onOperate} />`}
    <${Values} name=${name} />
  </section>`;
}

function merged(before, message, name) {
  const news = message.devices[name];
  if (message.whole && !news) return { values: {}, why: '' };
  if (!news) return before;
  const values = message.whole || news.whole ? news.values : { ...before.values, ...news.values };
  return { values, why: news.why ?? before.why };
}

// All values at the instant at which the list is opened.
function Values({ name }) {
  const [points, setPoints] = useState(null);
  const load = (event) => { if (event.target.open) api('GET', `devices/${encodeURIComponent(name)}/points`).then(setPoints, () => setPoints([])); };
  return html`<details onToggle=${load}><summary>All values</summary>
    ${points && html`<div class="wide" tabindex="0" role="region" aria-label="all values"><table><thead><tr><th scope="col">point</th><th scope="col">value</th><th scope="col">about</th></tr></thead>
      <tbody>${points.map((point) => html`<tr key=${point.key}><th scope="row"><code>${point.key}</code></th><td>${String(point.value)} ${point.unit}</td><td>${point.about}</td></tr>`)}</tbody></table></div>`}</details>`;
}

function Refused({ refusal }) {
  return refusal && html`<p class="refusal" role="alert">${refusal.what}${refusal.remedy && `; ${refusal.remedy}`}</p>`;
}

// The answer to a GET of the API, asked for again when `times` changes.
function useAnswer(path, times = 0) {
  const [answer, setAnswer] = useState([null, null]);
  useEffect(() => {
    let isShown = true;
    const set = (value) => { if (isShown) setAnswer(value); };
    api('GET', path).then((given) => set([given, null]), (cause) => set([null, cause]));
    return () => { isShown = false; };
  }, [path, times]);
  return answer;
}
