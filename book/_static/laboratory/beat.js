// Unwrapping by the beat of two frequencies, averaged over a window.
"use strict";
globalThis.laboratory = Object.assign(globalThis.laboratory ?? {}, (() => {
  const { TAU, wrapLength } = globalThis.laboratory;
  const FIRST = 36; // the wraps that are told apart
  const CLASSES = 21;

  const centred = (angle) => angle - TAU * Math.round(angle / TAU); // to -pi to pi

  // Means over windows of a side, px, odd; borders are mirrored. Along rows, then along columns.
  function windowMean(image, width, height, side) {
    const along = (from, length, lines, step, jump) => {
      const to = new Float64Array(from.length);
      const mirrored = Int32Array.from({ length: length + side }, (_, k) => {
        const place = (k - (side - 1) / 2 + 2 * side * length) % (2 * length);
        return step * (place < length ? place : 2 * length - 1 - place);
      });
      for (let line = 0; line < lines; line++) {
        let sum = 0;
        for (let k = 0; k < side; k++) sum += from[line * jump + mirrored[k]];
        for (let k = 0; k < length; k++) {
          to[line * jump + step * k] = sum / side;
          sum += from[line * jump + mirrored[k + side]] - from[line * jump + mirrored[k]];
        }
      }
      return to;
    };
    return along(along(image, width, height, 1, width), height, width, width, 1);
  }

  // Mean beat: its depth in wraps of the lower frequency, and its standard deviation, wraps.
  function averagedBeat(tones, { width, height }, frequencies, side) {
    const [low, high] = tones;
    const multiple = Math.round(frequencies[1] / frequencies[0]);
    const difference = frequencies[1] - multiple * frequencies[0];
    const count = width * height;
    const [real, imaginary, power] = [0, 1, 2].map(() => new Float64Array(count));
    for (let i = 0; i < count; i++) {
      const size = low.amplitude[i] * high.amplitude[i];
      const angle = Math.sign(difference) * (high.phase[i] - multiple * low.phase[i]);
      real[i] = size * Math.cos(angle);
      imaginary[i] = size * Math.sin(angle);
      power[i] = size * size;
    }
    const [x, y, square] = [real, imaginary, power].map((image) => windowMean(image, width, height, side));
    const beatWraps = frequencies[0] / Math.abs(difference); // wraps in which the beat repeats
    const middle = FIRST + CLASSES / 2;
    const wraps = new Float64Array(count);
    const spread = new Float64Array(count);
    for (let i = 0; i < count; i++) {
      const turns = centred(Math.atan2(y[i], x[i]) - (TAU * middle) / beatWraps) / TAU;
      wraps[i] = Math.min(Math.max(middle + turns * beatWraps, FIRST), FIRST + CLASSES - 1e-9);
      const coherent = x[i] * x[i] + y[i] * y[i];
      const scatter = side > 1 ? Math.max(square[i] - coherent, 0) : square[i];
      spread[i] = (Math.sqrt(scatter / (2 * side * side) / coherent) * beatWraps) / TAU;
    }
    return { wraps, spread };
  }

  // Odds of every wrap, whose depth has the measured phase, by a Gaussian about the beat's depth.
  function oddsOfWraps(wraps, spread, phase) {
    const shares = Array.from({ length: CLASSES }, (_, n) => {
      const off = (FIRST + n + phase / TAU - wraps) / Math.max(spread, 0.05);
      return -0.5 * off * off;
    });
    const best = Math.max(...shares);
    const odds = shares.map((share) => Math.exp(share - best));
    const sum = odds.reduce((all, one) => all + one, 0);
    return odds.map((one) => one / sum);
  }

  // Share of scored pixels whose wrap is the true one.
  function shareRight(found, truth, mask) {
    let right = 0;
    let scored = 0;
    for (let i = 0; i < mask.length; i++) {
      if (!mask[i]) continue;
      scored += 1;
      right += found[i] === truth[i];
    }
    return right / scored;
  }

  const trueWraps = (depth, frequency) => Int16Array.from(depth, (z) => Math.floor(z / wrapLength(frequency)));

  return { FIRST, CLASSES, averagedBeat, oddsOfWraps, shareRight, trueWraps };
})());
