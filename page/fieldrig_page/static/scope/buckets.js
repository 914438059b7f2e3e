// The newest picture of the scope: a minimum and a maximum per pixel and row, by the number of the bucket.
// Both are NaN in a gap; without news, where the last value holds, they are Infinity and -Infinity.

export class Buckets {
  first = 0; // number of the bucket at the left edge
  count = 0;
  bucketNs = 1;
  offsetNs = 0; // instant of bucket 0
  before = []; // the value of each row that holds at the left edge
  #rows = [];
  #low = new Float64Array(0);
  #high = new Float64Array(0);

  get endNs() { return this.instant(this.first + this.count); }
  get firstNs() { return this.instant(this.first); }

  instant(number) { return number * this.bucketNs + this.offsetNs; }

  // Takes a frame of the topic.
  take(frame) {
    if (frame.bucket_ns === undefined) return;
    if (frame.whole) {
      this.before = frame.before;
      this.bucketNs = frame.bucket_ns;
      this.offsetNs = frame.offset_ns;
      this.#rows = frame.columns.map(() => new Row(frame.count + 2));
    }
    if (!frame.whole) this.#leave(frame.first);
    this.first = frame.first;
    this.count = frame.count;
    for (const part of frame.parts) {
      const low = new Float64Array(part.low); // decoded as a copy, so it is aligned
      const high = new Float64Array(part.high);
      part.rows.forEach((row, place) => {
        this.#rows[row]?.put(part.first, low.subarray(place * part.n, (place + 1) * part.n), high.subarray(place * part.n, (place + 1) * part.n));
      });
    }
  }

  // Keeps the values that hold at the new left edge.
  #leave(first) {
    for (let row = 0; row < this.#rows.length; row++) {
      for (let number = this.first; number < Math.min(first, this.first + this.count); number++) {
        const kept = this.#rows[row];
        if (!kept.has(number)) this.before[row] = null;
        else if (kept.low[kept.slot] !== Infinity) this.before[row] = kept.high[kept.slot];
      }
    }
  }

  // The buckets on the screen from left to right, as [low, high]; they are good until the next call.  A loop over arrays
  // makes no objects: with a call for each bucket they were most of the time of a picture, and its garbage.
  shown(row) {
    if (this.#low.length !== this.count) [this.#low, this.#high] = [new Float64Array(this.count), new Float64Array(this.count)];
    const kept = this.#rows[row];
    if (kept !== undefined) kept.copy(this.first, this.#low, this.#high);
    else for (const values of [this.#low, this.#high]) values.fill(NaN);
    return [this.#low, this.#high];
  }

  // The lowest and highest value on the screen; null if there is none.
  range(row) {
    const [lows, highs] = this.shown(row);
    const held = this.before[row] ?? NaN;
    let low = Infinity;
    let high = -Infinity;
    if (lows[0] === Infinity && held === held) low = high = held;
    for (let place = 0; place < lows.length; place++) {
      if (lows[place] < low) low = lows[place];
      if (highs[place] > high) high = highs[place];
    }
    return low <= high ? [low, high] : null;
  }

  // The newest value of a row that is on the screen, or that holds there; NaN without one.
  newest(row) {
    const [lows, highs] = this.shown(row);
    let isKnown = false;
    for (let place = lows.length - 1; place >= 0; place--) {
      if (lows[place] === lows[place] && lows[place] !== Infinity) return highs[place];
      isKnown ||= lows[place] === Infinity;
    }
    return isKnown ? this.before[row] ?? NaN : NaN;
  }
}

class Row {
  slot = 0;
  #begin = 0;
  #end = 0;

  constructor(length) {
    this.low = new Float64Array(length).fill(NaN);
    this.high = new Float64Array(length).fill(NaN);
  }

  put(first, low, high) {
    const length = this.low.length;
    if (first > this.#end || first < this.#begin) this.#begin = first; // what lies between is not known
    for (let place = Math.max(low.length - length, 0); place < low.length; place++) {
      const slot = mod(first + place, length);
      this.low[slot] = low[place];
      this.high[slot] = high[place];
    }
    this.#end = first + low.length;
    this.#begin = Math.max(this.#begin, this.#end - length);
  }

  // Copies the buckets from one on; those that are not here are NaN.
  copy(first, low, high) {
    const begin = Math.min(Math.max(this.#begin - first, 0), low.length);
    const end = Math.min(Math.max(this.#end - first, begin), low.length);
    const slot = mod(first + begin, this.low.length);
    const turn = Math.min(end - begin, this.low.length - slot);
    for (const [from, to] of [[this.low, low], [this.high, high]]) {
      to.fill(NaN, 0, begin);
      to.set(from.subarray(slot, slot + turn), begin);
      to.set(from.subarray(0, end - begin - turn), begin + turn);
      to.fill(NaN, end);
    }
  }

  // Finds the slot of a bucket; false if it is not here.
  has(number) {
    this.slot = mod(number, this.low.length);
    return number >= this.#begin && number < this.#end;
  }
}

function mod(number, length) {
  return ((number % length) + length) % length;
}
