// The focus of the keyboard is never lost: what is pressed may vanish, or not be for pressing any more, and then the focus
// goes to its neighbour.  Who uses a pointer or a finger is left alone, as a field with the focus opens a keyboard.

const CAN_HAVE_IT = 'a[href], button:not(:disabled), input:not(:disabled), select:not(:disabled), textarea, summary, [tabindex="0"]';

// Watches everything in `root`; `home()` is where the focus goes if the view is another one.
export function keepFocus(root, home) {
  let last = null; // what has the focus by the keyboard, and its places in what is around it, from inside out
  root.addEventListener('focusin', ({ target }) => { last = target.matches(':focus-visible') ? { target, around: around(target, root), isOff: false } : null; });
  // What vanishes is left before it is gone, so whether it is shows after that.
  root.addEventListener('focusout', ({ target }) => queueMicrotask(() => { if (last?.target === target && !isGone(target)) last = null; }));
  addEventListener('hashchange', () => { if (last) last.around = []; });
  const look = () => {
    if (last === null) return;
    const { target, around: places, isOff } = last;
    if (!target.isConnected) {
      last = null;
      (next(places) ?? home())?.focus();
    } else if (target.disabled === true && !isOff) {
      last.isOff = true;
      counterpart(target)?.focus();
    } else if (isOff && !target.disabled) {
      last.isOff = false;
      if (document.activeElement === document.body) target.focus(); // a device has not answered for a while
    }
  };
  new MutationObserver(look).observe(root, { subtree: true, childList: true, attributes: true, attributeFilter: ['disabled'] });
}

const isGone = (target) => !target.isConnected || target.disabled === true;

function around(target, root) {
  const places = [];
  for (let parent = target.parentElement; parent && parent !== root; parent = parent.parentElement)
    places.push({ parent, place: [...parent.querySelectorAll(CAN_HAVE_IT)].indexOf(target) });
  return places;
}

// What is in the place of one that has vanished, or the last before it.
function next(places) {
  for (const { parent, place } of places.filter((one) => one.parent.isConnected)) {
    const others = choicesIn(parent);
    if (others.length > 0) return others[Math.min(Math.max(place, 0), others.length - 1)];
  }
  return null;
}

// What is beside one that is off: Start for Stop.  If all of them are off, the focus waits for it.
function counterpart(target) {
  const others = choicesIn(target.parentElement);
  return others.findLast((one) => isBefore(one, target)) ?? others[0];
}

const choicesIn = (parent) => [...parent.querySelectorAll(CAN_HAVE_IT)].filter((one) => one.checkVisibility());
const isBefore = (one, other) => (one.compareDocumentPosition(other) & Node.DOCUMENT_POSITION_FOLLOWING) !== 0;
