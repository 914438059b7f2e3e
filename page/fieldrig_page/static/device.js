// One device: its front, its buses and faults, and all its values.
import { html } from 'htm/preact';
import { useEffect, useState } from 'preact/hooks';
import { useAnswer, useLive, useWish } from './live.js';
import { Active, useFaults } from './faults.js';
import { Front } from './fronts/front.js';
import { operate } from './fronts/operate.js';
import { Refused } from './rows.js';
import { Values } from './values.js';

export function View({ path, role }) {
  return path ? html`<${Device} key=${path} name=${path} role=${role} />` : html`<${Choice} />`;
}

// All devices, for an address without a name.
function Choice() {
  const [rig, refusal] = useAnswer('rig');
  return html`<section><h2>Devices</h2><${Refused} refusal=${refusal} />
    <ul>${Object.values(rig?.devices ?? {}).map((device) => html`<li key=${device.name}><a href=${`#/device/${encodeURIComponent(device.name)}`}>${device.name}</a> <span class="quiet">${device.about}</span></li>`)}</ul></section>`;
}

function Device({ name, role }) {
  const [answered, setAnswered] = useState(0);
  const [front, refusal] = useAnswer(`devices/${encodeURIComponent(name)}/front`, answered);
  const [rig] = useAnswer('rig');
  const [refused, setRefused] = useState(null);
  const { faults } = useFaults();
  const state = useLive('front', (before, message) => merged(before, message, name), { values: {}, why: '' });
  useWish('front', { devices: [name] });
  // After a restart the device may have another front, such as that of another program.
  useEffect(() => { if (!state.why) setAnswered((before) => before + 1); }, [state.why]);
  const onOperate = (part, value) => operate(name, part.name, value).then(() => setRefused(null), setRefused);
  const mayOperate = role === 'operate' && !state.why, path = encodeURIComponent(name);
  return html`<section class="device" aria-labelledby="device">
      <h2 id="device">${name} ${state.why && html`<span class="pill down">${state.why}</span>`}</h2>
      <p class="ways">${(rig?.devices?.[name]?.buses ?? []).map((bus) => html`<a key=${bus} href=${`#/bus/${encodeURIComponent(bus)}`}>${bus}</a>`)}
        <a href=${`#/values/${path}`}>Values</a> <a href=${`#/faults/${path}`}>New fault</a></p>
      <${Refused} refusal=${refusal ?? refused} />
      ${front && html`<${Front} front=${front} values=${state.values} mayOperate=${mayOperate} onOperate=${onOperate} />`}
    </section>
    <${Active} faults=${faults} role=${role} part=${name} />
    <${AllValues} name=${name} role=${role} />`;
}

function merged(before, message, name) {
  const news = message.devices[name];
  if (message.whole && !news) return { values: {}, why: '' };
  if (!news) return before;
  const values = message.whole || news.whole ? news.values : { ...before.values, ...news.values };
  return { values, why: news.why ?? before.why };
}

// The list of all values, which are read only while it is open.
function AllValues({ name, role }) {
  const [isOpen, setIsOpen] = useState(false);
  return html`<section><details onToggle=${(event) => setIsOpen(event.target.open)}><summary>All values</summary>
    ${isOpen && html`<${Values} device=${name} role=${role} />`}</details></section>`;
}
