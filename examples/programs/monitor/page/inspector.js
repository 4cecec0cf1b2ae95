// The fields of the message that holds at the time shown.

class Inspector {
  constructor() {
    Object.assign(this, { open: new Set(), shown: null });
    $("inspected").onchange = () => { this.shown = null; };
  }
  get isOpen() { return $("inspector").open; }
  topics() { return this.isOpen && $("inspected").value ? [$("inspected").value] : []; }
  setTopics(topics) { offer($("inspected"), topics); }

  update(t, store, origin) {
    if (!this.isOpen) return;
    const message = store.at($("inspected").value, t);
    if (message === this.shown) return;
    this.shown = message;
    $("inspected_time").textContent = message ? `measured at ${(message.m - origin).toFixed(4)} s, logged ${((message.t - message.m) * 1e3).toFixed(1)} ms later, ${sizeText(message.text.length)}` : "no message up to this time";
    $("tree").replaceChildren(...(message ? this.entries(message.value, "") : []));
  }
  entries(value, path) {
    const most = 100, all = Object.entries(value ?? {}), rows = all.slice(0, most).map(([name, inner]) => this.entry(name, inner, path + "." + name));
    if (all.length > most) rows.push(element("div", { className: "dim", textContent: `… and ${all.length - most} more` }));
    return rows;
  }
  entry(name, value, path) {
    if (value === null || typeof value !== "object") {
      const text = typeof value === "string" ? (value.length > 120 ? value.slice(0, 120) + `… (${value.length} characters)` : value) : String(value);
      return element("div", { className: "field" }, element("b", { textContent: name + " " }), text);
    }
    const n = Object.keys(value).length, box = element("details", {}, element("summary", {}, element("b", { textContent: name + " " }), Array.isArray(value) ? `list of ${n}` : `${n} fields`));
    const fill = () => { if (box.childElementCount === 1) box.append(...this.entries(value, path)); };
    box.open = this.open.has(path);
    if (box.open) fill();
    box.ontoggle = () => { if (box.open) { this.open.add(path); fill(); } else this.open.delete(path); };
    return box;
  }
}
