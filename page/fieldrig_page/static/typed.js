// A field whose text belongs to the person who types: what comes meanwhile, such as the next sample, does not change it.
import { html } from 'htm/preact';
import { useState } from 'preact/hooks';

// `onGiven(text)` is called by Enter, or when the field is left after a change.  Escape takes the text back.
export function Typed({ value, onGiven, ...rest }) {
  const [text, setText] = useState(null);
  const onKeyDown = (event) => { if (event.key === 'Escape') setText(null); };
  return html`<input ...${rest} value=${text ?? value} onInput=${(event) => setText(event.currentTarget.value)} onBlur=${() => setText(null)}
    onKeyDown=${onKeyDown} onChange=${(event) => { setText(null); onGiven(event.currentTarget.value); }} />`;
}
