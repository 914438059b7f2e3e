// A field whose text belongs to the person who types: what comes meanwhile, such as the next sample, does not change it.
import { html } from 'htm/preact';
import { useState } from 'preact/hooks';

// `onGiven(text)` is called by Enter, or when the field is left, if the text is another one.  Escape takes it back.
export function Typed({ value, onGiven, disabled, ...rest }) {
  const [typed, setTyped] = useState(null);
  const give = () => {
    if (typed === null) return;
    setTyped(null);
    if (typed !== String(value)) onGiven(typed);
  };
  const onKeyDown = (event) => {
    if (event.key === 'Enter') give();
    if (event.key === 'Escape') setTyped(null);
  };
  // What is being typed is not taken away while a device does not answer: what it is given then has an answer of its own.
  return html`<input ...${rest} disabled=${disabled && typed === null} value=${typed ?? value} onInput=${(event) => setTyped(event.currentTarget.value)}
    onBlur=${give} onKeyDown=${onKeyDown} />`;
}
