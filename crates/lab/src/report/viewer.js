// The image viewer: one state, panes that draw it, controls and keys that change it.
const viewer = document.getElementById("viewer-body");
const $ = (name) => document.getElementById(`v-${name}`);
const REFERENCE = "reference";

const state = {
  group: 0, mode: "one", a: "0", b: REFERENCE, stops: 0,
  error: false, metric: 0, scale: 0, opacity: 1,
  zoom: 1, x: width / 2, y: height / 2, split: 0.5,
};
let pointer = null; // the pixel under the cursor

const group = () => data.groups[state.group];
const metric = () => data.metrics[state.metric];
const full = () => metric().full * 2 ** state.scale;
const methods = () => data.methods.map((_, i) => String(i)).filter((m) => m in group().images);
const choices = () => [...methods(), REFERENCE];
const title = (m) => (m === REFERENCE ? "Reference" : `${Number(m) + 1} ${data.methods[m]}`);
const imageOf = (m) => (m === REFERENCE ? group().reference : group().images[m]);

// Which methods each pane shows: left of the divider, and right of it if there is one.
const panes = [$("pane-0"), $("pane-1"), $("pane-2")];
const LAYOUT = {
  one: () => [[state.a]],
  split: () => [[state.a, state.b]],
  side: () => [[state.a], [state.b], [REFERENCE]],
};

let drawing = 0;
async function draw() {
  const mine = ++drawing;
  const shown = LAYOUT[state.mode]();
  const layers = await Promise.all(shown.map((pane) => Promise.all(pane.map(layersOf))));
  if (mine !== drawing) return; // a later one draws
  panes.forEach((pane, i) => {
    pane.parentElement.hidden = i >= shown.length;
    if (i < shown.length) drawPane(pane, shown[i], layers[i]);
  });
  await tell();
  if (mine === drawing) viewer.dataset.drawn = JSON.stringify(state);
}

async function layersOf(method) {
  const exposure = data.cells[group().cell].exposure * 2 ** state.stops;
  const key = `${imageOf(method)} ${exposure}`;
  const layers = [[await fresh("display", key, async () => display(await radiance(imageOf(method)), exposure)), 1]];
  if (state.error && metric() && method !== REFERENCE) {
    const key = `${state.group} ${method} ${state.metric} ${state.scale}`;
    const make = async () => errorSheet(await errors(group(), method, metric()), full());
    layers.push([await fresh("error", key, make), state.opacity]);
  }
  return layers;
}

// The sheets that were painted last; more than these would fill the memory.
const painted = { display: new Map(), error: new Map() };
async function fresh(kind, key, make) {
  const sheets = painted[kind];
  const found = sheets.get(key) ?? (await make());
  sheets.delete(key);
  sheets.set(key, found);
  if (sheets.size > 2 * data.methods.length + 2) sheets.delete(sheets.keys().next().value);
  return found;
}

// Screen pixels per image pixel, and where the image begins.
function placement(canvas) {
  const scale = Math.min(canvas.width / width, canvas.height / height) * state.zoom;
  return { scale, left: canvas.width / 2 - state.x * scale, top: canvas.height / 2 - state.y * scale };
}

function drawPane(canvas, shown, layers) {
  const box = canvas.parentElement.getBoundingClientRect(), ratio = devicePixelRatio || 1;
  canvas.width = Math.max(1, Math.round(box.width * ratio));
  canvas.height = Math.max(1, Math.round(box.height * ratio));
  const context = canvas.getContext("2d");
  const { scale, left, top } = placement(canvas);
  context.imageSmoothingEnabled = scale < 1;
  const divider = shown.length > 1 ? state.split * canvas.width : canvas.width;
  shown.forEach((_, side) => {
    context.save();
    context.beginPath();
    context.rect(side ? divider : 0, 0, side ? canvas.width - divider : divider, canvas.height);
    context.clip();
    for (const [sheet, opacity] of layers[side]) {
      context.globalAlpha = opacity;
      context.drawImage(sheet, left, top, width * scale, height * scale);
    }
    context.restore();
  });
  if (shown.length > 1) {
    context.fillStyle = "#fff";
    context.fillRect(divider - ratio, 0, 2 * ratio, canvas.height);
    context.fillStyle = "#000";
    context.fillRect(divider + ratio, 0, ratio, canvas.height);
  }
  canvas.parentElement.querySelector(".left").textContent = title(shown[0]);
  const right = canvas.parentElement.querySelector(".right");
  right.hidden = shown.length < 2;
  right.textContent = shown.length < 2 ? "" : title(shown[1]);
}

const digits = (v) => (v === 0 ? "0" : Math.abs(v) >= 1e-3 && Math.abs(v) < 1e5 ? v.toPrecision(4) : v.toExponential(2));

// The values under the cursor, or in the middle while there is none.
let telling = 0;
async function tell() {
  const mine = ++telling;
  const inside = (v, size) => Math.min(Math.max(Math.floor(v), 0), size - 1);
  const [x, y] = pointer ?? [inside(state.x, width), inside(state.y, height)];
  const rows = [["A", state.a], ["B", state.b], ["", REFERENCE]].filter(([letter, m]) => letter === "" || m !== REFERENCE);
  const cells = await Promise.all(rows.map(async ([letter, m]) => {
    const values = (await radiance(imageOf(m))).subarray(3 * (y * width + x), 3 * (y * width + x) + 3);
    const luminance = values.reduce((sum, v, c) => sum + LUMINANCE[c] * v, 0);
    const error = m === REFERENCE || !metric() ? "" : digits((await errors(group(), m, metric()))[y * width + x]);
    return [`${letter} ${title(m)}`.trim(), ...[...values, luminance].map(digits), error];
  }));
  if (mine !== telling) return;
  $("where").textContent = `Pixel ${x}, ${y}${pointer ? "" : " (middle of the view)"}`;
  $("error-name").textContent = metric()?.name ?? "";
  $("values").replaceChildren(...cells.map(([name, ...numbers]) => {
    const row = document.createElement("tr");
    const head = document.createElement("th");
    head.scope = "row";
    head.textContent = name;
    row.append(head, ...numbers.map((n) => Object.assign(document.createElement("td"), { textContent: n })));
    return row;
  }));
}

// Shows the state in the controls, and draws it.
function update(change) {
  Object.assign(state, change);
  state.zoom = Math.min(Math.max(state.zoom, 0.01), 64);
  state.x = Math.min(Math.max(state.x, 0), width);
  state.y = Math.min(Math.max(state.y, 0), height);
  state.split = Math.min(Math.max(state.split, 0), 1);
  state.stops = Math.min(Math.max(state.stops, -10), 10);
  for (const side of ["a", "b"]) {
    if (!choices().includes(state[side])) state[side] = choices()[0];
    const options = choices().map((m) => new Option(title(m), m, false, m === state[side]));
    $(side).replaceChildren(...options);
  }
  const { cell } = group();
  $("cell").value = String(cell);
  const frames = data.groups.map((g, i) => [g, i]).filter(([g]) => g.cell === cell);
  $("frame").replaceChildren(...frames.map(([g, i]) => new Option(String(g.frame), String(i), false, i === state.group)));
  for (const radio of viewer.querySelectorAll("[name=v-mode]")) radio.checked = radio.value === state.mode;
  for (const name of ["stops", "scale", "opacity", "split"]) $(name).value = String(state[name]);
  $("split").disabled = state.mode !== "split";
  $("error").checked = state.error;
  $("metric").value = String(state.metric);
  $("stops-value").textContent = `${state.stops >= 0 ? "+" : "−"}${Math.abs(state.stops)} EV`;
  $("scale-value").textContent = metric() ? `0 to ${Number(full().toPrecision(3))}` : "";
  $("zoom-value").textContent = `${Math.round(state.zoom * 100)} %`;
  viewer.dataset.state = JSON.stringify(state);
  return draw();
}

const step = (list, at, by) => list[(list.indexOf(at) + by + list.length) % list.length];
const zoomBy = (factor) => update({ zoom: state.zoom * factor });
const fit = () => update({ zoom: 1, x: width / 2, y: height / 2 });

// One screen pixel of the display for each of the image.
function actual() {
  const canvas = panes[0];
  return update({ zoom: (devicePixelRatio || 1) / Math.min(canvas.width / width, canvas.height / height) });
}

function stepFrame(by) {
  const mine = data.groups.map((_, i) => i).filter((i) => data.groups[i].cell === group().cell);
  return update({ group: step(mine, state.group, by) });
}

// As the dialog with id `v-help` says.
const KEYS = {
  ArrowLeft: () => update({ a: step(choices(), state.a, -1) }),
  ArrowRight: () => update({ a: step(choices(), state.a, 1) }),
  r: () => update({ a: REFERENCE }),
  x: () => update({ a: state.b, b: state.a }),
  v: () => update({ mode: step(Object.keys(LAYOUT), state.mode, 1) }),
  e: () => update({ error: !state.error }),
  m: () => update({ metric: (state.metric + 1) % Math.max(data.metrics.length, 1) }),
  "[": () => update({ stops: state.stops - 0.5 }),
  "]": () => update({ stops: state.stops + 0.5 }),
  "\\": () => update({ stops: 0 }),
  "+": () => zoomBy(1.5),
  "=": () => zoomBy(1.5),
  "-": () => zoomBy(1 / 1.5),
  f: fit,
  ",": () => stepFrame(-1),
  ".": () => stepFrame(1),
  "?": () => $("help").showModal(),
};

const inView = () => {
  const box = viewer.getBoundingClientRect();
  return box.top < innerHeight && box.bottom > 0;
};

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || $("help").open || !inView()) return;
  const own = event.target.matches("select, input[type=range], input[type=radio]");
  if (own && (event.key.startsWith("Arrow") || event.target.matches("select"))) return;
  const digit = /^Digit([1-9])$/.exec(event.code);
  const method = digit && String(digit[1] - 1);
  const pan = event.shiftKey && { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  if (method) {
    if (methods().includes(method)) update(event.shiftKey ? { b: method } : { a: method });
  } else if (pan) {
    const far = width / 10 / state.zoom;
    update({ x: state.x + pan[0] * far, y: state.y + pan[1] * far });
  } else if (KEYS[event.key]) {
    KEYS[event.key]();
  } else {
    return;
  }
  event.preventDefault();
});

const change = (name, event, of) => $(name).addEventListener(event, () => update(of($(name))));
change("cell", "change", (c) => ({ group: data.groups.findIndex((g) => g.cell === Number(c.value)) }));
change("frame", "change", (c) => ({ group: Number(c.value) }));
change("a", "change", (c) => ({ a: c.value }));
change("b", "change", (c) => ({ b: c.value }));
change("metric", "change", (c) => ({ metric: Number(c.value), error: true }));
change("error", "change", (c) => ({ error: c.checked }));
for (const name of ["stops", "scale", "opacity", "split"]) change(name, "input", (c) => ({ [name]: Number(c.value) }));
for (const radio of viewer.querySelectorAll("[name=v-mode]")) {
  radio.addEventListener("change", () => update({ mode: radio.value }));
}
$("in").addEventListener("click", () => zoomBy(1.5));
$("out").addEventListener("click", () => zoomBy(1 / 1.5));
$("fit").addEventListener("click", fit);
$("actual").addEventListener("click", actual);
$("swap").addEventListener("click", KEYS.x);
$("keys").addEventListener("click", KEYS["?"]);

for (const canvas of panes) {
  const at = (event) => {
    const box = canvas.getBoundingClientRect(), ratio = canvas.width / box.width;
    const { scale, left, top } = placement(canvas);
    return [((event.clientX - box.left) * ratio - left) / scale, ((event.clientY - box.top) * ratio - top) / scale];
  };
  const atDivider = (event) => {
    const box = canvas.getBoundingClientRect();
    return state.mode === "split" && Math.abs(event.clientX - box.left - state.split * box.width) < 8;
  };
  let held = null;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    held = { divider: atDivider(event), at: at(event) };
  });
  canvas.addEventListener("pointermove", (event) => {
    const box = canvas.getBoundingClientRect();
    canvas.style.cursor = atDivider(event) ? "ew-resize" : "crosshair";
    if (held?.divider) {
      update({ split: (event.clientX - box.left) / box.width });
      return;
    }
    const [x, y] = at(event);
    if (held) {
      update({ x: state.x + held.at[0] - x, y: state.y + held.at[1] - y });
      return;
    }
    const on = x >= 0 && y >= 0 && x < width && y < height;
    pointer = on ? [Math.floor(x), Math.floor(y)] : null;
    tell();
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { held = null; });
  canvas.addEventListener("pointerleave", () => { pointer = null; tell(); });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const [x, y] = at(event), before = state.zoom;
    const zoom = Math.min(Math.max(before * 1.0015 ** -event.deltaY, 0.01), 64);
    // What is under the cursor stays there.
    const stay = before / zoom;
    update({ zoom, x: x + (state.x - x) * stay, y: y + (state.y - y) * stay });
  }, { passive: false });
  canvas.addEventListener("dblclick", fit);
}

const bar = $("bar").getContext("2d");
MAGMA.forEach(([r, g, b], i) => {
  bar.fillStyle = `rgb(${r} ${g} ${b})`;
  bar.fillRect(i, 0, 1, 1);
});
new ResizeObserver(() => draw()).observe($("panes"));
update({});
