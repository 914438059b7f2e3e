// Digits of seven segments, drawn with all that are dark too.
import { html } from 'htm/preact';

const SHAPES = {
  a: '4,2 16,2 13,5 7,5', b: '17,3 17,15 14,13 14,6', c: '17,17 17,29 14,26 14,19', d: '4,30 16,30 13,27 7,27',
  e: '3,17 3,29 6,26 6,19', f: '3,3 3,15 6,13 6,6', g: '5,16 7,14 13,14 15,16 13,18 7,18',
};
const LETTERS = {
  0: 'abcdef', 1: 'bc', 2: 'abdeg', 3: 'abcdg', 4: 'bcfg', 5: 'acdfg', 6: 'acdefg', 7: 'abc', 8: 'abcdefg', 9: 'abcdfg',
  A: 'abcefg', B: 'cdefg', C: 'adef', D: 'bcdeg', E: 'adefg', F: 'aefg', '-': 'g', _: 'd',
};

export function SevenSegment({ part, values }) {
  const text = String(values[part.point] ?? '');
  const lit = part.segments ? [values[part.segments] ?? ''] : digitsOf(text, part.digits);
  const blinks = values[part.blinks] === true;
  return html`<span class=${`segments ${blinks ? 'blinks' : ''}`} role="img" title=${part.about}
    aria-label=${`${part.label}: ${text.trim() || 'dark'}${blinks ? ', blinks' : ''}`}>
    <span class="caption" aria-hidden="true">${part.label}</span>
    <svg viewBox=${`0 0 ${22 * lit.length + 2} 34`} aria-hidden="true">${lit.map((letters, at) => html`
      <g transform=${`translate(${22 * at + 1} 1)`}>${Object.entries(SHAPES).map(([name, points]) => html`
        <polygon class=${letters.includes(name) ? 'lit' : ''} points=${points} />`)}
        <circle class=${letters.includes('p') ? 'lit' : ''} cx="20" cy="30" r="1.6" /></g>`)}</svg></span>`;
}

// The lit segments of each digit, on the right as a counter has them.
function digitsOf(text, digits) {
  const lit = [];
  for (const character of text) {
    if (character === '.' && lit.length) lit[lit.length - 1] += 'p';
    else lit.push(LETTERS[character.toUpperCase()] ?? '');
  }
  const shown = lit.slice(-digits);
  return [...Array(digits - shown.length).fill(''), ...shown];
}
