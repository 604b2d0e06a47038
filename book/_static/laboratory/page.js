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
  const state = { scene: null, session: null, spot: null, shown: null };
  const say = (text) => { said.textContent = text; };
  const frame = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));

  const controls = add(place, "div", { class: "controls" });
  const chosen = add(add(controls, "label", {}, "scene"), "select", { name: "scene" });
  const own = add(add(controls, "label", {}, "your own .npz or .csv"), "input", { type: "file", accept: ".npz,.csv" });
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

  // Tones of the scene, and later their network's answer: the same until scene or instrument change.
  function measured() {
    const { scene, values } = state;
    const settings = String(["sigma", "brightness", "high", "offset"].map((name) => values[name]));
    if (state.measured?.scene === scene && state.measured.settings === settings) return state.measured;
    const frequencies = [LOW, 1e9 * values.high];
    const size = 4 * scene.depth.length;
    state.normals = state.normals?.length === 2 * size ? state.normals : lab.normals(2 * size, 1);
    const tones = frequencies.map((frequency, k) => {
      const offset = k ? (values.offset * Math.PI) / 180 : 0;
      if (scene.tones) return lab.withOffset(scene.tones[k], offset);
      const images = lab.correlation(scene, { frequency, offset, brightness: values.brightness });
      return lab.decode(lab.withNoise(images, values.sigma, state.normals.subarray(k * size, (k + 1) * size)));
    });
    return (state.measured = { scene, settings, tones, frequencies });
  }

  async function compute() {
    const { scene, session, values } = state;
    const known = measured(), { tones, frequencies } = known;
    const beat = lab.averagedBeat(tones, scene, frequencies, values.side);
    const found = { tones, beat, truth: scene.truth, wraps: { beat: Int16Array.from(beat.wraps) }, knows: Math.abs(frequencies[1] - TRAINED) < 1e4 };
    if (session && found.knows) {
      found.network = known.network ??= await lab.classify(session, lab.features(tones, scene), scene);
      found.wraps.network = found.network.wraps;
    }
    return found;
  }

  function drawWraps(name, found) {
    const { scene } = state, errors = `${name}Error`;
    const wraps = found.wraps[name] ?? [], missing = found.knows ? ": loading" : ": it knows 14.320 GHz alone";
    const share = 100 * lab.shareRight(wraps, found.truth, scene.mask);
    const told = scene.tones ? ": no truth" : `: ${share.toFixed(1)} % right`;
    captions[name].textContent = VIEWS[name] + (wraps.length ? "" : missing);
    captions[errors].textContent = VIEWS[errors] + (wraps.length ? told : "");
    lab.paint(canvases[name], scene, (i) => COLOURS[wraps[i] - lab.FIRST]);
    lab.paint(canvases[errors], scene, (i) => (scene.mask[i] ? ERRORS[wraps[i] - found.truth[i] + lab.CLASSES] : lab.UNSCORED));
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

  function enter(scene) {
    scene.truth = lab.trueWraps(scene.depth, LOW);
    for (const name of ["sigma", "brightness"]) controls.querySelector(`[name=${name}]`).disabled = Boolean(scene.tones);
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
    const point = ({ offsetX, offsetY }) => {
      const scale = canvas.width / canvas.offsetWidth;
      move(offsetX * scale - 0.5, offsetY * scale - 0.5);
    };
    canvas.addEventListener("pointerdown", point);
    canvas.addEventListener("pointermove", (event) => { if (event.pointerType === "mouse" || event.buttons) point(event); });
    canvas.addEventListener("keydown", (event) => {
      const way = arrow(event), stride = event.shiftKey ? 10 : 1;
      if (way) move(state.spot.x + stride * way[0], state.spot.y + stride * way[1]);
    });
  }

  chosen.addEventListener("change", async () => enter(await lab.unpackedScene(lab.scenes[chosen.value])));
  async function take(file) {
    try {
      await enter(file.name.endsWith(".csv") ? lab.ownPhases(await file.text()) : await lab.ownScene(await file.arrayBuffer()));
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

  sliders(controls, CONTROLS, (values) => {
    state.values = values;
    update();
  });

  async function start() {
    await script(`${place.dataset.folder}/scenes.js`);
    for (const name of Object.keys(lab.scenes)) add(chosen, "option", { value: name }, name);
    await enter(await lab.unpackedScene(lab.scenes[chosen.value]));
    await frame();
    await script(`${place.dataset.folder}/runtime.js`);
    state.session = await lab.loadNetwork(lab.runtime);
    await update();
    place.dataset.ready = "yes";
  }
  start().catch((error) => say(error.message));
})();
