// The line of a ring through its cards, in their order, with a button on each segment that cuts or heals it.
import { html } from 'htm/preact';
import { useLayoutEffect, useState } from 'preact/hooks';

const STUB = 9;

// The segments of a ring: the line from the card that each leaves to the next one, and where its button is.
function segments(host, stations) {
  const box = host.getBoundingClientRect();
  const rects = new Map([...host.querySelectorAll('[data-ring]')].map(card => [card.dataset.part, card.getBoundingClientRect()]));
  const present = stations.filter(name => rects.has(name));
  const middle = rect => Math.round(rect.top - box.top + rect.height / 2);
  return present.map((name, at) => {
    const from = rects.get(name), next = rects.get(present[at + 1]);
    const x = from.right - box.left, y = middle(from), first = rects.get(present[0]);
    if (!next) // the way back to the master
      return { after: name, to: present[0], x: x + STUB / 2, y, d: `M${x},${y} h${STUB} v-7 M${first.left - box.left},${middle(first)} h-${STUB} v-7` };
    const toX = next.left - box.left, toY = middle(next);
    if (Math.abs(toY - y) < 2 && toX > x && toX - x < 40) return { after: name, to: present[at + 1], x: (x + toX) / 2, y, d: `M${x},${y} H${toX}` };
    const floor = from.bottom - box.top + 6;
    return { after: name, to: present[at + 1], x: x + STUB / 2, y, d: `M${x},${y} h5 V${floor} H${toX - 6} V${toY} H${toX}` };
  });
}

export function Ring({ bus, host, cuts, mayOperate, stamp, onCut, onHeal }) {
  const [lines, setLines] = useState([]);
  useLayoutEffect(() => {
    if (!host.current) return undefined;
    const place = () => setLines(segments(host.current, bus.members));
    const sizes = new ResizeObserver(place);
    for (const card of host.current.querySelectorAll('[data-ring]')) sizes.observe(card);
    sizes.observe(host.current);
    place();
    return () => sizes.disconnect();
  }, [bus, stamp]);
  const numberOf = line => cuts[line.after] ?? (line.after === bus.members[0] ? cuts.master : undefined);
  return html`<svg class="ring f-${bus.family}" aria-hidden="true">${lines.map(line => html`<path key=${line.after} d=${line.d} class=${numberOf(line) === undefined ? '' : 'cut'} />`)}</svg>
    ${lines.map(line => { const number = numberOf(line), isCut = number !== undefined;
      return html`<button key=${line.after} class=${`cut f-${bus.family} ${isCut ? 'open' : ''}`} style=${{ left: `${line.x}px`, top: `${line.y}px` }} disabled=${!mayOperate}
        aria-label=${`${isCut ? 'heal' : 'break'} ${bus.name} between ${line.after} and ${line.to}`} title=${isCut ? 'broken: press to heal' : 'press to break the ring here'}
        onClick=${() => (isCut ? onHeal(number) : onCut(line.after))}>${isCut ? '✕' : ''}</button>`; })}`;
}
