// The plots: what each shows, and the interval of time that they share.

class Panels {
  constructor(clock) {
    Object.assign(this, { clock, plots: [], topics: [], schemas: {}, samples: new Map(), fixed: null, width: 20, count: 0 });
    $("add_plot").onclick = () => this.add(this.plotted()[0] ?? "", "");
  }
  // Topics that are plotted now, and those that could be.
  shown() { return this.plots.map((p) => p.topic).filter((t) => t); }
  plotted() { return this.topics.filter(({ topic }) => this.choices(topic).length).map(({ topic }) => topic); }
  choices(topic) {
    const schema = this.schemas[this.topics.find((t) => t.topic === topic)?.schema];
    return choicesOf(schema, this.samples.get(topic)?.value);
  }

  setTopics(topics, schemas, samples, messagesOf) {
    Object.assign(this, { topics, schemas, samples, messagesOf });
    const offered = this.plotted();
    for (const plot of [...this.plots]) if (!offered.includes(plot.topic)) this.remove(plot);
    for (const plot of this.plots) this.offerTopics(plot);
    $("plots").hidden = !offered.length;
    if (!this.plots.length && offered.length) this.addDefaults(offered);
  }
  // Force and rate of the first inertial unit, else the first field.
  addDefaults(offered) {
    const inertial = offered.find((topic) => this.choices(topic).some((c) => c.field === "linear_acceleration"));
    if (!inertial) return this.add(offered.find((t) => !/logger|tf/.test(t)) ?? offered[0], "");
    this.add(inertial, "linear_acceleration");
    this.add(inertial, "angular_velocity");
  }
  add(topic, field) {
    const number = ++this.count, label = (what) => `${what} of plot ${number}`;
    const canvas = element("canvas", { id: "plot" + number, tabIndex: 0 }), readout = element("output", { className: "readout" });
    canvas.setAttribute("role", "img");
    const plot = new Plot(canvas, readout, {
      pan: (share) => this.pan(share), zoom: (factor, at) => this.zoom(factor, at), reset: () => this.reset(), seek: (t) => this.clock.seek(t),
    });
    plot.topicSelect = element("select", { onchange: () => this.setTopic(plot, plot.topicSelect.value, "") });
    plot.fieldSelect = element("select", { onchange: () => this.setField(plot, plot.fieldSelect.value) });
    plot.topicSelect.setAttribute("aria-label", label("topic"));
    plot.fieldSelect.setAttribute("aria-label", label("field"));
    plot.panel = element("div", { className: "plot" },
      element("div", { className: "bar" }, plot.topicSelect, plot.fieldSelect,
        button("−", label("zoom out"), () => this.zoom(1.5)), button("+", label("zoom in"), () => this.zoom(1 / 1.5)),
        button("All", label("whole time"), () => this.reset()), button("×", label("remove"), () => this.remove(plot))),
      canvas, readout);
    $("plot_list").append(plot.panel);
    canvasSizes.observe(canvas);
    this.plots.push(plot);
    this.offerTopics(plot);
    this.setTopic(plot, topic, field);
  }
  remove(plot) {
    plot.panel.remove();
    this.plots.splice(this.plots.indexOf(plot), 1);
  }
  offerTopics(plot) {
    offer(plot.topicSelect, this.plotted());
    if (plot.topic) this.offerFields(plot);
  }
  offerFields(plot) {
    const choices = this.choices(plot.topic), schema = this.schemas[this.topics.find((t) => t.topic === plot.topic)?.schema];
    const texts = choices.map((c) => {
      const unit = unitOf(c.fields[0], schema);
      return c.field + (c.fields.length > 1 ? " …" : "") + (unit ? ` [${unit}]` : "");
    });
    offer(plot.fieldSelect, choices.map((c) => c.field), texts);
    return { choices, schema };
  }
  setTopic(plot, topic, field) {
    if (!topic) return;
    plot.topicSelect.value = plot.topic = topic;
    const { choices } = this.offerFields(plot);
    this.setField(plot, choices.some((c) => c.field === field) ? field : choices[0]?.field);
  }
  setField(plot, field) {
    const { choices, schema } = this.offerFields(plot), choice = choices.find((c) => c.field === field);
    if (!choice) return;
    plot.fieldSelect.value = field;
    plot.choose(plot.topic, choice, unitOf(choice.fields[0], schema), this.messagesOf(plot.topic));
  }
  take(message) { for (const plot of this.plots) if (plot.topic === message.topic && plot.choice) plot.take(message); }

  // The interval shown: the last seconds of a running logger, a part that was chosen, or all.
  interval() {
    const { clock } = this;
    if (clock.following) {
      const a = Math.max(this.step * Math.floor((clock.t - this.width) / this.step), clock.start);
      this.last = [a, a + this.width];
      return this.last;
    }
    if (!this.fixed) return clock.live && this.last ? this.last : [clock.start, Math.max(clock.end, clock.start + 1e-3)];
    const [a, b] = this.fixed;
    // While it plays the interval moves on by its length.
    if (clock.playing && (clock.t < a || clock.t > b)) this.fixed = [clock.t, clock.t + b - a];
    return this.fixed;
  }
  pan(share) {
    const [a, b] = this.interval(), by = share * (b - a);
    if (this.clock.following) this.clock.pause();
    this.fixed = [a + by, b + by];
  }
  zoom(factor, at) {
    const [a, b] = this.interval(), width = limited((b - a) * factor, 1e-3, 1e6);
    if (this.clock.following) { this.width = limited(width, 0.5, 60); return; }
    at ??= this.clock.t >= a && this.clock.t <= b ? this.clock.t : (a + b) / 2;
    const from = at - (at - a) * width / (b - a);
    this.fixed = [from, from + width];
  }
  reset() {
    this.fixed = null;
    this.last = null;
    this.width = 20;
  }

  // Curves that grow are redrawn by whole pixels.
  get step() { return this.width / 500; }

  draw(origin, recorded, store) {
    const [a, b] = this.interval(), { clock } = this, tick = Math.floor((clock.following ? clock.t : clock.end) / this.step);
    if (clock.live && tick !== this.tick) for (const plot of this.plots) plot.changed = true;
    this.tick = tick;
    for (const plot of this.plots) {
      const local = clock.following || !recorded || clock.live && plot.live.t.length > 0 && a >= plot.live.t[0];
      if (!local && plot.choice?.kind === "numbers") this.read(plot, a, b, origin);
      plot.draw(a, b, clock.t, origin, local, store.at(plot.topic, clock.t));
    }
  }
  // Curves of the recording for the interval; again once it stays.
  read(plot, a, b, origin) {
    const key = [plot.topic, ...plot.choice.fields, a, b].join("\n");
    if (plot.read === key) return;
    plot.read = key;
    clearTimeout(plot.timer);
    plot.timer = setTimeout(async () => {
      const margin = 0.25 * (b - a), choice = plot.choice;
      try {
        const series = await ask("/api/series", { topic: plot.topic, field: choice.fields, from: Math.max(0, a - origin - margin), until: Math.max(0, b - origin + margin), n: 4000 });
        if (plot.choice !== choice) return;
        plot.past = { t: series.t.map((t) => t + origin), columns: series.columns, gap: Infinity };
        plot.changed = true;
      } catch (error) {
        plot.readout.textContent = error.message;
        setTimeout(() => { plot.read = ""; }, 2000);
      }
    }, plot.past ? 120 : 0);
  }
}
