// A text display: characters in cells, each text in its height, and the cursor.
import { html } from 'htm/preact';

const CELL = 8;
const SIZES = { 1: 1, 2: 2, 3: 4 };

export function Lines({ part, values }) {
  const { rows, columns } = part;
  const lines = linesOf(part, values);
  const texts = values[part.texts] ? values[part.texts].split('\n').map(placed).filter(Boolean) : lines.map((text, at) => ({ line: at + 1, column: 1, size: 1, text }));
  const cursor = (values[part.cursor] ?? '').split(' ').map(Number);
  const spoken = texts.map(({ text }) => text.trim()).filter(Boolean).join(' / ');
  const blinks = values[part.blinks] === true;
  const wide = columns > 20 ? 5 : CELL; // a wide display has narrow characters
  return html`<svg class=${`lines ${blinks ? 'blinks' : ''}`} style=${{ maxWidth: `${3.2 * (wide * columns + 8)}px` }} viewBox=${`-4 -4 ${wide * columns + 8} ${CELL * rows + 8}`} role="img" tabindex="-1"
    aria-label=${`${part.label}: ${spoken || 'empty'}${blinks ? ', blinks' : ''}`}>
    <rect class="glass" x="-4" y="-4" width=${wide * columns + 8} height=${CELL * rows + 8} rx="3" />
    ${texts.map((text) => html`<${Placed} text=${text} wide=${wide} rows=${rows} columns=${columns} />`)}
    ${cursor.length === 2 && html`<rect class="cursor" x=${(cursor[1] - 1) * wide} y=${cursor[0] * CELL - 1} width=${wide} height="1" />`}</svg>`;
}

function Placed({ text, wide, rows, columns }) {
  const { line, column, size } = text;
  const y = (line - 1) * CELL, x = (column - 1) * wide, shown = [...text.text].slice(0, Math.max(columns - column + 1, 0) / size);
  if (y >= rows * CELL || !shown.length) return null;
  return html`<g><rect class="glass" x=${x} y=${y} width=${shown.length * size * wide} height=${size * CELL} />
    ${shown.map((character, at) => character !== ' ' && html`<text x=${x + (at + 0.5) * size * wide} y=${y + size * CELL * 0.84}
      font-size=${size * CELL * 1.15}>${character}</text>`)}</g>`;
}

// The lines of a display: those of one point, or a point for each.
export function linesOf(part, values) {
  const lines = part.lines ? part.lines.map((key) => values[key] ?? '') : String(values[part.point] ?? '').split('\n');
  return lines.slice(0, part.rows);
}

// A text as the terminal tells it: line, column, height, and what it says.
function placed(told) {
  const [, line, column, height, text] = told.match(/^(-?\d+) (-?\d+) (\d) (.*)$/) ?? [];
  return text === undefined ? null : { line: Number(line), column: Number(column), size: SIZES[height] ?? 1, text };
}
