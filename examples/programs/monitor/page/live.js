// The logger's status and commands.

class LoggerPanel {
  constructor() {
    Object.assign(this, { heard: 0, problem: "", checking: null, growing: false, opened: Date.now() });
    for (const each of document.querySelectorAll("[data-command]"))
      each.onclick = () => { if (!each.dataset.sure || confirm(each.dataset.sure)) this.command(each.dataset.command); };
    $("check").onclick = () => this.check();
  }
  start() {
    $("live").hidden = false;
    setInterval(() => {
      if (Date.now() - (this.heard || this.opened) <= 3500) return;
      this.showState(this.heard ? "no status since " + new Date(this.heard).toLocaleTimeString() : "no status received", "lost");
      this.show("error", this.problem);
    }, 500);
  }
  show(id, text) {
    $(id).textContent = text;
    $(id).hidden = !text;
  }
  async command(byte) {
    let wrong = "";
    try {
      const answer = await fetch(query("/api/command"), { method: "POST", headers: { "X-Wayfare": "1" }, body: byte });
      if (!answer.ok) wrong = await answer.text();
      if (answer.status === 401) wrong = "commands need the token: open the address that the monitor printed";
    } catch (error) { wrong = error.message; }
    this.show("refused", wrong);
    return !wrong;
  }

  // The logger answers a check with its status at once.
  showCheck(text, className) {
    this.show("checked", text);
    $("checked").className = className;
  }
  async check() {
    const asked = this.checking = Date.now();
    this.showCheck("checking …", "dim");
    if (!await this.command("C")) {
      this.checking = null;
      return this.showCheck("the check could not be sent", "problem");
    }
    await pause(3000);
    if (this.checking !== asked) return;
    this.checking = null;
    this.showCheck("no answer to the check within 3 s", "problem");
  }
  answerCheck(s) {
    if (this.checking === null) return;
    const ms = Date.now() - this.checking;
    const wrong = s.sensors.filter((x) => x.state !== "receiving" || (x.messages === 0 && x.skipped_bytes > 0) || x.warning);
    const faults = wrong.map((x) => `${x.name}: ${x.warning || (x.state === "receiving" ? `${x.skipped_bytes} bytes in no message` : x.state)}${x.note ? ` (${x.note})` : ""}`);
    if (s.error) faults.unshift(s.error);
    this.checking = null;
    const inOrder = `${s.sensors.length - wrong.length} of ${s.sensors.length} sensors in order`;
    this.showCheck(`${new Date().toLocaleTimeString()}: status after ${ms} ms, ${inOrder}` + (faults.length ? ": " + faults.join("; ") : ""), faults.length ? "problem" : "dim");
  }

  showState(text, className) {
    $("state").textContent = text;
    $("state").className = className;
    const busy = ["starting", "recording", "stopping"].includes(text), ended = className === "lost" || text === "terminated";
    const disabled = { B: busy, S: text === "idle" || text === "stopping", T: false };
    for (const each of document.querySelectorAll("[data-command]")) each.disabled = ended || disabled[each.dataset.command];
    $("check").disabled = text === "terminated";
    this.growing = !ended && busy;
  }
  showStatus(s) {
    this.heard = Date.now();
    this.showState(s.state, s.state);
    this.answerCheck(s);
    $("facts").textContent = `${durationText(s.seconds)}, ${sizeText(s.written)} written, ${sizeText(s.disk_free)} free, ${sizeText(s.queued)} queued, ${s.dropped} dropped`;
    this.show("error", s.error);
    // What the logger warns of, in one text or several, of itself or of a sensor.
    const warnings = [s, ...s.sensors].flatMap((x) => [x.warning, x.warnings].flat().filter(Boolean).map((w) => (x.name ? x.name + ": " : "") + w));
    this.show("warned", warnings.join("; "));
    $("sensors").replaceChildren();
    for (const x of s.sensors) {
      const row = $("sensors").insertRow();
      cell(row, x.name);
      cell(row, x.state + (x.note ? " (" + x.note + ")" : ""));
      cell(row, (x.bytes_per_s / 1e3).toFixed(1), true);
      cell(row, x.messages_per_s.toFixed(1), true);
      for (const name of ["skipped_bytes", "dropped", "damaged"]) cell(row, x[name], true);
      cell(row, x.sample);
    }
  }
}

// The samples of a status as messages, where no recording can be read.
function samplesOf(status) {
  const vector = (v) => ({ x: v[0], y: v[1], z: v[2] }), found = [];
  for (const { name, latest: s } of status.sensors) {
    if (!s) continue;
    const { t, ...rest } = s, radians = Math.PI / 180;
    let value = { frame_id: name, ...rest };
    if (s.from_deg !== undefined) value = {
      frame_id: name, start_angle: s.from_deg * radians, end_angle: (s.from_deg + (s.cm.length - 1) * s.step_deg) * radians,
      ranges: s.cm.map((r) => r === null ? null : r / 100),
    };
    else if (s.cm) value = { frame_id: name, points: s.cm.map(([x, y, v]) => ({ x: x / 100, y: y / 100, doppler: v / 100 })) };
    else if (s.force) value = { frame_id: name, linear_acceleration: vector(s.force), angular_velocity: vector(s.rate) };
    found.push(Message.of(`/${name}/latest`, t, value));
  }
  return found;
}
