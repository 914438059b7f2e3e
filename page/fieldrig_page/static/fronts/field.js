// A number or a text that a person sets: by Enter, or when the field is left after a change.
import { html } from 'htm/preact';
import { useState } from 'preact/hooks';
import { isWholeText, number, shown } from './words.js';

export function Field({ part, values, units, mayOperate, onOperate }) {
  return html`<div class="fact" title=${part.about}><dt>${part.label}</dt><dd class="field">
    <${Typed} part=${part} value=${values[part.point]} mayOperate=${mayOperate} onOperate=${onOperate} />
    <span class="unit">${units[part.point]}</span></dd></div>`;
}

export function Typed({ part, value, mayOperate, onOperate }) {
  const [typed, setTyped] = useState(null);
  const isNumber = part.sort !== 'entry';
  const now = isNumber ? number(value, part.decimals).replace('−', '-') : shown(value);
  const set = () => {
    if (typed === null) return;
    const given = isNumber ? Number(typed.replace(',', '.')) : typed;
    setTyped(null);
    const isGiven = !isNumber || (typed.trim() !== '' && Number.isFinite(given)); // an empty field is no zero
    if (isGiven && typed !== now) onOperate(part, isNumber && isWholeText(typed.trim()) ? typed.trim() : given);
  };
  const onKeyDown = (event) => {
    if (event.key === 'Enter') set();
    if (event.key === 'Escape') setTyped(null);
  };
  return html`<input aria-label=${part.label} inputmode=${isNumber ? 'decimal' : 'text'} disabled=${!mayOperate} value=${typed ?? now}
    onInput=${(event) => setTyped(event.target.value)} onBlur=${set} onKeyDown=${onKeyDown} />`;
}
