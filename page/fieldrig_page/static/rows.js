// A table of any number of rows of one height, of which only those on the screen exist.
import { html } from 'htm/preact';
import { useLayoutEffect, useRef, useState } from 'preact/hooks';

const SPARE = 8; // rows above and below the screen, so that a quick scroll shows no gap

// `columns` are `{title, look?}`; `row(index)` returns the key of a row and its cells, as `{key, cells, look?}`.
// `height` is that of a row, in pixels.  `onShow(first, last)` is told which rows are on the screen.  With `follows`
// the end stays on the screen for as long as it is there.  A new `goal`, `{index}`, brings that row to the middle.
export function Rows({ label, columns, count, row, height, onShow, follows, goal }) {
  const box = useRef(null);
  const [place, setPlace] = useState({ top: 0, high: 600 });
  const isAtEnd = useRef(true);
  const look = () => {
    if (box.current === null) return; // the table has gone, its last scroll has not
    const { scrollTop, clientHeight, scrollHeight } = box.current;
    isAtEnd.current = scrollTop + clientHeight > scrollHeight - 2 * height;
    setPlace((before) => (before.top === scrollTop && before.high === clientHeight ? before : { top: scrollTop, high: clientHeight }));
  };
  useLayoutEffect(() => {
    look();
    const sizes = new ResizeObserver(look);
    sizes.observe(box.current);
    return () => sizes.disconnect();
  }, []);
  useLayoutEffect(() => {
    if (follows && isAtEnd.current) box.current.scrollTop = box.current.scrollHeight;
  }, [count, follows]);
  useLayoutEffect(() => {
    if (goal) box.current.scrollTop = goal.index * height - box.current.clientHeight / 2;
  }, [goal]);
  const first = Math.max(0, Math.min(Math.floor(place.top / height), count) - SPARE);
  const last = Math.min(count, Math.ceil((place.top + place.high) / height) + SPARE);
  useLayoutEffect(() => { onShow?.(first, last); }, [first, last, count]);
  const shown = Array.from({ length: Math.max(0, last - first) }, (_, at) => ({ index: first + at, ...row(first + at) }));
  return html`<div class="rows" ref=${box} onScroll=${look} tabindex="0" role="region" aria-label=${label}>
    <table aria-rowcount=${count + 1}>
      <thead><tr aria-rowindex="1">${columns.map((column) => html`<th scope="col" class=${column.look ?? ''}>${column.title}</th>`)}</tr></thead>
      <tbody>
        ${first > 0 && html`<tr class="gap" aria-hidden="true"><td colspan=${columns.length} style=${{ height: `${first * height}px` }}></td></tr>`}
        ${shown.map(({ index, key, cells, look: sort }) => html`<tr key=${key} class=${sort ?? ''} aria-rowindex=${index + 2} style=${{ height: `${height}px` }}>
          ${cells.map((cell, at) => html`<td class=${columns[at].look ?? ''}>${cell}</td>`)}</tr>`)}
        ${last < count && html`<tr class="gap" aria-hidden="true"><td colspan=${columns.length} style=${{ height: `${(count - last) * height}px` }}></td></tr>`}
      </tbody>
    </table>
  </div>`;
}

// A refusal as the rig words it.
export function Refused({ refusal }) {
  return refusal && html`<p class="refusal" role="alert">${refusal.what}${refusal.remedy && html`<br /><span class="quiet">${refusal.remedy}</span>`}</p>`;
}
