// A number as a bar between its limits; from 0 if that is between them.
import { html } from 'htm/preact';
import { number } from './words.js';

export function Gauge({ part, values, units }) {
  const value = values[part.point];
  const share = (one) => Math.min(Math.max((one - part.low) / (part.high - part.low), 0), 1) * 100;
  const zero = share(0), at = typeof value === 'number' && !Number.isNaN(value) ? share(value) : zero;
  const words = `${number(value, part.decimals)} ${units[part.point] ?? ''}`;
  return html`<div class="fact" title=${part.about}><dt>${part.label}</dt><dd class="gauge">
    <svg viewBox="0 0 100 6" preserveAspectRatio="none" role="meter" aria-label=${part.label} aria-valuemin=${part.low}
      aria-valuemax=${part.high} aria-valuenow=${Number.isFinite(value) ? value : 0} aria-valuetext=${words}>
      <rect class="scale" width="100" height="6" rx="1" /><rect class="bar" x=${Math.min(zero, at)} width=${Math.abs(at - zero)} height="6" />
      <rect class="zero" x=${Math.min(zero, 99.5)} width=".5" height="6" /></svg>
    <span class="figure">${words}</span></dd></div>`;
}
