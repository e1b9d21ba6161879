import assert from 'node:assert/strict';
import test from 'node:test';
import { decodeReplay, decodeShape, Track } from '../../../experiments/replay/src/decode.js';

const base64 = (array) => Buffer.from(array.buffer).toString('base64');
const track = (frames, values) =>
  ({ frames: base64(Uint16Array.from(frames)), values: base64(Int16Array.from(values)) });

test('a key holds until the frame before the next one', () => {
  const signal = new Track(track([0, 10, 11], [5, -6, 7]), 1);
  assert.equal(signal.number(signal.key(0), 0), 5);
  assert.equal(signal.number(signal.key(9), 0), 5);
  assert.equal(signal.number(signal.key(10), 0), -6);
  assert.equal(signal.number(signal.key(500), 0), 7);
  assert.deepEqual(signal.at(8.9), { key: 0, next: 1, share: 0 });
  assert.deepEqual(signal.at(9.25), { key: 0, next: 1, share: 0.25 });
  assert.deepEqual(signal.at(10.5), { key: 1, next: 2, share: 0.5 });
  assert.deepEqual(signal.at(11.5), { key: 2, next: 2, share: 0 });
});

test('vertices are multiples of a step from the lowest corner', () => {
  const shape = decodeShape({
    lowest: [-1, 0, 2], step: [0.5, 1, 0],
    vertices: base64(Uint16Array.from([0, 3, 9, 4, 0, 65535])),
    triangles: base64(Uint16Array.from([0, 1, 0])),
  });
  assert.deepEqual([...shape.positions], [-1, 3, 2, 1, 0, 2]);
  assert.deepEqual([...shape.triangles], [0, 1, 0]);
});

test('a replay of another format is refused', () => {
  assert.throws(() => decodeReplay({ format: 2 }), /format 2/);
});
