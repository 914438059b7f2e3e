// Values in words and numbers with their units.
import { html } from 'htm/preact';
import { named, number } from './words.js';

export function Text({ part, values }) {
  const value = values[part.point];
  const look = (part.bad ?? []).includes(value) ? 'down' : (part.good ?? []).includes(value) ? 'ok' : '';
  const words = named(value, part.names, part.hex_digits);
  return html`<div class="fact" title=${part.about}><dt>${part.label}</dt>
    <dd class=${words.includes('\n') ? 'many' : ''} tabindex=${words.includes('\n') ? 0 : null}>${look ? html`<span class=${`pill ${look}`}>${words}</span>` : words || '–'}</dd></div>`;
}

export function Number({ part, values, units }) {
  return html`<div class="fact" title=${part.about}><dt>${part.label}</dt>
    <dd class="figure">${number(values[part.point], part.decimals)} <span class="unit">${units[part.point]}</span></dd></div>`;
}
