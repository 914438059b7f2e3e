// A device as a card: its name, kind and state, two values, a spark line, and the buses that no strip over it names.
import { html } from 'htm/preact';
import { show } from './life.js';
import { Spark } from './spark.js';

export const familyOf = bus => `f-${['can', 'modbus', 'serial', 'ring', 'pamring', 'wires'].includes(bus.family) ? bus.family : 'other'}`;
const shortKind = kind => kind.replace(/^.*:/, '');

export function Card({ device, part, keys, samples, ports, buses, place, ring, isChosen, isPartner, onChoose }) {
  const now = samples[samples.length - 1] || [];
  const numbers = [...keys.keys()].filter((at) => typeof now[at] === 'number');
  const moves = (at) => samples.some((row) => typeof row[at] === 'number' && row[at] !== now[at]);
  const drawn = numbers.find(moves) ?? numbers[0] ?? keys.findIndex((_, at) => typeof now[at] === 'boolean');  // a line that moves says more
  const level = part.level || 'unknown';
  const classes = ['card', level, isChosen && 'chosen', isPartner && 'partner'].filter(Boolean).join(' ');
  const onClick = event => { if (!event.target.closest('a, button')) onChoose(); };  // the button in it is for the keyboard
  return html`<article class=${classes} style=${place} data-part=${device.name} data-ring=${ring || null} onClick=${onClick}>
    <h3><a href=${`#/device/${device.name}`}>${device.name}</a></h3>
    <p class="kind" title=${device.about}><span>${shortKind(device.kind)}</span><span class="pill ${level}">${part.word || '…'}</span></p>
    <dl class="values">${keys.map((point, at) => html`<div key=${point.key}><dt title=${point.key}>${point.label}</dt>
      <dd>${show(now[at])}${point.unit && html` <span class="unit">${point.unit}</span>`}</dd></div>`)}</dl>
    <footer>${drawn >= 0 ? html`<${Spark} values=${samples.map(row => row[drawn])} name=${`${device.name} ${keys[drawn].label}`} />` : html`<span class="spark" aria-hidden="true"></span>`}
      <span class="ports">${ports.map(bus => html`<a class="port ${familyOf(buses[bus])}" href=${`#/bus/${bus}`}>${bus}</a>`)}</span>
      <button class="more" aria-pressed=${isChosen} aria-label=${`wires and partners of ${device.name}`} title="wires and partners" onClick=${onChoose}>⋯</button></footer>
  </article>`;
}
