// Scenes: those that the book holds, a reader's own .npz (depth, m, and intensity, 0 to 1), and phases as .csv.
"use strict";
globalThis.laboratory = Object.assign(globalThis.laboratory ?? {}, (() => {
  const { TAU, FIRST, CLASSES, wrapLength, unpacked } = globalThis.laboratory;
  const FAR = 1.195; // m, to which the released protocol shrinks a scene
  const MOST = 512; // px, of a side

  async function unpackedScene({ width, height, step, depth, light, mask }) {
    const [levels, shades, scored] = await Promise.all([depth, light, mask].map(unpacked));
    return {
      width, height,
      depth: Float64Array.from(new Uint16Array(levels), (level) => level * step),
      light: Float64Array.from(new Uint8Array(shades), (shade) => shade / 255),
      mask: new Uint8Array(scored),
    };
  }

  // Members of a zip file by name.
  async function unzipped(buffer) {
    const view = new DataView(buffer);
    let end = buffer.byteLength - 22;
    while (end >= 0 && view.getUint32(end, true) !== 0x06054b50) end -= 1;
    if (end < 0) throw new Error("Expected an .npz file, got another. Write it by numpy.savez.");
    const members = {};
    let at = view.getUint32(end + 16, true);
    for (let k = view.getUint16(end + 10, true); k > 0; k--) {
      const [packing, size, nameLength, extra, comment] = [[10, 2], [20, 4], [28, 2], [30, 2], [32, 2]].map(
        ([place, bytes]) => (bytes === 2 ? view.getUint16(at + place, true) : view.getUint32(at + place, true)),
      );
      const start = view.getUint32(at + 42, true);
      const name = new TextDecoder().decode(new Uint8Array(buffer, at + 46, nameLength));
      const content = start + 30 + view.getUint16(start + 26, true) + view.getUint16(start + 28, true);
      const held = new Blob([buffer.slice(content, content + size)]);
      const stream = packing ? held.stream().pipeThrough(new DecompressionStream("deflate-raw")) : held.stream();
      members[name.replace(/\.npy$/, "")] = await new Response(stream).arrayBuffer();
      at += 46 + nameLength + extra + comment;
    }
    return members;
  }

  // Array of a .npy member: its shape and its numbers.
  function array(buffer) {
    const view = new DataView(buffer);
    const start = view.getUint8(6) > 1 ? 12 + view.getUint32(8, true) : 10 + view.getUint16(8, true);
    const head = new TextDecoder().decode(new Uint8Array(buffer, 0, start));
    const kinds = { f8: Float64Array, f4: Float32Array, u1: Uint8Array, u2: Uint16Array };
    const kind = kinds[(head.match(/'descr': '[<|](\w\d)'/) ?? [])[1]];
    const shape = ((head.match(/'shape': \((\d+), (\d+)\)/) ?? []).slice(1) ?? []).map(Number);
    if (!kind || shape.length !== 2 || !head.includes("'fortran_order': False")) throw new Error("Expected images of float32 or float64, got other arrays. Convert them.");
    return { shape, numbers: new kind(buffer.slice(start)) };
  }

  // The middle of images of so many rows and columns, in sides that the network takes.
  function middle([rows, columns]) {
    const [height, width] = [rows, columns].map((size) => Math.min(size, MOST) & ~7);
    if (!height || !width) throw new Error(`Expected images of 8 px a side or more, got ${rows} × ${columns}. Take larger ones.`);
    const first = ((rows - height) >> 1) * columns + ((columns - width) >> 1);
    const place = (i) => first + Math.floor(i / width) * columns + (i % width);
    return { width, height, cut: (image) => Float64Array.from({ length: height * width }, (_, i) => image[place(i)]) };
  }

  // Scene of a reader's .npz, cut to its middle and shrunk as the released protocol does.
  async function ownScene(buffer) {
    const members = await unzipped(buffer);
    if (!members.depth || !members.intensity) throw new Error("Expected depth and intensity in the .npz, got others. Name them so.");
    const [deep, bright] = [array(members.depth), array(members.intensity)];
    if (String(deep.shape) !== String(bright.shape)) throw new Error("Expected depth and intensity of one size, got two. Resample one.");
    const known = deep.numbers.filter(Number.isFinite).sort();
    const shrunk = Math.min(Math.max(FAR / known[Math.floor(0.999 * (known.length - 1))], 0.01), 1);
    const { width, height, cut } = middle(deep.shape);
    const depth = cut(deep.numbers).map((z) => (Number.isFinite(z) ? shrunk * z : 0));
    const light = cut(bright.numbers).map((shade, i) => (depth[i] ? shade : 0));
    const range = [FIRST, FIRST + CLASSES].map((n) => n * wrapLength(7.15e9));
    const mask = Uint8Array.from(depth, (z) => z >= range[0] && z < range[1]);
    if (!mask.includes(1)) throw new Error("Expected depths from 0.75 to 1.2 m once shrunk, got none. Are they in metres?");
    return { width, height, depth, light, mask };
  }

  // Measured phases, rad, of a reader's .csv: rows of the lower frequency, then as many of the higher. No truth is known.
  function ownPhases(text) {
    const rows = text.trim().split(/\s*\n\s*/).map((line) => line.split(",").map((word) => Number(word.trim() || NaN)));
    const numbers = rows.flat();
    const [size, columns] = [rows.length / 2, rows[0].length];
    if (!numbers.every(Number.isFinite) || rows.some((row) => row.length !== columns)) throw new Error("Expected rows of finite numbers parted by commas, got others. Write it by numpy.savetxt.");
    if (size % 1) throw new Error(`Expected two images of one size below each other, got ${rows.length} rows. Stack both.`);
    const [least, most] = numbers.reduce(([low, high], angle) => [Math.min(low, angle), Math.max(high, angle)], [Infinity, -Infinity]);
    if (least < -Math.PI - 1e-5 || Math.max(most, most - least) > TAU + 1e-5) throw new Error(`Expected wrapped phases over one turn of 2 pi rad, got ${least} to ${most}. Are they in degrees?`);
    const { width, height, cut } = middle([size, columns]);
    const tones = [0, size * columns].map((start) => {
      const phase = Float32Array.from(cut(numbers.slice(start)), (angle) => (angle + TAU) % TAU);
      return { phase, amplitude: phase.map(() => 1) };
    });
    return { width, height, tones, depth: new Float64Array(width * height), mask: new Uint8Array(width * height) };
  }

  return { unpackedScene, ownScene, ownPhases };
})());
