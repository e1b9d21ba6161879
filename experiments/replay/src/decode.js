// Reads what experiments/trial_replay.cpp writes.

export const FORMAT = 1;

/** @returns {ArrayBuffer} the bytes of a base64 text */
function bytes(base64) {
  const text = atob(base64);
  const array = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) array[i] = text.charCodeAt(i);
  return array.buffer;
}

export const uint16s = (base64) => new Uint16Array(bytes(base64));
export const int16s = (base64) => new Int16Array(bytes(base64));
export const uint32s = (base64) => new Uint32Array(bytes(base64));

/** A signal that is kept where it changes: see experiments/replay_track.h. */
export class Track {
  constructor({ frames, values }, width) {
    this.frames = uint16s(frames);
    this.values = int16s(values);
    this.width = width;
  }

  /** Index of the last key at or before `frame`. */
  key(frame) {
    let low = 0;
    let high = this.frames.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.frames[middle] <= frame) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  number(key, i) {
    return this.values[key * this.width + i];
  }

  /**
   * Where `frame`, which may lie between two, stands: the key, the next one, and how far on the way
   * to it. A key holds until the frame before the next key.
   */
  at(frame) {
    const key = this.key(Math.floor(frame));
    const next = Math.min(key + 1, this.frames.length - 1);
    const share = Math.min(Math.max(frame - (this.frames[next] - 1), 0), 1);
    return { key, next, share: next === key ? 0 : share };
  }
}

/** The vertices (m) and triangles of a mesh. */
export function decodeShape({ lowest, step, vertices, triangles }) {
  const multiples = uint16s(vertices);
  const positions = new Float32Array(multiples.length);
  for (let i = 0; i < multiples.length; ++i) {
    positions[i] = lowest[i % 3] + step[i % 3] * multiples[i];
  }
  const wide = positions.length / 3 > 65536;
  return { positions, triangles: wide ? uint32s(triangles) : uint16s(triangles) };
}

/** A replay with its tracks decoded; `scene` stays as it is. */
export function decodeReplay(replay) {
  if (replay.format !== FORMAT) {
    throw new Error(`a replay of format ${replay.format}; this page reads format ${FORMAT}`);
  }
  const peaks = Array.from(uint16s(replay.peak_force), (steps) => steps * replay.force_step_n);
  return {
    start: replay.start_s,
    interval: replay.interval_s,
    frames: replay.frames,
    positionStep: replay.position_step_m,
    forceStep: replay.force_step_n,
    bodies: replay.bodies.map((track) => new Track(track, 7)),
    contacts: replay.contacts.map((each) => ({
      first: each.first,
      second: each.second,
      track: new Track(each, 6),
    })),
    peaks,
    notes: replay.notes.map(([time, text]) => ({ time, text })),
  };
}
