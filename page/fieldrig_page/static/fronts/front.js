// The front of a device, from what it declares: the name plate, and groups of parts.
import { html } from 'htm/preact';
import { Clamp } from './clamp.js';
import { Drawing } from './drawing.js';
import { Field } from './field.js';
import { Gauge } from './gauge.js';
import { Key } from './key.js';
import { Led } from './led.js';
import { Lines } from './lines.js';
import { SevenSegment } from './segments.js';
import { Switch } from './switch.js';
import { Number, Text } from './text.js';
import { shown } from './words.js';

const PARTS = {
  led: Led, text: Text, number: Number, gauge: Gauge, 'seven-segment': SevenSegment, lines: Lines, key: Key, switch: Switch,
  knob: Field, entry: Field, clamp: Clamp, drawing: Drawing, gap: () => html`<span class="gap" aria-hidden="true"></span>`,
};
// Parts with a label and a value, which are a list.
const FACTS = new Set(['text', 'number', 'gauge', 'switch', 'knob', 'entry']);

export function Front({ front, values, mayOperate, onOperate }) {
  const rest = { values, units: front.units, mayOperate, onOperate };
  return html`<div class="front">
    <${Plate} plate=${front.plate} values=${values} />
    ${front.groups.map((group) => html`<${Group} key=${group.title} group=${group} rest=${rest} />`)}</div>`;
}

function Plate({ plate, values }) {
  return html`<p class="plate"><b>${[plate.maker, plate.model].filter(Boolean).join(' ') || plate.kind}</b>
    <code>${plate.kind}</code><span>${plate.about}</span>
    ${Object.entries(plate.points).map(([label, key]) => html`<span><span class="quiet">${label}</span> ${shown(values[key]) || '–'}</span>`)}</p>`;
}

function Group({ group, rest }) {
  const show = (part, at) => html`<${PARTS[part.sort]} key=${`${part.name} ${at}`} part=${part} ...${rest} />`;
  const drawings = group.parts.filter((part) => part.sort === 'drawing');
  const facts = group.parts.filter((part) => FACTS.has(part.sort));
  const others = group.parts.filter((part) => part.sort !== 'drawing' && !FACTS.has(part.sort));
  const sorts = new Set(group.parts.map((part) => part.sort));
  const columns = group.columns ? { gridTemplateColumns: `repeat(${group.columns}, minmax(0, 1fr))` } : {};
  return html`<div class=${`group ${[...sorts].map((sort) => `with-${sort}`).join(' ')}`} role="group" aria-label=${group.title || 'front'}>
    ${group.title && html`<h3>${group.title}</h3>`}
    <div class="body">${drawings.map(show)}<div class="stack">
      ${others.length > 0 && html`<div class=${group.columns ? 'places' : 'row'} style=${columns}>${others.map(show)}</div>`}
      ${facts.length > 0 && html`<dl class="rows">${facts.map(show)}</dl>`}</div></div></div>`;
}
