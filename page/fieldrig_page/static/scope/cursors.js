// The table of values beside the canvas, at the newest instant or at two cursors, and the cursors for the keyboard.
import { html } from 'htm/preact';
import { exactly, number } from './canvas.js';

// A value as a person reads it: a state by its name.
export function shown(value, column) {
  if (value === null || value !== value) return 'no value';
  if (column.kind === 'text') return column.states[value] ?? String(value);
  if (column.kind === 'truth') return value ? 'true' : 'false';
  return `${digits(value)}${column.unit ? ` ${column.unit}` : ''}`;
}

// A number with the digits that a measurement needs.  A whole number has all of them; beyond 2^53 it comes as a text.
function digits(value) {
  if (isWhole(value)) return String(value);
  return Number.isInteger(value) ? value.toExponential(5) : String(Number(value.toPrecision(6)));
}

const isWhole = (value) => typeof value === 'string' || Number.isSafeInteger(value);

function difference(a, b, column) {
  if (a === null || b === null || a === undefined || b === undefined) return 'no value';
  if (column.kind === 'text' || column.kind === 'truth') return a === b ? 'same' : 'other';
  const between = isWhole(a) && isWhole(b) ? String(BigInt(b) - BigInt(a)) : digits(Number(b) - Number(a));
  return `${between}${column.unit ? ` ${column.unit}` : ''}`;
}

// `cursors` are instants, or empty; `values` are the values at each of them.
export function Values({ id, isStill, columns, colours, lost, pauses, away, newest, cursors, values, zeroNs }) {
  const hasCursors = cursors.length === 2;
  const [a, b] = cursors;
  return html`
    <div class="wide"><table id=${id} class="scope-values">
      <caption>${hasCursors
        ? `Values at the cursors, ${exactly(Math.abs(b - a))} apart${b === a ? '' : ` (${frequency(b - a)})`}`
        : isStill ? 'Values at the end of the picture' : 'Values now'}</caption>
      <thead><tr><th scope="col">signal</th>${hasCursors
        ? html`<th scope="col" class="number">A ${exactly(a - zeroNs)}</th><th scope="col" class="number">B ${exactly(b - zeroNs)}</th><th scope="col" class="number">B − A</th>`
        : html`<th scope="col" class="number">value</th>`}</tr></thead>
      <tbody>${columns.map((column, row) => html`<tr key=${column.name}>
        <th scope="row"><span class="swatch" style=${{ background: colours[row] }}></span>${column.name.split(/(?<=[/.])/).map((part) => html`${part}<wbr />`)}
          ${lost[row] > 0 && html` <span class="pill down">${lost[row]} lost${away[row] > 0 && ` in ${exactly(away[row], 2)}`}</span>`}
          ${lost[row] === 0 && pauses[row] > 0 && html` <span class="pill late">not sampled ${pauses[row] === 1 ? 'once' : `${pauses[row]} times`}, ${exactly(away[row], 2)}</span>`}
          ${column.trouble && html` <span class="pill down">not recorded</span>`}</th>
        ${hasCursors
          ? html`<td class="number">${shown(values[0]?.[row] ?? null, column)}</td><td class="number">${shown(values[1]?.[row] ?? null, column)}</td><td class="number">${difference(values[0]?.[row], values[1]?.[row], column)}</td>`
          : html`<td class="number">${shown(newest[row] ?? null, column)}</td>`}
      </tr>`)}</tbody>
    </table></div>`;
}

function frequency(ns) {
  const hertz = 1e9 / Math.abs(ns);
  return hertz >= 1e3 ? `${number(hertz / 1e3)} kHz` : `${number(hertz)} Hz`;
}

// Two sliders that move the cursors by pixels.
export function Sliders({ cursors, firstNs, endNs, zeroNs, onMove }) {
  const span = endNs - firstNs;
  return html`${cursors.map((instantNs, place) => html`
    <label key=${place} class="scope-slider">${`Cursor ${'AB'[place]}`}
      <input type="range" min="0" max="1000" step="1" value=${Math.round(((instantNs - firstNs) / span) * 1000)}
        aria-valuetext=${exactly(instantNs - zeroNs)}
        onInput=${(event) => onMove(place, Math.round(firstNs + (event.currentTarget.value / 1000) * span))} />
    </label>`)}`;
}
