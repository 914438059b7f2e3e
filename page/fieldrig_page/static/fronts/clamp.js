// A terminal: a screw with its name and the level below it; what a person sets is a button, or a field for a number.
import { html } from 'htm/preact';
import { PartInput } from './field.js';
import { number } from './words.js';

export function Clamp({ part, values, units, mayOperate, onOperate }) {
  const whole = values[part.point];
  const value = part.bit === undefined || whole === undefined ? whole : (whole >> part.bit & 1) === 1;
  const isLevel = typeof value === 'boolean';
  const words = isLevel ? (value ? 'on' : 'off') : `${number(value)} ${units[part.point] ?? ''}`.trim();
  const isTyped = part.operated && !isLevel && whole !== undefined;
  const level = isTyped ? html`<${PartInput} part=${part} value=${value} mayOperate=${mayOperate} onOperate=${onOperate} />` : words;
  const body = html`<span class="screw" aria-hidden="true"></span><span class="name">${part.label}</span><span class="level">${level}</span>`;
  const look = `clamp ${part.side} ${value === true ? 'on' : ''}`;
  if (!part.operated || isTyped) return html`<span class=${look} title=${part.about}>${body}</span>`;
  return html`<button type="button" class=${look} title=${part.about} disabled=${!mayOperate || value === undefined} aria-pressed=${value}
    aria-label=${`${part.label}, ${words}`} onClick=${() => onOperate(part, !value)}>${body}</button>`;
}
