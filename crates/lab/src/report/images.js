// Images as they are embedded: half floats or bytes, deflated, in base64.
const data = JSON.parse(document.getElementById("viewer-data").textContent);
const [width, height] = data.size;
const LUMINANCE = [0.2126, 0.7152, 0.0722];

const HALF = new Float32Array(65536);
for (let bits = 0; bits < 65536; bits++) {
  const exponent = (bits >> 10) & 31, fraction = bits & 1023;
  const size = exponent ? 2 ** (exponent - 15) * (1 + fraction / 1024) : 2 ** -14 * (fraction / 1024);
  HALF[bits] = bits & 0x8000 ? -size : size;
}

const kept = new Map();

// What is made once of something: a promise of it.
function once(key, make) {
  if (!kept.has(key)) kept.set(key, make());
  return kept.get(key);
}

async function bytes(id) {
  const packed = Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Radiance, three numbers a pixel. Embedded are first the high bytes of all numbers, then the low ones.
function radiance(id) {
  return once(id, async () => {
    const all = await bytes(id), count = all.length / 2;
    const values = new Float32Array(count);
    for (let i = 0; i < count; i++) values[i] = HALF[(all[i] << 8) | all[count + i]];
    return values;
  });
}

// Errors of one channel pair by the metrics that are means over pixels and channels, of exposed values.
const BY_CHANNEL = {
  mse: (x, r) => (x - r) ** 2,
  rmse: (x, r) => (x - r) ** 2,
  relmse: (x, r) => (x - r) ** 2 / (r * r + 0.01),
  smape: (x, r) => Math.abs(x - r) / (Math.abs(x) + Math.abs(r) + 0.01),
  mape: (x, r) => Math.abs(x - r) / (Math.abs(r) + 0.01),
};

// The error of each pixel: computed where it is of the pixel alone, else as embedded, in 255 steps.
function errors(group, method, metric) {
  return once(`${data.groups.indexOf(group)} ${method} ${metric.name}`, async () => {
    const of = BY_CHANNEL[metric.name];
    const values = new Float32Array(width * height);
    if (!of) {
      const all = await bytes(group.maps[method][metric.name]);
      return values.map((_, i) => all[i] / 255 * metric.full);
    }
    const exposure = data.cells[group.cell].exposure;
    const [image, reference] = await Promise.all([radiance(group.images[method]), radiance(group.reference)]);
    for (let i = 0; i < values.length; i++) {
      let sum = 0;
      for (let c = 3 * i; c < 3 * i + 3; c++) sum += of(image[c] * exposure, reference[c] * exposure);
      values[i] = metric.name === "rmse" ? Math.sqrt(sum / 3) : sum / 3;
    }
    return values;
  });
}

function sheet(paint) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  const context = canvas.getContext("2d");
  const pixels = context.createImageData(width, height);
  paint(pixels.data);
  context.putImageData(pixels, 0, 0);
  return canvas;
}

// sRGB-encoded bytes of [0, 1].
const STEPS = 16384;
const SRGB = Uint8ClampedArray.from({ length: STEPS + 1 }, (_, i) => {
  const v = i / STEPS;
  return 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
});

// Exposed and tone mapped as for the metrics: c / (1 + luminance).
function display(values, exposure) {
  return sheet((out) => {
    for (let i = 0; i < width * height; i++) {
      let luminance = 0;
      for (let c = 0; c < 3; c++) luminance += LUMINANCE[c] * values[3 * i + c] * exposure;
      const scale = exposure / (1 + Math.max(luminance, 0)) * STEPS;
      for (let c = 0; c < 3; c++) {
        out[4 * i + c] = SRGB[Math.round(Math.min(Math.max(values[3 * i + c] * scale, 0), STEPS))];
      }
      out[4 * i + 3] = 255;
    }
  });
}

function magma(t) {
  const at = 6 * Math.round(255 * Math.min(Math.max(t, 0), 1));
  return [0, 2, 4].map((c) => parseInt(data.magma.slice(at + c, at + c + 2), 16));
}
const MAGMA = Array.from({ length: 256 }, (_, i) => magma(i / 255));

function errorSheet(values, full) {
  return sheet((out) => {
    for (let i = 0; i < values.length; i++) {
      const color = MAGMA[Math.round(255 * Math.min(values[i] / full, 1))];
      out.set(color, 4 * i);
      out[4 * i + 3] = 255;
    }
  });
}
