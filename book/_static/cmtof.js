// Pictures that open, scenes to turn, sliders: all of it from the book's own files.
"use strict";

const SVG = "http://www.w3.org/2000/svg";

function add(parent, tag, options = {}, text = "") {
  const made = parent.appendChild(document.createElementNS(tag === "svg" ? SVG : parent.namespaceURI, tag));
  for (const [name, value] of Object.entries(options)) made.setAttribute(name, value);
  made.textContent = text;
  return made;
}

// A script of the book, once it has run.
function script(src) {
  return new Promise((done, failed) => {
    const made = add(document.head, "script", { src });
    made.onload = done;
    made.onerror = () => failed(new Error(`Expected ${src}, got none. Build the book again.`));
  });
}

// Where an arrow key leads, which then moves nothing else; nothing for other keys.
function arrow(event) {
  const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  if (way) event.preventDefault();
  return way;
}

// --- pictures ------------------------------------------------------------------------------------

document.addEventListener("click", (event) => {
  const picture = event.target.closest(".bd-article figure img, .bd-article .cell_output img");
  if (!picture || picture.closest("a")) return;
  const box = add(document.body, "dialog", { class: "zoom", "aria-label": "Picture, enlarged" });
  add(box, "img", { src: picture.src, alt: picture.alt });
  box.addEventListener("click", () => box.remove());
  box.addEventListener("keydown", (key) => key.key === "Escape" && box.remove());
  box.showModal();
});

// --- previews ------------------------------------------------------------------------------------
// Equations, figures, terms and sources, shown while the pointer rests on a link to them.

const root = document.documentElement.dataset.content_root || "./";
let preview = null, loaded = null;

function shown(link, previews) {
  const [page, id] = link.href.split("#"), here = new URL(root, location.href).href;
  const found = previews[`${page.replace(here, "")}#${id}`];
  if (!found || preview !== link) return;
  const box = add(document.body, "div", { class: "preview", role: "tooltip" });
  box.innerHTML = found;
  box.querySelectorAll("[id]").forEach((one) => one.removeAttribute("id"));
  window.MathJax?.typesetPromise?.([box]);
  const { left, bottom, top } = link.getBoundingClientRect();
  box.style.left = `${Math.max(8, Math.min(left, innerWidth - box.offsetWidth - 8))}px`;
  const under = bottom + box.offsetHeight + 8 < innerHeight;
  box.style.top = `${under ? bottom + 6 : Math.max(8, top - box.offsetHeight - 6)}px`;
}

const hide = () => {
  preview = null;
  document.querySelectorAll("div.preview").forEach((box) => box.remove());
};

for (const [over, out] of [["mouseover", "mouseout"], ["focusin", "focusout"]]) {
  document.addEventListener(over, (event) => {
    const link = event.target.closest?.(".bd-article a.reference.internal[href*='#']");
    if (!link || link === preview) return;
    hide();
    preview = link;
    // loaded once: a second script of the same constant would be an error
    loaded ??= script(`${root}_static/previews.js`);
    loaded.then(() => shown(link, cmtofPreviews));
  });
  document.addEventListener(out, hide);
}
document.addEventListener("keydown", (key) => key.key === "Escape" && hide());

// --- scenes --------------------------------------------------------------------------------------
// A scene is a script of its own, loaded where it is shown; it calls cmtofScene with its surfaces.

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scaled = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const unit = (a) => scaled(a, 1 / Math.hypot(...a));
const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];

// A surface: its points, and triangles of neighbours with their normals and colours.
function unpacked({ points, colours, shape: [rows, columns] }, longest) {
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const xyz = new Float32Array(bytes(points).buffer), shades = bytes(colours);
  const at = (i) => xyz.subarray(3 * i, 3 * i + 3);
  const near = (i, j) => Math.hypot(...minus(at(i), at(j))) < longest; // false for NaN
  const faces = [];
  for (let row = 0; row + 1 < rows; row++) {
    for (let column = 0; column + 1 < columns; column++) {
      const a = row * columns + column;
      const [b, c, d] = [a + 1, a + columns, a + columns + 1];
      for (const [i, j, k] of [[a, c, b], [b, c, d]]) {
        if (!near(i, j) || !near(j, k) || !near(k, i)) continue;
        const normal = unit(cross(minus(at(j), at(i)), minus(at(k), at(i))));
        faces.push({ corners: [i, j, k], normal, colour: shades.subarray(3 * i, 3 * i + 3) });
      }
    }
  }
  return { xyz, at, faces };
}

// Each point as the eye has it at a focal length of 1: right, down and away.
function seen({ xyz }, { yaw, pitch, centre, distance }) {
  const way = [Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), -Math.cos(yaw) * Math.cos(pitch)];
  const ahead = scaled(way, -1), right = unit(cross([0, 1, 0], ahead)), down = cross(ahead, right);
  const eye = minus(centre, scaled(ahead, distance)), spots = new Float32Array(xyz.length);
  for (let i = 0; i < xyz.length; i += 3) {
    const from = minus(xyz.subarray(i, i + 3), eye), far = dot(from, ahead);
    spots.set([dot(from, right) / far, dot(from, down) / far, far], i);
  }
  return { spots, light: unit([way[0] - 0.5, way[1] - 0.6, way[2]]) };
}

// The farthest triangles first, so that nearer ones cover them.
function draw(canvas, surface, view) {
  const context = canvas.getContext("2d"), { spots, light } = seen(surface, view);
  const far = ({ corners }) => spots[3 * corners[0] + 2];
  const place = (i, axis) => [canvas.width, canvas.height][axis] / 2 + view.focal * (spots[3 * i + axis] - view.middle[axis]);
  context.fillStyle = "white";
  context.fillRect(0, 0, canvas.width, canvas.height);
  for (const face of surface.faces.sort((a, b) => far(b) - far(a))) {
    if (far(face) <= 0) break;
    context.beginPath();
    for (const i of face.corners) context.lineTo(place(i, 0), place(i, 1));
    context.closePath();
    const lit = 0.35 + 0.65 * Math.abs(dot(face.normal, light));
    context.fillStyle = context.strokeStyle = `rgb(${scaled(face.colour, lit)})`;
    context.fill();
    context.stroke();
  }
}

// A view from a place in which a surface fills a canvas, whose height follows.
function fitted(canvas, surface, from) {
  const count = surface.faces.length;
  const centre = surface.faces.reduce((sum, { corners }) => sum.map((one, k) => one + surface.at(corners[0])[k] / count), [0, 0, 0]);
  const way = minus(from, centre), distance = Math.hypot(...way);
  const view = { centre, distance, yaw: Math.atan2(way[0], -way[2]), pitch: Math.asin(way[1] / distance) };
  const { spots } = seen(surface, view);
  const places = [0, 1].map((axis) => surface.faces.map(({ corners }) => spots[3 * corners[0] + axis]).sort((a, b) => a - b));
  const [wide, high] = places.map((all) => 1.08 * (all[count - 1] - all[0]));
  canvas.height = canvas.width * Math.min(0.7, high / wide);
  const middle = places.map((all) => (all[count - 1] + all[0]) / 2);
  return { ...view, middle, focal: Math.min(canvas.width / wide, canvas.height / high) };
}

window.cmtofScene = (name, about) => {
  const place = document.getElementById(name.replace("_", "-")), still = place.querySelector("p, img");
  const box = document.createElement("div");
  still.replaceWith(box);
  const title = still.alt ?? place.firstChild.textContent;
  const canvas = add(box, "canvas", { width: 720, tabindex: 0, role: "img", "aria-label": `${title} Turn it by arrow keys.` });
  const key = add(box, "div", { class: "key" }), bar = add(box, "p"), surfaces = {};
  for (const [label, layer] of Object.entries(about.layers)) surfaces[label] = unpacked(layer, about.longest);
  const labels = Object.keys(surfaces), start = { ...fitted(canvas, surfaces.truth, about.eye), shown: labels[0] };
  let view = { ...start };
  const show = (change = {}) => {
    Object.assign(view, change);
    view.pitch = Math.max(-1.5, Math.min(1.5, view.pitch));
    for (const button of bar.children) button.setAttribute("aria-pressed", button.value === view.shown);
    const { meaning, ends, scale } = about.layers[view.shown];
    key.textContent = `${meaning} ${ends[0]}`;
    add(key, "i", { style: `background: linear-gradient(90deg, ${scale})` });
    key.append(ends[1]);
    requestAnimationFrame(() => draw(canvas, surfaces[view.shown], view));
  };
  const button = (text, act) => add(bar, "button", { type: "button", value: text }, text).addEventListener("click", act);
  const zoom = (factor) => show({ focal: view.focal * factor });
  const turn = (x, y) => show({ yaw: view.yaw - x, pitch: view.pitch - y });
  labels.forEach((label) => button(label, () => show({ shown: label })));
  button("nearer", () => zoom(1.25));
  button("farther", () => zoom(1 / 1.25));
  button("reset", () => show(start));
  const fingers = new Map();
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, event);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId), other = [...fingers.values()].find((one) => one.pointerId !== event.pointerId);
    if (!before) return;
    const apart = ({ clientX, clientY }) => Math.hypot(clientX - other.clientX, clientY - other.clientY);
    fingers.set(event.pointerId, event);
    if (other) zoom(apart(event) / apart(before));
    else turn((event.clientX - before.clientX) / 150, (event.clientY - before.clientY) / 150);
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas && !event.ctrlKey) return; // the page scrolls
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 500));
  });
  canvas.addEventListener("keydown", (event) => {
    const step = arrow(event);
    if (step) turn(0.1 * step[0], 0.1 * step[1]);
  });
  show();
};

// Where a page has no folder of its own, as in JupyterLab, a scene comes with it.
document.querySelectorAll("[data-content_root] .scene").forEach((place) => {
  const load = () => script(`${root}_static/scenes/${place.id.replace("-", "_")}.js`);
  if (place.open === false) place.addEventListener("toggle", load, { once: true });
  else load();
});

// --- two methods on one image: the divider, and what both say of the pixel under the pointer -----

document.querySelectorAll("figure.swipe").forEach(async (figure) => {
  const [slider, told] = ["[type=range]", ".told"].map((part) => figure.querySelector(part));
  const move = () => figure.style.setProperty("--at", `${slider.value}%`);
  slider.addEventListener("input", move);
  move();
  await told.decode();
  const [width, height] = [told.naturalWidth / 2, told.naturalHeight], canvas = document.createElement("canvas");
  Object.assign(canvas, { width: 2 * width, height });
  canvas.getContext("2d").drawImage(told, 0, 0);
  const { data } = canvas.getContext("2d").getImageData(0, 0, 2 * width, height);
  const spot = [width >> 1, height >> 1];
  const tell = (...to) => {
    to.forEach((one, axis) => (spot[axis] = Math.max(0, Math.min([width, height][axis] - 1, Math.floor(one)))));
    const at = 4 * (2 * spot[1] * width + spot[0]), odds = data.subarray(at + 4 * width);
    const wraps = (n) => `${n} wraps, ${((n + odds[0] / 255) * figure.dataset.wrap).toFixed(0)} mm`;
    const sides = JSON.parse(figure.dataset.names).map((name, k) => `${name}: ${wraps(data[at + k + 1])}, odds ${(odds[k + 1] / 2.55).toFixed(0)} %`);
    const all = data[at] ? [`truth: ${wraps(data[at])}`, ...sides] : ["not scored"];
    figure.querySelector("output").textContent = `Pixel (${spot}): ${all.join("; ")}`;
  };
  slider.addEventListener("pointermove", ({ offsetX, offsetY }) => tell((offsetX / slider.offsetWidth) * width, (offsetY / slider.offsetHeight) * height));
  slider.addEventListener("keydown", (event) => {
    const way = event.shiftKey && arrow(event);
    if (way) tell(...way.map((step, axis) => spot[axis] + step));
  });
});

// --- sliders -------------------------------------------------------------------------------------

// A chart of one curve: `x` and `y` run from 0 to 1 of the axes, whose ends are texts.
function chart(place, labels) {
  const svg = add(place, "svg", { viewBox: "0 0 640 268", role: "img", "aria-label": labels.title });
  const put = (...what) => add(svg, ...what);
  put("path", { d: "M60,10 V220 H610", class: "axis" });
  labels.y.forEach((text, i) => {
    const y = 220 - (210 * i) / (labels.y.length - 1);
    put("path", { d: `M60,${y} H610`, class: "grid" });
    put("text", { x: 52, y: y + 5, "text-anchor": "end" }, text);
  });
  labels.x.forEach((text, i) => {
    put("text", { x: 60 + (550 * i) / (labels.x.length - 1), y: 238, "text-anchor": "middle" }, text);
  });
  put("text", { x: 335, y: 262, "text-anchor": "middle" }, labels.under);
  const curve = put("path", { class: "curve" });
  return (points) => {
    const spots = points.map(([x, y]) => `${(60 + 550 * x).toFixed(1)},${(220 - 210 * y).toFixed(1)}`);
    curve.setAttribute("d", `M${spots.join("L")}`);
  };
}

function sliders(place, rows, changed) {
  const values = {};
  for (const { name, label, from, to, step, start, text } of rows) {
    const line = add(place, "label", {}, label);
    const slider = add(line, "input", { type: "range", min: from, max: to, step, value: start, name });
    const said = add(line, "output");
    const read = () => {
      values[name] = Number(slider.value);
      said.textContent = text(values[name]);
    };
    slider.addEventListener("input", () => { read(); changed(values); });
    read();
  }
  changed(values);
}

// I(t) of the two-pass modulator: Eqs. 18 and 19 for any angle of the half-wave plate.
function modulator(place) {
  const plot = chart(place, { title: "Waveform of the modulator", x: ["0", "1", "2"], y: ["0", "", "0.5", "", "1"], under: "time (periods of the drive)" });
  const said = add(place, "p");
  const rows = [
    { name: "eta", label: "drive amplitude η", from: 0.02, to: 1.6, step: 0.02, start: 0.26, text: (v) => `${v.toFixed(2)} rad` },
    { name: "angle", label: "half-wave plate θ", from: 0, to: 45, step: 0.25, start: 11.25, text: (v) => `${v.toFixed(2)}°` },
  ];
  sliders(place, rows, ({ eta, angle }) => {
    const light = (turns) => (1 + Math.cos((8 * angle * Math.PI) / 180 + 2 * eta * Math.sin(2 * Math.PI * turns))) / 2;
    const times = [...Array(321).keys()].map((i) => i / 160);
    plot(times.map((t) => [t / 2, light(t)]));
    const samples = times.slice(0, 160), sum = (of) => samples.reduce((all, t) => all + of(t), 0) / 160;
    const mean = sum(light);
    const harmonics = [1, 2].map((k) => {
      const part = (wave) => sum((t) => light(t) * wave(2 * Math.PI * k * t));
      return (2 * Math.hypot(part(Math.cos), part(Math.sin))) / Math.max(mean, 1e-9);
    });
    said.textContent = `mean ${mean.toFixed(3)}; over the mean, at the drive's frequency ${harmonics[0].toFixed(3)}, at twice that ${harmonics[1].toFixed(3)}`;
  });
}

// Odds of a right wrap from two frequencies and a square of pixels: the small-noise formula.
function odds(place) {
  const plot = chart(place, { title: "Odds of the right wrap", x: ["1", "10", "100", "1000"], y: ["0", "25", "50", "75", "100 %"], under: "side of the pooled square (px)" });
  const said = add(place, "p"), full = 20000, beat = 20e6;
  const rows = [
    { name: "tone", label: "lower frequency", from: -1, to: 1, step: "any", start: Math.log10(7.15), text: (v) => `${(10 ** v).toFixed(2)} GHz` },
    { name: "sigma", label: "Gaussian noise σ", from: 0, to: 4000, step: 50, start: 1200, text: (v) => `${v} counts` },
    { name: "light", label: "brightness I", from: 0.02, to: 1, step: 0.02, start: 1, text: (v) => v.toFixed(2) },
  ];
  // Abramowitz and Stegun 7.1.26, off by 1.5e-7 at most
  const erf = (x) => {
    const t = 1 / (1 + 0.3275911 * x);
    const sum = ((((1.061405429 * t - 1.453152027) * t + 1.421413741) * t - 0.284496736) * t + 0.254829592) * t;
    return 1 - sum * Math.exp(-x * x);
  };
  sliders(place, rows, ({ tone, sigma, light }) => {
    const low = 1e9 * 10 ** tone, high = 2 * low + beat;
    const phase = (Math.PI / (full * light)) * Math.sqrt((full * light) / 4 + sigma ** 2 / 2);
    const spread = (phase * Math.hypot(low, high)) / (2 * Math.PI * beat);
    const right = (side) => erf(side / (2 * Math.SQRT2 * spread));
    plot([...Array(151).keys()].map((i) => [i / 150, right(10 ** (i / 50))]));
    const side = Math.max(1, 1.95996 * 2 * spread);
    said.textContent = `one wrap is ${(149.896229e9 / low).toFixed(1)} mm; one pixel is right in ${(100 * right(1)).toFixed(1)} % of cases; 95 % need ${side.toFixed(0)} × ${side.toFixed(0)} pixels`;
  });
}

// The error of a reading by range, reflectance, power and mode, from the numbers of the chapter's run.
function distance(place) {
  const { modes, base, light } = JSON.parse(place.dataset.numbers);
  const plot = chart(place, { title: "Error of a reading over the range", x: ["0.2", "0.6", "2", "6 m"], y: ["1 µm", "10", "100", "1 mm", "10"], under: "range" });
  const said = add(place, "p");
  const steps = (value) => (10 ** value).toPrecision(2);
  const rows = [
    { name: "range", label: "range", from: -0.7, to: 0.7, step: 0.01, start: Math.log10(base.range), text: (v) => `${steps(v)} m` },
    { name: "share", label: "reflectance", from: -2, to: 0, step: 0.01, start: Math.log10(base.reflectance), text: (v) => `${steps(v + 2)} %` },
    { name: "power", label: "laser power", from: -1, to: 1.5, step: 0.01, start: Math.log10(1e3 * base.power), text: (v) => `${steps(v)} mW` },
    { name: "mode", label: "mode", from: 0, to: 1, step: 1, start: 0, text: (v) => ["7.15 GHz", "14.32 GHz"][v] },
  ];
  sliders(place, rows, ({ range, share, power, mode }) => {
    const { noise, fixed, back, air } = Object.values(modes)[mode];
    const terms = (at) => {
      const far = 10 ** at / base.range, bright = 10 ** share / base.reflectance;
      const level = Math.log10(((10 ** power / 1e3 / base.power) * bright) / far ** 2);
      const spot = ((level - light[0]) / (light[1] - light[0])) * (noise.length - 1);
      const left = Math.max(0, Math.min(noise.length - 2, Math.floor(spot))), part = spot - left;
      const loud = noise[left] ** (1 - part) * noise[left + 1] ** part;
      return { noise: loud, "RF and laser": fixed, "back-reflection": (back * far ** 2) / bright, air: air * far };
    };
    const total = (at) => Math.hypot(...Object.values(terms(at)));
    const ranges = [...Array(101).keys()].map((i) => -0.7 + 0.01478 * i);
    plot(ranges.map((at, i) => [i / 100, Math.min(1, Math.log10(total(at)) / 4)]));
    const told = Object.entries(terms(range)).map(([name, size]) => `${name} ${size.toPrecision(2)} µm`);
    said.textContent = `${told.join(", ")}; together ${total(range).toPrecision(2)} µm`;
  });
}

document.querySelectorAll("[data-play]").forEach((place) => ({ modulator, odds, distance })[place.dataset.play](place));
