// Correlation images of a scene (Eq. 8), and their phase and amplitude (Eq. 9).
"use strict";
globalThis.laboratory = Object.assign(globalThis.laboratory ?? {}, (() => {
  const TAU = 2 * Math.PI;
  const SPEED_OF_LIGHT = 299792458; // m/s
  const WHITE = 20000; // counts, G T of a white surface

  // Standard normal numbers of a seed (mulberry32, Box and Muller).
  function normals(count, seed) {
    let state = seed >>> 0;
    const uniform = () => {
      state = (state + 0x6d2b79f5) >>> 0;
      let mixed = Math.imul(state ^ (state >>> 15), 1 | state);
      mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
      return ((mixed ^ (mixed >>> 14)) >>> 0) / 4294967296;
    };
    const drawn = new Float32Array(count);
    for (let i = 0; i < count; i += 2) {
      const size = Math.sqrt(-2 * Math.log(1 - uniform()));
      const angle = TAU * uniform();
      drawn[i] = size * Math.cos(angle);
      if (i + 1 < count) drawn[i + 1] = size * Math.sin(angle);
    }
    return drawn;
  }

  // Images (4, H, W), counts, at psi = 0, 1/2, 1 and 3/2 pi; an offset, rad, is in every phase.
  function correlation({ depth, light }, { frequency, offset = 0, brightness = 1 }) {
    const count = depth.length;
    const images = new Float32Array(4 * count);
    for (let i = 0; i < count; i++) {
      const turns = (2 * frequency * depth[i]) / SPEED_OF_LIGHT;
      const angle = TAU * (turns - Math.floor(turns)) + offset;
      const signal = WHITE * Math.min(light[i] * brightness, 1);
      const x = (signal * Math.cos(angle)) / Math.PI;
      const y = (signal * Math.sin(angle)) / Math.PI;
      images[i] = signal / 2 + x;
      images[i + count] = signal / 2 - y;
      images[i + 2 * count] = signal / 2 - x;
      images[i + 3 * count] = signal / 2 + y;
    }
    return images;
  }

  // Gaussian noise of sigma, counts, and that of photons, which at thousands of them is Gaussian.
  function withNoise(images, sigma, normal) {
    return images.map((mean, i) => mean + Math.sqrt(Math.max(mean, 0) + sigma * sigma) * normal[i]);
  }

  // Wrapped phase, rad, 0 to 2 pi, and amplitude, counts.
  function decode(images) {
    const count = images.length / 4;
    const phase = new Float32Array(count);
    const amplitude = new Float32Array(count);
    for (let i = 0; i < count; i++) {
      const x = (images[i] - images[i + 2 * count]) / 2;
      const y = (images[i + 3 * count] - images[i + count]) / 2;
      const angle = Math.atan2(y, x);
      phase[i] = angle < 0 ? angle + TAU : angle;
      amplitude[i] = Math.hypot(x, y);
    }
    return { phase, amplitude };
  }

  // Measured phases with an offset, rad, of at most a turn.
  const withOffset = ({ phase, amplitude }, offset) => ({ phase: phase.map((angle) => (angle + offset + TAU) % TAU), amplitude });

  const wrapLength = (frequency) => SPEED_OF_LIGHT / (2 * frequency); // m

  return { TAU, WHITE, normals, correlation, withNoise, decode, withOffset, wrapLength };
})());
