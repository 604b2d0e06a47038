// The laboratory's page: what its controls say is simulated, decoded, unwrapped and shown.
"use strict";
(() => {
  const lab = globalThis.laboratory;
  const place = document.getElementById("laboratory");
  const LOW = 7.15e9; // Hz
  const TRAINED = 14.32e9; // Hz, the second tone that the network knows
  const CONTROLS = [
    { name: "sigma", label: "noise σ", from: 0, to: 2400, step: 50, start: 1200, text: (v) => `${v} counts` },
    { name: "brightness", label: "brightness", from: 0.1, to: 2, step: 0.05, start: 1, text: (v) => `× ${v.toFixed(2)}` },
    { name: "high", label: "second tone", from: 14.301, to: 14.42, step: 0.001, start: 14.32, text: (v) => `${v.toFixed(3)} GHz` },
    { name: "offset", label: "offset between the tones", from: -10, to: 10, step: 0.25, start: 0, text: (v) => `${v.toFixed(2)}°` },
    { name: "side", label: "pooling by the beat", from: 1, to: 101, step: 2, start: 41, text: (v) => `${v} × ${v} px` },
  ];
  const VIEWS = {
    phase: "wrapped phase, 7.15 GHz",
    truth: "true wraps",
    beat: "wraps by the averaged beat",
    beatError: "errors of the beat",
    network: "wraps by the light network",
    networkError: "errors of the network",
  };
  const COLOURS = Array.from({ length: lab.CLASSES }, (_, n) => lab.scale(n / (lab.CLASSES - 1)));
  const ERRORS = Array.from({ length: 2 * lab.CLASSES + 1 }, (_, n) => lab.deviation(n - lab.CLASSES));
  const state = { scene: null, session: null, spot: null, shown: null, values: {} };

  const add = (parent, tag, options = {}, text = "") => {
    const made = parent.appendChild(document.createElement(tag));
    for (const [name, value] of Object.entries(options)) made.setAttribute(name, value);
    made.append(text);
    return made;
  };
  const frame = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
  const script = (name) => new Promise((done, failed) => {
    const made = add(document.head, "script", { src: `${place.dataset.folder}/${name}.js` });
    made.onload = done;
    made.onerror = () => failed(new Error(`Expected ${name}.js beside the page, got none. Build the book again.`));
  });

  const controls = add(place, "div", { class: "controls" });
  const chosen = add(add(controls, "label", {}, "scene"), "select", { name: "scene" });
  const own = add(add(controls, "label", {}, "your own .npz"), "input", { type: "file", accept: ".npz" });
  const said = add(place, "p", { class: "said", role: "status" }, "Starting …");
  const views = add(place, "div", { class: "views" });
  const canvases = {};
  const captions = {};
  for (const [name, title] of Object.entries(VIEWS)) {
    const figure = add(views, "figure");
    canvases[name] = add(figure, "canvas", { tabindex: 0, role: "img", "aria-label": title });
    captions[name] = add(figure, "figcaption", {}, title);
  }
  const spotted = add(place, "div", { class: "spot" });
  const spotTitle = add(spotted, "p", { "aria-live": "polite" });
  const bars = add(spotted, "div", { class: "bars" });

  for (const { name, label, from, to, step, start, text } of CONTROLS) {
    const line = add(controls, "label", {}, label);
    const slider = add(line, "input", { type: "range", name, min: from, max: to, step, value: start });
    const output = add(line, "output");
    const read = () => {
      state.values[name] = Number(slider.value);
      output.textContent = text(state.values[name]);
    };
    slider.addEventListener("input", () => { read(); update(); });
    read();
  }

  function measured() {
    const { scene, values } = state;
    const frequencies = [LOW, 1e9 * values.high];
    const size = 4 * scene.depth.length;
    state.normals = state.normals?.length === 2 * size ? state.normals : lab.normals(2 * size, 1);
    const tones = frequencies.map((frequency, k) => {
      const offset = k ? (values.offset * Math.PI) / 180 : 0;
      const images = lab.correlation(scene, { frequency, offset, brightness: values.brightness });
      return lab.decode(lab.withNoise(images, values.sigma, state.normals.subarray(k * size, (k + 1) * size)));
    });
    return { tones, frequencies };
  }

  async function compute() {
    const { scene, session, values } = state;
    const { tones, frequencies } = measured();
    const beat = lab.averagedBeat(tones, scene, frequencies, values.side);
    const found = { tones, beat, truth: lab.trueWraps(scene.depth, LOW), wraps: { beat: Int16Array.from(beat.wraps) } };
    found.knows = Math.abs(frequencies[1] - TRAINED) < 1e4;
    if (session && found.knows) {
      found.network = await lab.classify(session, lab.features(tones, scene), scene);
      found.wraps.network = found.network.wraps;
    }
    return found;
  }

  function drawWraps(name, found) {
    const { scene } = state;
    const wraps = found.wraps[name];
    const missing = found.knows ? ": loading" : ": it knows 14.320 GHz alone";
    captions[name].textContent = VIEWS[name] + (wraps ? "" : missing);
    if (!wraps) {
      for (const canvas of [canvases[name], canvases[`${name}Error`]]) lab.paint(canvas, scene, () => lab.UNSCORED);
      captions[`${name}Error`].textContent = VIEWS[`${name}Error`];
      return;
    }
    const share = lab.shareRight(wraps, found.truth, scene.mask);
    captions[`${name}Error`].textContent = `${VIEWS[`${name}Error`]}: ${(100 * share).toFixed(1)} % right`;
    lab.paint(canvases[name], scene, (i) => COLOURS[wraps[i] - lab.FIRST]);
    lab.paint(canvases[`${name}Error`], scene, (i) => (scene.mask[i] ? ERRORS[wraps[i] - found.truth[i] + lab.CLASSES] : lab.UNSCORED));
  }

  function draw() {
    const { scene, shown, spot } = state;
    lab.paint(canvases.phase, scene, (i) => lab.circle(shown.tones[0].phase[i]));
    lab.paint(canvases.truth, scene, (i) => (scene.mask[i] ? COLOURS[shown.truth[i] - lab.FIRST] : lab.UNSCORED));
    drawWraps("beat", shown);
    drawWraps("network", shown);
    for (const canvas of Object.values(canvases)) lab.cross(canvas, spot.x, spot.y);
    drawSpot();
  }

  function drawSpot() {
    const { scene, shown, spot } = state;
    const i = spot.y * scene.width + spot.x;
    const byBeat = lab.oddsOfWraps(shown.beat.wraps[i], shown.beat.spread[i], shown.tones[0].phase[i]);
    const byNetwork = shown.network?.oddsAt(i);
    const truth = scene.mask[i] ? `true wrap ${shown.truth[i]}` : "not scored";
    const depth = (n) => `${(1000 * (n + shown.tones[0].phase[i] / lab.TAU) * lab.wrapLength(LOW)).toFixed(0)} mm`;
    spotTitle.textContent = `Pixel (${spot.x}, ${spot.y}): ${truth}. Candidates and their odds:`;
    bars.replaceChildren();
    byBeat.forEach((odds, k) => {
      const n = lab.FIRST + k;
      const bar = add(bars, "div", { title: `${n} wraps, ${depth(n)}: beat ${(100 * odds).toFixed(1)} %${byNetwork ? `, network ${(100 * byNetwork[k]).toFixed(1)} %` : ""}` });
      bar.classList.toggle("true", Boolean(scene.mask[i]) && n === shown.truth[i]);
      add(bar, "i", { class: "beat", style: `height:${100 * odds}%` });
      add(bar, "i", { class: "network", style: `height:${byNetwork ? 100 * byNetwork[k] : 0}%` });
      add(bar, "span", {}, n);
    });
  }

  // One computation at a time; what changed meanwhile is computed afterwards.
  let busy = false;
  let again = false;
  async function update() {
    again = true;
    delete place.dataset.milliseconds;
    if (busy || !state.scene) return;
    busy = true;
    try {
      while (again) {
        again = false;
        await frame();
        const began = performance.now();
        state.shown = await compute();
        draw();
        place.dataset.milliseconds = performance.now() - began;
      }
      say(state.session ? "Move the sliders, or point at a pixel; arrow keys move it." : "The network is loading …");
    } catch (error) {
      say(error.message);
    }
    busy = false;
  }

  const say = (text) => { said.textContent = text; };

  function enter(scene) {
    Object.assign(state, { scene, spot: { x: scene.width >> 1, y: scene.height >> 1 } });
    return update();
  }

  function move(x, y) {
    if (!state.shown) return;
    const clip = (value, size) => Math.min(Math.max(Math.round(value), 0), size - 1);
    state.spot = { x: clip(x, state.scene.width), y: clip(y, state.scene.height) };
    draw();
  }

  for (const canvas of Object.values(canvases)) {
    const point = (event) => {
      const box = canvas.getBoundingClientRect();
      const scale = canvas.width / box.width;
      move((event.clientX - box.left) * scale - 0.5, (event.clientY - box.top) * scale - 0.5);
    };
    canvas.addEventListener("pointerdown", point);
    canvas.addEventListener("pointermove", (event) => { if (event.pointerType === "mouse" || event.buttons) point(event); });
    canvas.addEventListener("keydown", (event) => {
      const [x, y] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key] ?? [0, 0];
      if (!x && !y) return;
      event.preventDefault();
      const stride = event.shiftKey ? 10 : 1;
      move(state.spot.x + stride * x, state.spot.y + stride * y);
    });
  }

  chosen.addEventListener("change", async () => enter(await lab.unpackedScene(lab.scenes[chosen.value])));
  async function take(file) {
    try {
      await enter(await lab.ownScene(await file.arrayBuffer()));
      add(chosen, "option", { value: "", selected: "", disabled: "" }, file.name);
    } catch (error) {
      say(error.message);
    }
  }
  own.addEventListener("change", () => own.files[0] && take(own.files[0]));
  place.addEventListener("dragover", (event) => event.preventDefault());
  place.addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files[0]) take(event.dataTransfer.files[0]);
  });

  async function start() {
    await script("scenes");
    for (const name of Object.keys(lab.scenes)) add(chosen, "option", { value: name }, name);
    await enter(await lab.unpackedScene(lab.scenes[chosen.value]));
    await frame();
    await script("runtime");
    state.session = await lab.loadNetwork(lab.runtime);
    await update();
    place.dataset.ready = "yes";
  }
  start().catch((error) => say(error.message));
})();
