// Elements, colours, numbers and canvases.

const $ = (id) => document.getElementById(id);

function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

function button(text, label, act) {
  const made = element("button", { type: "button", textContent: text, onclick: act });
  made.setAttribute("aria-label", label);
  made.title = label;
  return made;
}

function cell(row, text, isNumber = false) {
  const made = row.insertCell();
  made.textContent = text;
  if (isNumber) made.className = "n";
  return made;
}

// Keeps the selection where it is still offered.
function offer(select, values, texts = values) {
  const before = select.value;
  select.replaceChildren(...values.map((value, i) => new Option(texts[i], value)));
  if (values.includes(before)) select.value = before;
}

const pause = (ms) => new Promise((done) => setTimeout(done, ms));
const limited = (x, low, high) => Math.min(high, Math.max(low, x));

function sizeText(bytes) {
  if (bytes < 1e6) return (bytes / 1e3).toFixed(1) + " kB";
  return bytes < 1e9 ? (bytes / 1e6).toFixed(1) + " MB" : (bytes / 1e9).toFixed(1) + " GB";
}
function durationText(s) {
  if (s < 60) return s.toFixed(1) + " s";
  const hours = Math.floor(s / 3600).toString().padStart(2, "0");
  return hours + new Date((s % 3600) * 1000).toISOString().slice(13, 19);
}
function numberText(value) {
  if (value === null || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value) || Number.isInteger(value)) return String(value);
  const size = Math.abs(value);
  return size >= 1e6 || size < 1e-4 ? value.toExponential(3) : String(Number(value.toPrecision(5)));
}

const darkScheme = matchMedia("(prefers-color-scheme: dark)");
const theme = {};
function readTheme() {
  const style = getComputedStyle(document.body);
  theme.ink = style.getPropertyValue("--ink").trim();
  theme.dim = style.getPropertyValue("--dim").trim();
  theme.card = style.getPropertyValue("--card").trim();
  theme.series = darkScheme.matches
    ? ["#ff7b86", "#6cc070", "#64b0f5", "#f2c14e", "#c792ea", "#4dd0c1", "#ffab70", "#b0bec5"]
    : ["#c02942", "#2e7d32", "#1565c0", "#946200", "#7b1fa2", "#00796b", "#bf5100", "#546e7a"];
}

// From blue over green to yellow, for values from 0 to 1.
function heat(share) {
  const hue = 250 - 200 * limited(share, 0, 1);
  return `hsl(${hue.toFixed(0)} 75% ${darkScheme.matches ? 62 : 42}%)`;
}

// The size is read where it changes, not in every frame.
const canvasSizes = new ResizeObserver((entries) => {
  for (const { target, contentRect } of entries) {
    const ratio = window.devicePixelRatio || 1;
    target.size = { w: contentRect.width, h: contentRect.height, ratio };
    target.width = Math.max(1, Math.round(contentRect.width * ratio));
    target.height = Math.max(1, Math.round(contentRect.height * ratio));
    target.changed = true;
  }
});

// A cleared canvas in CSS pixels; null while it is not shown.
function cleared(canvas) {
  if (!canvas.size || canvas.size.w < 20) return null;
  const c = canvas.getContext("2d"), { w, h, ratio } = canvas.size;
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  c.globalAlpha = 1;
  c.clearRect(0, 0, w, h);
  c.font = "12px system-ui, sans-serif";
  c.textAlign = "left";
  return { c, w, h };
}

// A round step that divides `span` into about `n`.
function roundStep(span, n) {
  const raw = span / n, power = 10 ** Math.floor(Math.log10(raw));
  return power * [1, 2, 5, 10].find((k) => k * power >= raw * 0.999);
}
const decimalsOf = (step) => limited(-Math.floor(Math.log10(step)), 0, 9);
