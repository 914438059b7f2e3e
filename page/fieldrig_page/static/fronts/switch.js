// A switch that stays where it is put: two positions, or a choice of several.
import { html } from 'htm/preact';

export function Switch({ part, values, mayOperate, onOperate }) {
  const value = values[part.point];
  const { positions } = part;
  if (positions.length === 2) {
    const isSecond = value === positions[1][0];
    const words = value === undefined ? '–' : positions[isSecond ? 1 : 0][1];
    return html`<div class="fact" title=${part.about}><dt>${part.label}</dt><dd>
      <button type="button" class="switch" role="switch" aria-checked=${isSecond} aria-label=${`${part.label}, ${words}`} disabled=${!mayOperate || value === undefined}
        onClick=${() => onOperate(part, positions[isSecond ? 0 : 1][0])}><span class="lever" aria-hidden="true"></span>${words}</button></dd></div>`;
  }
  const at = positions.findIndex(([one]) => one === value);
  return html`<div class="fact" title=${part.about}><dt>${part.label}</dt><dd>
    <select aria-label=${part.label} disabled=${!mayOperate} value=${at} onChange=${(event) => onOperate(part, positions[event.target.value][0])}>
      ${at < 0 && html`<option value="-1">–</option>`}${positions.map(([, words], index) => html`<option value=${index}>${words}</option>`)}</select></dd></div>`;
}
