// Scenes: those that the book holds, and a reader's own .npz (depth, m, and intensity, 0 to 1).
"use strict";
globalThis.laboratory = Object.assign(globalThis.laboratory ?? {}, (() => {
  const { FIRST, CLASSES, wrapLength, unpacked } = globalThis.laboratory;
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

  // Scene of a reader's file, cut to its middle and shrunk as the released protocol does.
  async function ownScene(buffer) {
    const members = await unzipped(buffer);
    if (!members.depth || !members.intensity) throw new Error("Expected depth and intensity in the .npz, got others. Name them so.");
    const [deep, bright] = [array(members.depth), array(members.intensity)];
    if (String(deep.shape) !== String(bright.shape)) throw new Error("Expected depth and intensity of one size, got two. Resample one.");
    const known = deep.numbers.filter(Number.isFinite).sort();
    const shrunk = Math.min(Math.max(FAR / known[Math.floor(0.999 * (known.length - 1))], 0.01), 1);
    const [height, width] = deep.shape.map((size) => Math.min(size, MOST) & ~7);
    const [top, left] = deep.shape.map((size, axis) => (size - [height, width][axis]) >> 1);
    const range = [FIRST, FIRST + CLASSES].map((n) => n * wrapLength(7.15e9));
    const scene = { width, height, mask: new Uint8Array(width * height) };
    const place = (i) => (top + Math.floor(i / width)) * deep.shape[1] + left + (i % width);
    scene.depth = Float64Array.from(scene.mask, (_, i) => shrunk * deep.numbers[place(i)]);
    scene.light = Float64Array.from(scene.mask, (_, i) => (Number.isFinite(scene.depth[i]) ? bright.numbers[place(i)] : 0));
    scene.mask.forEach((_, i) => (scene.mask[i] = scene.depth[i] >= range[0] && scene.depth[i] < range[1]));
    scene.depth.forEach((z, i) => (scene.depth[i] = Number.isFinite(z) ? z : 0));
    if (!scene.mask.includes(1)) throw new Error("Expected depths from 0.75 to 1.2 m once shrunk, got none. Are they in metres?");
    return scene;
  }

  return { unpackedScene, ownScene };
})());
