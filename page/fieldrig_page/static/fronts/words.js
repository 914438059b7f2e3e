// Values of points in words, for eyes and for screen readers.

// The name of a value among pairs of value and name; undefined without one.
export function nameOf(value, names = []) {
  return names.find(([one]) => one === value)?.[1];
}

// The name of a value, or the value itself, with so many hexadecimal digits if there are any.
export function named(value, names, hexDigits) {
  return nameOf(value, names) ?? (hexDigits && Number.isInteger(value) ? hex(value, hexDigits) : shown(value));
}

function hex(value, digits) {
  return `${value.toString(16).toUpperCase().padStart(digits, '0')}h`;
}

// A whole number that JavaScript would round comes and goes as a text of its digits.
export const isWholeText = (value) => typeof value === 'string' && /^[+-]?\d{16,}$/.test(value);

// The number that a text means; the text itself if it is none, one that JSON does not have, or a whole number that JavaScript
// would round.
export function numberOrText(text, number = Number(text)) {
  return text === '' || !Number.isFinite(number) || isWholeText(text) ? text : number;
}

export function shown(value) {
  if (value === undefined || value === null) return '–';
  if (value === true) return 'on';
  if (value === false) return 'off';
  return typeof value === 'number' ? number(value) : String(value);
}

// A number with so many decimals; without `decimals` as short as seven digits have it, and a whole number as it is.
export function number(value, decimals) {
  if (isWholeText(value)) return value;
  if (typeof value !== 'number') return '–';
  const short = Number.isInteger(value) ? value : Number(value.toPrecision(7));
  const text = decimals === undefined ? String(short) : value.toFixed(decimals);
  return text.replace(/^-(0(?:\.0*)?)$/, '$1').replace('-', '−');
}
