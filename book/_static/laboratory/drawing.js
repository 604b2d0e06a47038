// Images on canvases: a value a pixel becomes a colour, in one word as canvases hold it.
"use strict";
globalThis.laboratory = Object.assign(globalThis.laboratory ?? {}, (() => {
  const { TAU } = globalThis.laboratory;
  const word = ([red, green, blue]) => ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
  const UNSCORED = word([128, 128, 128]);
  // viridis, coarsely: its colours at equal steps
  const SCALE = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

  function scale(share) {
    const place = Math.min(Math.max(share, 0), 1) * (SCALE.length - 1);
    const k = Math.min(Math.floor(place), SCALE.length - 2);
    return word(SCALE[k].map((low, c) => low + (place - k) * (SCALE[k + 1][c] - low)));
  }

  const hue = (angle) => [0, 1, 2].map((c) => 127.5 + 127.5 * Math.cos(angle - (c * TAU) / 3));
  const HUES = Array.from({ length: 256 }, (_, k) => word(hue((k * TAU) / 256)));
  const circle = (angle) => HUES[Math.floor((256 * angle) / TAU) & 255];

  // Blue where a wrap is too low, red where it is too high, paler where it is off by one or two.
  function deviation(off) {
    if (!off) return word([235, 235, 235]);
    const strength = Math.min(Math.abs(off) / 5, 1);
    const pale = 190 * (1 - strength);
    return word(off > 0 ? [200 + 13 * strength, pale, pale * 0.8] : [pale * 0.6, pale, 178 + 20 * strength]);
  }

  // A picture of a scene's size; colourOf takes the number of a pixel.
  function paint(canvas, { width, height }, colourOf) {
    Object.assign(canvas, { width, height });
    const words = new Uint32Array(width * height);
    for (let i = 0; i < words.length; i++) words[i] = colourOf(i);
    canvas.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(words.buffer), width, height), 0, 0);
  }

  // A cross at a pixel, over a picture.
  function cross(canvas, x, y) {
    const context = canvas.getContext("2d");
    const lines = new Path2D(`M${x - 6},${y + 0.5}h13M${x + 0.5},${y - 6}v13`);
    for (const [strokeStyle, lineWidth] of [["black", 3], ["white", 1]]) {
      Object.assign(context, { strokeStyle, lineWidth });
      context.stroke(lines);
    }
  }

  return { UNSCORED, scale, circle, deviation, paint, cross };
})());
