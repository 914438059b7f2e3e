// One device: its front, its buses and faults, and all its values.
import { html } from 'htm/preact';
import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks';
import { live, useAnswer, useLive, useWish } from './live.js';
import { Active, useFaults } from './faults.js';
import { Front } from './fronts/front.js';
import { operate } from './fronts/operate.js';
import { named } from './named.js';
import { Refused } from './rows.js';
import { instant } from './traffic.js';
import { Values } from './values.js';

const MOST_EMERGENCIES = 100;

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
  const state = useLive('front', (before, message) => merged(before, message, name), NOTHING);
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
    ${canOf(rig, name).length > 0 && html`<${Emergencies} name=${name} buses=${canOf(rig, name)} />`}
    ${(rig?.devices?.[name]?.logs ?? []).map((key) => html`<${Log} key=${key} name=${name} point=${key} />`)}
    <${AllValues} name=${name} role=${role} />`;
}

function merged(before, message, name) {
  const news = message.devices[name];
  if (message.whole && !news) return NOTHING;
  if (!news) return before;
  const values = message.whole || news.whole ? news.values : named(before.values, news.values);
  return { values, why: news.why ?? before.why };
}

const NOTHING = { values: named(), why: '' };
const LOG_MS = 1000;
const NEAR_END = 24; // pixels

// The messages that a device keeps itself, such as those of a message logger, asked for again and again.
function Log({ name, point }) {
  const [times, setTimes] = useState(0);
  const [answer, refusal] = useAnswer(`devices/${encodeURIComponent(name)}/points/${encodeURIComponent(point)}`, times);
  useEffect(() => {
    const timer = setInterval(() => setTimes((before) => before + 1), LOG_MS);
    return () => clearInterval(timer);
  }, []);
  // The newest message is in sight, unless somebody reads an older one.
  const box = useRef(null), isAtEnd = useRef(true);
  useLayoutEffect(() => { if (box.current && isAtEnd.current) box.current.scrollTop = box.current.scrollHeight; }, [answer?.value]);
  const onScroll = ({ currentTarget: { scrollTop, clientHeight, scrollHeight } }) => { isAtEnd.current = scrollTop + clientHeight > scrollHeight - NEAR_END; };
  const title = `Messages: ${point}`;
  return html`<section aria-labelledby=${`log-${point}`}><h2 id=${`log-${point}`}>${title}</h2><p class="quiet">${answer?.about}</p><${Refused} refusal=${refusal} />
    ${answer?.value ? html`<pre class="log" tabindex="0" ref=${box} onScroll=${onScroll}>${answer.value}</pre>` : answer && html`<p class="quiet">none</p>`}</section>`;
}

const canOf = (rig, name) => (rig?.devices?.[name]?.buses ?? []).filter((bus) => rig.buses[bus].family === 'can');

// The EMCY messages of a device on its CAN buses, as they come, the newest first.
function Emergencies({ name, buses }) {
  const [rows, setRows] = useState(null);
  useWish('traffic', { buses, kind: 'EMCY', node: name });
  useEffect(() => live.on('traffic', (frame) => {
    const news = (frame.rows ?? []).filter((row) => row[4] === name); // the filter takes a part of a name as well
    if (frame.whole || news.length > 0) setRows((before) => [...(frame.whole ? [] : before ?? []), ...news].slice(-MOST_EMERGENCIES));
  }), [name]);
  return html`<section aria-labelledby="emergencies"><h2 id="emergencies">Emergency messages</h2>
    ${!rows?.length ? html`<p class="quiet">${rows ? 'none since this page was opened' : 'asking ...'}</p>`
      : html`<ol class="events emergencies" tabindex="0" aria-labelledby="emergencies">${[...rows].reverse().map(([number, time, bus, , , , text]) => html`<li key=${`${bus}/${number}`}>
        <time class="quiet">${instant(time)}</time><span><a href=${`#/traffic/${encodeURIComponent(bus)}`}>${bus}</a></span><span>${text}</span></li>`)}</ol>`}</section>`;
}

// The list of all values, which are read only while it is open.
function AllValues({ name, role }) {
  const [isOpen, setIsOpen] = useState(false);
  return html`<section><details onToggle=${(event) => setIsOpen(event.target.open)}><summary>All values</summary>
    ${isOpen && html`<${Values} device=${name} role=${role} />`}</details></section>`;
}
