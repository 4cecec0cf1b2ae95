// Curves over time, or a list of numbers at one time.

// Drags, turns of the wheel and pinches on a canvas; the wheel scrolls the page until the canvas is clicked.
function dragged(canvas, { drag, hover, zoom, click = () => {} }) {
  const down = new Map();
  let moved = 0;
  const place = (e) => ({ x: e.offsetX, y: e.offsetY });
  const distance = () => { const [a, b] = [...down.values()]; return Math.hypot(a.x - b.x, a.y - b.y); };
  canvas.onpointerdown = (e) => { down.set(e.pointerId, place(e)); moved = 0; canvas.setPointerCapture(e.pointerId); canvas.focus({ preventScroll: true }); };
  canvas.onpointermove = (e) => {
    const now = place(e), before = down.get(e.pointerId);
    hover(now);
    if (!before) return;
    const apart = down.size === 2 ? distance() : 0;
    down.set(e.pointerId, now);
    if (down.size === 2) return zoom(distance() / Math.max(1, apart), now);
    moved += Math.abs(now.x - before.x) + Math.abs(now.y - before.y);
    if (moved > 3) drag(now.x - before.x, now.y - before.y, e);
  };
  canvas.onpointerup = canvas.onpointercancel = (e) => {
    if (down.delete(e.pointerId) && moved <= 3 && e.type === "pointerup") click(place(e));
  };
  canvas.onpointerleave = () => hover(null);
  canvas.addEventListener("wheel", (e) => {
    if (document.activeElement !== canvas && !e.ctrlKey) return;
    e.preventDefault();
    zoom(Math.exp(-e.deltaY / 400), place(e), e);
  }, { passive: false });
}
const keys = (actions) => (event) => {
  const act = actions[event.key];
  if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  act(event);
};

// The first index of a sorted list whose value is at least `x`.
function lowerBound(list, x, n = list.length) {
  let low = 0;
  while (low < n) {
    const middle = (low + n) >> 1;
    if (list[middle] < x) low = middle + 1; else n = middle;
  }
  return low;
}

// Columns over time that grow at their end.
class Curves {
  constructor(n) { this.t = []; this.columns = Array.from({ length: n }, () => []); }
  add(t, values) {
    if (this.t.length && t <= this.t.at(-1)) return;
    this.t.push(t);
    values.forEach((v, k) => this.columns[k].push(v));
    if (this.t.length > 60000) for (const list of [this.t, ...this.columns]) list.splice(0, 20000);
  }
  // Longer intervals than this are gaps: five times what 95 % of the last ones do not exceed.
  get gap() {
    if (this.t.length > 2 && Math.abs(this.t.length - (this.judged ?? -Infinity)) >= Math.min(50, this.t.length / 4)) {
      this.judged = this.t.length;
      const last = this.t.slice(-500), intervals = last.slice(1).map((t, i) => t - last[i]).sort((a, b) => a - b);
      this.usual = intervals[Math.ceil(0.95 * intervals.length) - 1];
    }
    return 5 * (this.usual ?? Infinity);
  }
}

class Plot {
  constructor(canvas, readout, act) {
    Object.assign(this, { canvas, readout, choice: null, topic: "", unit: "", changed: true, live: new Curves(0), past: null, heights: null, pointer: null, list: null });
    dragged(canvas, {
      drag: (dx) => act.pan(-dx / this.wide),
      hover: (place) => { this.pointer = place && this.timeAt(place.x); },
      click: (place) => { if (this.choice?.kind === "numbers") act.seek(this.timeAt(place.x)); },
      zoom: (factor, place, event) => (event?.shiftKey ? this.stretch(factor) : act.zoom(1 / factor, this.timeAt(place.x))),
    });
    canvas.ondblclick = () => { this.heights = null; act.reset(); };
    const step = (sign) => (e) => {
      if (e.shiftKey) return act.pan(0.1 * sign);
      this.pointer = limited((this.pointer ?? (this.a + this.b) / 2) + sign * (this.b - this.a) / 100, this.a, this.b);
    };
    canvas.onkeydown = keys({
      ArrowLeft: step(-1), ArrowRight: step(1), "+": () => act.zoom(0.8, this.pointer), "-": () => act.zoom(1.25, this.pointer),
      ArrowUp: () => this.stretch(1.25), ArrowDown: () => this.stretch(0.8), Home: () => { this.heights = null; act.reset(); },
      Enter: () => { if (this.pointer !== null) act.seek(this.pointer); }, Escape: () => { this.pointer = null; },
    });
  }
  choose(topic, choice, unit, messages) {
    Object.assign(this, { topic, choice, unit, live: new Curves(choice.fields.length), past: null, heights: null, changed: true });
    for (const message of messages) this.take(message);
    this.title = choice.field + (unit ? ` [${unit}]` : "");
    this.canvas.setAttribute("aria-label", `Plot of ${topic}: ${this.title}. Arrow keys read values, plus and minus zoom, Shift and arrows move, Enter sets the time.`);
  }
  take(message) {
    if (this.choice.kind !== "numbers") return;
    this.live.add(message.m, this.choice.fields.map((field) => numberAt(message.value, field)));
  }
  stretch(factor) {
    const [low, high] = this.heights ?? this.range, middle = (low + high) / 2, half = (high - low) / 2 / factor;
    this.heights = [middle - half, middle + half];
    this.changed = true;
  }
  get left() { return 56; }
  get wide() { return Math.max(1, (this.canvas.size?.w ?? 100) - this.left - 8); }
  timeAt(x) { return this.a + (x - this.left) / this.wide * (this.b - this.a); }

  // `now`: the time shown; `message`: of the topic at that time, for lists.
  draw(a, b, now, origin, local, message) {
    if (!this.choice) return;
    if (this.choice.kind === "list") return this.drawList(message);
    if (this.pointer !== null && !(this.pointer >= a && this.pointer <= b)) this.pointer = limited(this.pointer, a, b);
    const same = a === this.a && b === this.b && !this.changed && !this.canvas.changed;
    if (same && now === this.now && this.pointer === this.pointed) return;
    Object.assign(this, { a, b, now, origin, pointed: this.pointer });
    const curves = local ? this.live : this.past ?? this.live;
    if (!same) this.drawCurves(curves);
    this.changed = this.canvas.changed = false;
    const area = cleared(this.canvas);
    if (!area || !this.box) return;
    area.c.drawImage(this.picture, 0, 0, area.w, area.h);
    this.cursor(area, this.box, curves);
  }
  // To a picture of its own, on which the cursor moves.
  drawCurves(curves) {
    const { a, b, canvas, picture = this.picture = element("canvas") } = this;
    if (picture.size !== canvas.size) Object.assign(picture, { size: canvas.size, width: canvas.width, height: canvas.height });
    const area = cleared(picture);
    if (!area) return;
    const from = Math.max(0, lowerBound(curves.t, a) - 1), until = Math.min(curves.t.length, lowerBound(curves.t, b) + 1);
    this.range = this.extent(curves.columns, from, until);
    const [low, high] = this.heights ?? this.range, box = this.box = this.frame(area, low, high);
    this.timeAxis(area, box);
    area.c.save();
    area.c.beginPath(); area.c.rect(box.left, box.top, box.right - box.left, box.bottom - box.top); area.c.clip();
    curves.columns.forEach((column, k) => this.curve(area.c, box, curves, column, from, until, theme.series[k % 8]));
    area.c.restore();
  }
  extent(columns, from, until) {
    let low = Infinity, high = -Infinity;
    for (const column of columns)
      for (let i = from; i < until; ++i) {
        const v = column[i];
        if (v < low) low = v;
        if (v > high) high = v;
      }
    if (low > high) return [-1, 1];
    const pad = 0.05 * (high - low) || Math.abs(high) * 0.1 || 1;
    return [low - pad, high + pad];
  }
  // Title, legend, heights and their lines.
  frame({ c, w, h }, low, high) {
    const box = { left: this.left, right: w - 8, top: 24, bottom: h - 20 };
    box.y = (v) => box.bottom - (v - low) / (high - low) * (box.bottom - box.top);
    c.fillStyle = c.strokeStyle = theme.dim;
    c.fillText(this.title, box.left, 14, w - box.left - 70);
    const step = roundStep(high - low, 4);
    c.globalAlpha = 0.25; c.lineWidth = 1; c.beginPath();
    for (let v = Math.ceil(low / step) * step; v <= high; v += step) { c.moveTo(box.left, box.y(v)); c.lineTo(box.right, box.y(v)); }
    c.stroke(); c.globalAlpha = 1; c.textAlign = "right";
    for (let v = Math.ceil(low / step) * step; v <= high; v += step) c.fillText(Math.abs(v) > 1e6 ? v.toExponential(1) : v.toFixed(decimalsOf(step)), box.left - 6, box.y(v) + 4);
    let x = w - 8;
    for (let k = this.choice.fields.length - 1; k >= 0 && this.choice.fields.length > 1; --k) {
      c.fillStyle = theme.series[k % 8];
      const name = "— " + this.choice.fields[k].split(".").at(-1);
      c.fillText(name, x, 14);
      x -= c.measureText(name).width + 10;
    }
    c.textAlign = "left";
    return box;
  }
  timeAxis({ c, h }, box) {
    const { a, b, origin } = this, step = roundStep(b - a, (box.right - box.left) / 90), digits = decimalsOf(step);
    box.x = (t) => box.left + (t - a) / (b - a) * (box.right - box.left);
    c.fillStyle = c.strokeStyle = theme.dim; c.globalAlpha = 0.25; c.beginPath();
    const first = Math.ceil((a - origin) / step) * step;
    for (let t = first; t <= b - origin; t += step) { c.moveTo(box.x(t + origin), box.top); c.lineTo(box.x(t + origin), box.bottom); }
    c.stroke(); c.globalAlpha = 1; c.textAlign = "center";
    for (let t = first; t <= b - origin; t += step) c.fillText(t.toFixed(digits) + " s", limited(box.x(t + origin), box.left + 12, box.right - 14), h - 5);
    c.textAlign = "left";
  }
  // Of many samples in one pixel a bar from the smallest to the largest; interrupted at gaps.
  curve(c, box, curves, column, from, until, colour) {
    const { t, gap } = curves, dense = until - from > 3 * (box.right - box.left);
    c.strokeStyle = c.fillStyle = colour; c.lineWidth = 1.25; c.beginPath();
    let down = false, pixel = NaN, low = 0, high = 0, last = 0, before = -Infinity;
    const bar = () => { const top = box.y(high); c.fillRect(pixel, top - 0.5, 1, box.y(low) - top + 1); };
    for (let i = from; i < until; ++i) {
      const v = column[i];
      if (v === null || Number.isNaN(v)) { down = false; continue; }
      if (t[i] - before > gap) down = false;
      before = t[i];
      const x = box.x(t[i]);
      if (!dense) {
        if (!down) { c.moveTo(x, box.y(v)); c.lineTo(x + 0.5, box.y(v)); }
        c.lineTo(x, box.y(v));
      } else if (Math.round(x) === pixel && down) {
        low = Math.min(low, v); high = Math.max(high, v);
      } else {
        if (!Number.isNaN(pixel)) bar();
        pixel = Math.round(x);
        low = down ? Math.min(v, last) : v; high = down ? Math.max(v, last) : v;
      }
      last = v;
      down = true;
    }
    if (!Number.isNaN(pixel)) bar();
    c.stroke();
  }
  // The time shown, and the values at the pointer.
  cursor({ c }, box, curves) {
    c.lineWidth = 1; c.strokeStyle = theme.ink; c.globalAlpha = 0.6;
    if (this.now >= this.a && this.now <= this.b) { c.beginPath(); c.moveTo(box.x(this.now), box.top); c.lineTo(box.x(this.now), box.bottom); c.stroke(); }
    c.globalAlpha = 1;
    let text = "";
    if (this.pointer !== null && curves.t.length) {
      let i = limited(lowerBound(curves.t, this.pointer), 0, curves.t.length - 1);
      if (i > 0 && this.pointer - curves.t[i - 1] < curves.t[i] - this.pointer) --i;
      const values = curves.columns.map((column) => column[i] ?? NaN);
      text = `${(curves.t[i] - this.origin).toFixed(3)} s: ` + this.choice.fields.map((f, k) => `${f.split(".").at(-1)} ${numberText(values[k])}`).join(", ") + (this.unit ? " " + this.unit : "");
      c.setLineDash([3, 3]); c.beginPath(); c.moveTo(box.x(curves.t[i]), box.top); c.lineTo(box.x(curves.t[i]), box.bottom); c.stroke(); c.setLineDash([]);
      values.forEach((v, k) => { if (Number.isNaN(v)) return; c.fillStyle = theme.series[k % 8]; c.beginPath(); c.arc(box.x(curves.t[i]), box.y(v), 3, 0, 7); c.fill(); });
    }
    if (this.readout.textContent !== text) this.readout.textContent = text;
  }
  drawList(message) {
    if (message === this.list && !this.changed && !this.canvas.changed) return;
    const area = cleared(this.canvas);
    this.list = message;
    this.changed = this.canvas.changed = false;
    if (!area) return;
    const values = (message && valueAt(message.value, this.choice.field)) || [];
    this.range = this.extent([values.map((v) => v ?? NaN)], 0, values.length);
    const box = this.frame(area, ...(this.heights ?? this.range)), c = area.c;
    c.fillText(`${values.length} values`, box.left, area.h - 5);
    c.strokeStyle = theme.series[2]; c.lineWidth = 1.25; c.beginPath();
    let down = false;
    values.forEach((v, i) => {
      if (v === null || !Number.isFinite(v)) { down = false; return; }
      const x = box.left + (i + 0.5) / values.length * (box.right - box.left);
      if (down) c.lineTo(x, box.y(v)); else c.moveTo(x, box.y(v));
      down = true;
    });
    c.stroke();
  }
}
