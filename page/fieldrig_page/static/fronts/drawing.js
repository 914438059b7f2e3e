// A plain drawing of a plant: one shape that moves with its values.
import { html } from 'htm/preact';
import { number } from './words.js';
import { Conveyor, Heater, Shaft, Slide, Tank, Winder } from './shapes.js';

const SHAPES = { tank: Tank, winder: Winder, conveyor: Conveyor, shaft: Shaft, slide: Slide, heater: Heater };

export function Drawing({ part, values, units }) {
  const given = Object.fromEntries(Object.entries(part.roles).map(([role, key]) => [role, values[key]]));
  const Shape = SHAPES[part.shape];
  const [[role, key]] = Object.entries(part.roles);
  const value = given[role];
  const words = typeof value === 'number' ? `${number(value)} ${units[key] ?? ''}` : String(value ?? 'no value');
  return html`<figure class=${`drawing ${part.shape}`} role="img" aria-label=${`${part.about || part.label}: ${words}`}>
    <${Shape} values=${given} scale=${part.scale ?? {}} /></figure>`;
}
