// Points of all scanners and radars in one frame, from above or from the side.

const topView = { yaw: 0, pitch: Math.PI / 2 }, sideView = { yaw: -0.6, pitch: 0.6 };

class Scene {
  constructor(transforms) {
    Object.assign(this, { transforms, canvas: $("scene"), layers: new Map(), changed: true, fixed: "", colour: "", hover: null });
    this.reset(topView);
    this.listen();
  }
  reset(view) {
    this.camera = { ...view, x: 0, y: 0, scale: 0 };  // scale 0: all points are in view
    this.changed = true;
  }
  get isFlat() { return this.camera.pitch > 1.57; }

  // Of a topic and its schema each.
  setTopics(list) {
    const topics = list.map((t) => t.topic);
    for (const topic of this.layers.keys()) if (!topics.includes(topic)) this.layers.delete(topic);
    for (const { topic, schema } of list)
      if (!this.layers.has(topic)) this.layers.set(topic, { topic, shown: !isPart(schema), text: "" });
    $("layers").replaceChildren(...[...this.layers.values()].map((layer, i) => {
      const box = element("input", { type: "checkbox", checked: layer.shown, onchange: () => { layer.shown = box.checked; this.changed = true; } });
      layer.number = i;
      layer.name = element("span", { textContent: layer.topic });
      layer.label = element("span", { className: "dim" });
      return element("label", {}, box, layer.name, layer.label);
    }));
    this.changed = true;
  }
  topics() { return [...this.layers.values()].filter((l) => l.shown).map((l) => l.topic); }

  // Takes the messages that hold at `t`.
  update(t, store) {
    for (const layer of this.layers.values()) {
      const message = layer.shown ? store.at(layer.topic, t) : null, points = pointsOf(message);
      const age = message ? t - message.t : 0, stale = age > Math.max(0.5, Math.min(5 * store.interval(layer.topic), 5));
      const matrix = points && this.placed(points, message.t);
      if (message !== layer.message || stale !== layer.stale || String(matrix) !== String(layer.matrix)) this.changed = true;
      Object.assign(layer, { message, points, stale, matrix, rate: 1 / store.interval(layer.topic) });
      layer.text = !layer.shown ? "" : !points ? "no points" : stale ? `no message for ${age.toFixed(1)} s` :
        `${points.n} points` + (layer.rate > 0 ? `, ${layer.rate.toFixed(1)}/s` : "");
    }
  }
  // From the sensor to the fixed frame.
  placed(points, t) {
    const between = this.transforms.between(points.frame, this.fixed || this.transforms.root(points.frame), t);
    return between && product(between, points.pose);
  }

  // Screen coordinates of a layer's points: two rows of four numbers.
  projection(matrix, { w, h }) {
    const { yaw, pitch, x, y, scale } = this.camera, k = scale || this.fitted(w, h);
    const s = Math.sin(yaw), c = Math.cos(yaw), up = Math.sin(pitch), lift = Math.cos(pitch);
    const right = [k * s, -k * c, 0], down = [-k * c * up, -k * s * up, -k * lift];
    const row = (r, centre) => {
      const out = [0, 1, 2, 3].map((i) => r[0] * matrix[i] + r[1] * matrix[4 + i] + r[2] * matrix[8 + i]);
      out[3] += centre - r[0] * x - r[1] * y;
      return out;
    };
    return [row(right, w / 2), row(down, h / 2)];
  }
  // The reach changes in steps, so that the picture does not tremble.
  fitted(w, h) {
    let far = 1;
    for (const { points, matrix, stale } of this.layers.values()) {
      if (!points || !matrix || stale) continue;
      const { x, y } = points.columns;
      for (let i = 0; i < points.n; ++i)
        far = Math.max(far, Math.hypot(matrix[0] * x[i] + matrix[1] * y[i] + matrix[3], matrix[4] * x[i] + matrix[5] * y[i] + matrix[7]) || 0);
    }
    if (!(far < this.reach && far > 0.6 * this.reach)) this.reach = far * 1.1;
    return Math.min(w, h) / 2 / this.reach;
  }

  draw() {
    if (!this.changed && !this.canvas.changed) return;
    const area = cleared(this.canvas);
    this.changed = this.canvas.changed = false;
    if (!area) return;
    this.drawGrid(area);
    for (const layer of this.layers.values()) {
      if (!layer.points) continue;
      layer.screen = this.projection(layer.matrix ?? layer.points.pose, area);
      this.drawPoints(area.c, layer);
    }
    if (this.hover) this.drawHover(area);
  }
  drawGrid(area) {
    const { c, w } = area, [u, v] = this.projection(identity, area), scale = this.camera.scale || this.fitted(area.w, area.h);
    const step = roundStep(Math.min(area.w, area.h) / scale / 2, 4), at = (x, y) => [u[0] * x + u[1] * y + u[3], v[0] * x + v[1] * y + v[3]];
    const far = Math.ceil((Math.hypot(area.w, area.h) / 2 / scale + Math.hypot(this.camera.x, this.camera.y)) / step);
    c.strokeStyle = c.fillStyle = theme.dim;
    c.lineWidth = 1;
    for (let i = 1; i <= Math.min(far, 20); ++i) {
      c.globalAlpha = 0.3;
      c.beginPath();
      for (let k = 0; k <= 72; ++k) c.lineTo(...at(i * step * Math.cos(k * Math.PI / 36), i * step * Math.sin(k * Math.PI / 36)));
      c.stroke();
      c.globalAlpha = 1;
      const [x, y] = at(i * step, 0);
      if (x > 0 && x < w - 30) c.fillText((i * step).toFixed(decimalsOf(step)) + " m", x + 3, y - 3);
    }
    // The axes of the frame: x ahead, y to the left.
    for (const [x, y, k] of [[1, 0, 0], [0, 1, 1]]) {
      c.strokeStyle = theme.series[k];
      c.lineWidth = 2;
      c.beginPath(); c.moveTo(...at(0, 0)); c.lineTo(...at(x * step / 2, y * step / 2)); c.stroke();
    }
  }
  colourOf(layer) {
    const { columns, n } = layer.points, values = columns[this.colour], series = theme.series;
    if (this.colour && values) {
      let low = Infinity, high = -Infinity;
      for (const v of values) if (Number.isFinite(v)) { low = Math.min(low, v); high = Math.max(high, v); }
      const table = Array.from({ length: 17 }, (_, k) => heat(k / 16));
      return (i) => table[Number.isFinite(values[i]) ? Math.round(16 * (values[i] - low) / (high - low || 1)) : 0];
    }
    // What a radar sees moving is red.
    const still = layerColour(layer.number), speed = columns.doppler ?? columns.velocity;
    return speed ? (i) => (Math.abs(speed[i]) < 0.1 ? still : series[0]) : () => still;
  }
  drawPoints(c, { points, screen: [u, v], stale, matrix, topic, number }) {
    const { x, y, z } = points.columns, n = points.n, colour = this.colourOf({ points, number });
    const size = n < 60 ? 5 : n < 1500 ? 3 : 2;
    c.globalAlpha = stale ? 0.25 : 1;
    let before = "";
    for (let i = 0; i < n; ++i) {
      const now = colour(i);
      if (now !== before) c.fillStyle = before = now;
      c.fillRect(u[0] * x[i] + u[1] * y[i] + u[2] * z[i] + u[3] - size / 2, v[0] * x[i] + v[1] * y[i] + v[2] * z[i] + v[3] - size / 2, size, size);
    }
    // Where the sensor is.
    c.strokeStyle = layerColour(number);
    c.lineWidth = 1.5;
    c.beginPath(); c.arc(u[3], v[3], 4, 0, 7); c.stroke();
    c.globalAlpha = 1;
    c.fillStyle = layerColour(number);
    if (!matrix) c.fillText(`${topic}: no transform to ${this.fixed}`, 8, 18 + 16 * number);
  }

  // The point nearest to a place on the canvas, within twelve pixels.
  nearest(px, py) {
    let best = 144, found = null;
    for (const layer of this.layers.values()) {
      if (!layer.points || !layer.screen) continue;
      const [u, v] = layer.screen, { x, y, z } = layer.points.columns;
      for (let i = 0; i < layer.points.n; ++i) {
        const a = u[0] * x[i] + u[1] * y[i] + u[2] * z[i] + u[3] - px, b = v[0] * x[i] + v[1] * y[i] + v[2] * z[i] + v[3] - py;
        if (a * a + b * b < best) { best = a * a + b * b; found = { layer, i, u: a + px, v: b + py }; }
      }
    }
    return found;
  }
  drawHover({ c }) {
    const found = this.nearest(this.hover.x, this.hover.y);
    const at = $("pointed");
    if (!found) return void (at.textContent = "");
    const { columns } = found.layer.points, i = found.i, r = Math.hypot(columns.x[i], columns.y[i], columns.z[i]);
    const more = Object.entries(columns).map(([name, column]) => `${name} ${numberText(column[i])}${unitOf(name) ? " " + unitOf(name) : ""}`);
    at.textContent = `${found.layer.topic}: ${more.join(", ")}; ${r.toFixed(2)} m at ${(Math.atan2(columns.y[i], columns.x[i]) * 180 / Math.PI).toFixed(1)}°`;
    c.strokeStyle = theme.ink;
    c.lineWidth = 1.5;
    c.beginPath(); c.arc(found.u, found.v, 7, 0, 7); c.stroke();
  }

  zoom(factor) { this.camera.scale = limited((this.camera.scale || this.fitted(this.canvas.size.w, this.canvas.size.h)) * factor, 0.5, 5000); this.changed = true; }
  // By pixels.
  move(dx, dy) {
    const { yaw, pitch, scale } = this.camera, k = scale || this.fitted(this.canvas.size.w, this.canvas.size.h);
    const right = -dx / k, up = dy / k / Math.max(0.2, Math.sin(pitch));
    this.camera.x += Math.sin(yaw) * right + Math.cos(yaw) * up;
    this.camera.y += -Math.cos(yaw) * right + Math.sin(yaw) * up;
    this.changed = true;
  }
  turn(dx, dy) {
    this.camera.yaw -= dx;
    this.camera.pitch = limited(this.camera.pitch + dy, 0.05, Math.PI / 2);
    this.changed = true;
  }
  listen() {
    dragged(this.canvas, {
      drag: (dx, dy, event) => (this.isFlat === event.shiftKey ? this.turn(dx / 150, dy / 150) : this.move(dx, dy)),
      hover: (place) => { this.hover = place; this.changed = true; if (!place) $("pointed").textContent = ""; },
      zoom: (factor) => this.zoom(factor),
    });
    const step = (event, dx, dy) => (event.shiftKey ? this.turn(dx / 200, dy / 200) : this.move(-dx, -dy));
    this.canvas.onkeydown = keys({
      ArrowLeft: (e) => step(e, -20, 0), ArrowRight: (e) => step(e, 20, 0), ArrowUp: (e) => step(e, 0, -20), ArrowDown: (e) => step(e, 0, 20),
      "+": () => this.zoom(1.25), "-": () => this.zoom(0.8), Home: () => this.reset(topView), "3": () => this.reset(sideView),
    });
    $("from_above").onclick = () => this.reset(topView);
    $("from_side").onclick = () => this.reset(sideView);
    $("scene_in").onclick = () => this.zoom(1.25);
    $("scene_out").onclick = () => this.zoom(0.8);
    $("fixed_frame").onchange = (e) => { this.fixed = e.target.value; this.changed = true; };
    $("colour_by").onchange = (e) => { this.colour = e.target.value; this.changed = true; };
  }
  // Frames, fields and counts of what is shown; now and then.
  describe() {
    const frames = new Set(this.transforms.names()), columns = new Set();
    for (const layer of this.layers.values()) {
      layer.label.textContent = layer.text;
      layer.name.style.color = layerColour(layer.number);
      if (!layer.points) continue;
      frames.add(layer.points.frame);
      for (const name of Object.keys(layer.points.columns)) columns.add(name);
    }
    const own = ["", ...[...frames].filter((f) => f !== "").sort()];
    if (own.join() !== [...$("fixed_frame").options].map((o) => o.value).join()) offer($("fixed_frame"), own, ["own root", ...own.slice(1)]);
    const by = ["", ...columns];
    if (by.join() !== [...$("colour_by").options].map((o) => o.value).join()) offer($("colour_by"), by, ["sensor", ...by.slice(1)]);
  }
}
const layerColour = (number) => theme.series[[2, 1, 3, 4, 5, 6, 7][number % 7]];
