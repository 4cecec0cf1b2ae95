// Contents and export of the recording, the walked path, and the map.

class RecordingPanel {
  constructor(clock) {
    Object.assign(this, { clock, contents: null, mapping: false, cell_m: 0.05 });
    $("make").onclick = () => this.showMap();
    $("walker").onchange = () => this.showWalk().catch(console.error);
    for (const id of ["export_from", "export_until"]) $(id).onchange = () => this.showLinks();
    $("export_shown").onclick = () => {
      const [a, b] = this.interval(), { start_s: start, seconds } = this.contents;
      $("export_from").value = limited(a - start, 0, seconds).toFixed(2);
      $("export_until").value = limited(b - start, 0, seconds).toFixed(2);
      this.showLinks();
    };
  }
  show(contents, growing) {
    const c = this.contents = contents;
    $("path").textContent = c.path;
    $("size").textContent = `${sizeText(c.bytes)}, ${c.messages} messages in ${c.chunks} chunk${c.chunks === 1 ? "" : "s"}, ${durationText(c.seconds)} from ` +
      new Date(c.start_s * 1000).toISOString() + (c.indexed ? "" : growing ? " (being written)" : " (not closed)");
    $("problems").hidden = growing;  // a missing end is expected while recording
    $("problems").replaceChildren(...c.problems.map((p) => element("p", { className: "problem", textContent: p })));
    $("contents").hidden = false;
    const rows = [{ topic: "", messages: c.messages }, ...c.topics];
    if ($("topics").rows.length !== rows.length) $("topics").replaceChildren();
    rows.forEach((t, i) => {
      const row = $("topics").rows[i] ?? $("topics").insertRow();
      const texts = [t.topic || "all topics", t.schema ?? "", t.messages];
      texts.forEach((text, k) => { const td = row.cells[k] ?? cell(row, "", k === 2); if (td.textContent !== String(text)) td.textContent = text; });
      if (!row.cells[3]) this.links(row.insertCell(), t.topic);
    });
  }
  range() {
    const from = $("export_from").value, until = $("export_until").value;
    return { ...(from && { from }), ...(until && { until }) };
  }
  links(td, topic) {
    td.dataset.topic = topic;
    for (const kind of topic ? ["csv", "mcap"] : ["mcap"]) {
      const a = element("a", { textContent: kind.toUpperCase(), download: "", href: query("/export." + kind, { ...(topic && { topic }), ...this.range() }) });
      a.setAttribute("aria-label", `export ${topic || "all topics"} as ${kind.toUpperCase()}`);
      td.append(a, " ");
    }
  }
  showLinks() {
    for (const td of document.querySelectorAll("#topics [data-topic]")) {
      td.replaceChildren();
      this.links(td, td.dataset.topic);
    }
  }

  ofSchema(name) { return this.contents.topics.filter((t) => t.schema === name && t.messages > 0).map((t) => t.topic); }
  setTopics() {
    const units = this.ofSchema("wayfare.Imu");
    offer($("walker"), units);
    $("make").hidden = !this.ofSchema("foxglove.LaserScan").length;
    $("way").hidden = !units.length && $("make").hidden;
    $("walker").hidden = units.length < 2;
    if (units.length) this.showWalk().catch(console.error);
  }
  async showWalk() {
    const topic = $("walker").value;
    const [, x, y] = (await ask("/api/walk", { topic })).columns;
    this.walk = { x, y };
    $("walk").hidden = !x.length;
    $("walked").textContent = x.length ? `${x.length} steps by ${topic}` : `no steps by ${topic}`;
    $("walk").changed = true;
  }
  draw() {
    const canvas = $("walk");
    if (!this.walk?.x.length || !canvas.changed) return;
    const area = cleared(canvas), { x, y } = this.walk;
    canvas.changed = false;
    if (!area) return;
    const { c, w, h } = area, least = (list) => Math.min(0, ...list), most = (list) => Math.max(0, ...list);
    const scale = 0.85 * Math.min(w / Math.max(2, most(y) - least(y)), h / Math.max(2, most(x) - least(x)));
    const at = (px, py) => [w / 2 - (py - (most(y) + least(y)) / 2) * scale, h / 2 - (px - (most(x) + least(x)) / 2) * scale];
    const step = roundStep(Math.min(w, h) / scale, 4);
    c.fillStyle = c.strokeStyle = theme.dim;
    c.fillText(step.toFixed(decimalsOf(step)) + " m", 10, h - 12);
    c.beginPath(); c.moveTo(10, h - 6); c.lineTo(10 + step * scale, h - 6); c.stroke();
    c.beginPath(); c.arc(...at(0, 0), 4, 0, 7); c.stroke();
    c.strokeStyle = theme.series[2]; c.lineWidth = 2; c.beginPath(); c.moveTo(...at(0, 0));
    x.forEach((_, i) => c.lineTo(...at(x[i], y[i])));
    c.stroke();
  }

  // Of a growing recording the map grows with it.
  async showMap() {
    $("make").disabled = true;
    if (!this.mapping) $("making").textContent = "running …";
    try {
      const answer = await fetched("/api/map.png"), map = $("map"), shown = map.src;
      const picture = URL.createObjectURL(await answer.blob());
      map.onload = () => {
        const cells = [map.naturalWidth, map.naturalHeight];
        map.style.width = Math.min(map.parentElement.clientWidth - 26, 480 * cells[0] / cells[1]) + "px";
        $("making").textContent = cells.map((n) => (n * this.cell_m).toFixed(1) + " m").join(" × ") + ", path in blue" + (this.clock.live ? ", followed" : "");
      };
      map.src = picture;
      map.hidden = false;
      URL.revokeObjectURL(shown);
      if (this.clock.live && !this.mapping) this.followMap();
    } catch (error) { $("making").textContent = error.message; }
    $("make").disabled = false;
  }
  // Each query rereads the recording; the interval limits the load on the logger.
  async followMap() {
    this.mapping = true;
    for (let took = 0; this.clock.live;) {
      await pause(Math.max(3000, 10 * took));
      const begun = Date.now();
      await this.showMap();
      took = Date.now() - begun;
    }
    this.mapping = false;
  }
}
