// A key that is pressed and held.
import { html } from 'htm/preact';
import { useHeld } from './operate.js';

export function Key({ part, values, mayOperate, onOperate }) {
  const [isDown, handlers] = useHeld((next) => { if (next || part.released !== undefined) onOperate(part, next); });
  const isHeld = part.released !== undefined && values[part.point] === part.pressed;
  const label = part.about && part.label.length < 3 ? `${part.label}, ${part.about}` : part.label;
  return html`<button type="button" class=${`key ${isDown || isHeld ? 'down' : ''}`} disabled=${!mayOperate} title=${part.about}
    aria-label=${label} aria-pressed=${part.released === undefined ? null : isDown || isHeld} ...${handlers}>${part.label}</button>`;
}
