// A lamp: lit, dark or blinking, by colour, by shape and by a word.
import { html } from 'htm/preact';

export function stateOf(part, value) {
  if (value === undefined) return 'dark';
  if ((part.blinks ?? []).includes(value)) return 'blinks';
  const isLit = part.lit ? part.lit.includes(value) : value !== false && value !== 0 && value !== '';
  return isLit ? 'lit' : 'dark';
}

export function Led({ part, values }) {
  const state = stateOf(part, values[part.point]);
  return html`<span class=${`led ${part.colour} ${state}`} role="img" aria-label=${`${part.label}: ${state}`} title=${part.about}>
    <svg viewBox="0 0 20 20" aria-hidden="true"><circle class="glow" cx="10" cy="10" r="10" /><circle class="lens" cx="10" cy="10" r="6" /></svg>
    <span aria-hidden="true">${part.label}</span></span>`;
}
