// The light network: its inputs (Fig. 5, Eq. 5), and its run by ONNX Runtime.
"use strict";
globalThis.laboratory = Object.assign(globalThis.laboratory ?? {}, (() => {
  const { TAU, WHITE, FIRST, CLASSES } = globalThis.laboratory;
  const ORDER = 5; // highest power of two of the Fourier features
  const FULL_AMPLITUDE = WHITE / Math.PI;
  const CHANNELS = 38;

  // Amplitudes so dim or bright as no training had are scaled: the brightest tenth begins at white.
  function usualAmplitudes(tones) {
    const bright = ({ amplitude }) => {
      const sorted = Float32Array.from(amplitude).sort();
      const place = 0.9 * (sorted.length - 1);
      const below = sorted[Math.floor(place)];
      return below + (place % 1) * (sorted[Math.ceil(place)] - below);
    };
    const share = bright(tones[0]) / FULL_AMPLITUDE;
    if (share > 0.1 && share < 2) return tones.map((tone) => tone.amplitude);
    const factors = tones.map((tone) => FULL_AMPLITUDE / Math.max(bright(tone), 1e-30));
    return tones.map(({ amplitude }, k) => amplitude.map((a) => a * factors[k]));
  }

  // Phases, Fourier features, edges, amplitudes and beat: (38, H, W).
  function features(tones, { width, height }) {
    const count = width * height;
    const amplitudes = usualAmplitudes(tones);
    const inputs = new Float32Array(CHANNELS * count);
    let used = 0;
    const channel = () => inputs.subarray(used * count, ++used * count);
    for (const { phase } of tones) channel().set(phase.map((angle) => angle / TAU));
    const [first, second] = tones.map(({ phase }) => fourier(phase, Array.from({ length: 2 * ORDER + 2 }, channel)));
    for (const { phase } of tones) edges(phase, width, height, [channel(), channel(), channel(), channel()]);
    for (const amplitude of amplitudes) channel().set(amplitude.map((a) => (Math.log1p(a) - 7.5) / 0.8));
    const [cosine, sine] = [channel(), channel()]; // of the second phase less twice the first
    for (let i = 0; i < count; i++) {
      const weight = Math.sqrt(amplitudes[0][i] * amplitudes[1][i]) / FULL_AMPLITUDE;
      cosine[i] = weight * (second[0][i] * first[2][i] + second[1][i] * first[3][i]);
      sine[i] = weight * (second[1][i] * first[2][i] - second[0][i] * first[3][i]);
    }
    return inputs;
  }

  // Cosine and sine of the phase, of twice, four times … the phase.
  function fourier(phase, channels) {
    for (let i = 0; i < phase.length; i++) {
      let x = Math.cos(phase[i]);
      let y = Math.sin(phase[i]);
      for (let k = 0; k <= ORDER; k++) {
        channels[2 * k][i] = x;
        channels[2 * k + 1][i] = y;
        const twice = 2 * x * y;
        x = (x - y) * (x + y);
        y = twice;
      }
    }
    return channels;
  }

  // Wrapped differences to the left, above, above left and below left; zero at the border.
  function edges(phase, width, height, channels) {
    const ways = [[0, -1], [-1, 0], [-1, -1], [1, -1]];
    ways.forEach(([down, right], k) => {
      for (let y = Math.max(0, -down); y < height - Math.max(0, down); y++) {
        for (let x = Math.max(0, -right); x < width; x++) {
          const step = phase[y * width + x] - phase[(y + down) * width + x + right];
          channels[k][y * width + x] = step - TAU * Math.round(step / TAU);
        }
      }
    });
  }

  async function unpacked(text) {
    const { body } = await fetch(`data:;base64,${text}`);
    return new Response(body.pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
  }

  // A session of ONNX Runtime with the network, both from data that a script holds.
  async function loadNetwork(packed) {
    const [runtime, loader, binary, model] = await Promise.all(
      ["script", "loader", "binary", "model"].map((name) => unpacked(packed[name])),
    );
    const address = (content) => URL.createObjectURL(new Blob([content], { type: "text/javascript" }));
    await script(address(runtime));
    Object.assign(ort.env.wasm, { wasmBinary: binary, wasmPaths: { mjs: address(loader) }, numThreads: 1 });
    return ort.InferenceSession.create(new Uint8Array(model), { executionProviders: ["wasm"] });
  }

  // Likeliest wrap of every pixel, and the odds of all: (21, H, W), a softmax.
  async function classify(session, inputs, { width, height }) {
    const image = new ort.Tensor("float32", inputs, [1, CHANNELS, height, width]);
    const { wraps: { data } } = await session.run({ [session.inputNames[0]]: image });
    return likeliest(data, width * height);
  }

  function likeliest(weights, count) {
    const wraps = new Int16Array(count).fill(FIRST);
    const oddsAt = (i) => {
      const shares = Array.from({ length: CLASSES }, (_, n) => Math.exp(weights[n * count + i] - weights[(wraps[i] - FIRST) * count + i]));
      const sum = shares.reduce((all, one) => all + one, 0);
      return shares.map((one) => one / sum);
    };
    for (let n = 1; n < CLASSES; n++) {
      for (let i = 0; i < count; i++) if (weights[n * count + i] > weights[(wraps[i] - FIRST) * count + i]) wraps[i] = FIRST + n;
    }
    return { wraps, oddsAt };
  }

  return { features, unpacked, loadNetwork, classify, likeliest };
})());
