// A number or a text of a part that a person sets.
import { html } from 'htm/preact';
import { Typed } from '../typed.js';
import { isWholeText, number, shown } from './words.js';

export function Field({ part, values, units, mayOperate, onOperate }) {
  return html`<div class="fact" title=${part.about}><dt>${part.label}</dt><dd class="field">
    <${PartInput} part=${part} value=${values[part.point]} mayOperate=${mayOperate} onOperate=${onOperate} />
    <span class="unit">${units[part.point]}</span></dd></div>`;
}

export function PartInput({ part, value, mayOperate, onOperate }) {
  const isNumber = part.sort !== 'entry';
  const now = isNumber ? number(value, part.decimals).replace('−', '-') : shown(value);
  const onGiven = (typed) => {
    const text = typed.trim(), given = isNumber ? Number(text.replace(',', '.')) : typed;
    const isGiven = !isNumber || (text !== '' && Number.isFinite(given)); // an empty field is no zero
    if (isGiven) onOperate(part, isNumber && isWholeText(text) ? text : given);
  };
  return html`<${Typed} aria-label=${part.label} inputmode=${isNumber ? 'decimal' : 'text'} disabled=${!mayOperate} value=${now} onGiven=${onGiven} />`;
}
