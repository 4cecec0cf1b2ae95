// Brings together the time, the messages and what shows them.

readTheme();
const clock = new Clock(), transforms = new Transforms();
const streamed = new Store(32e6, 60);  // of a running logger, by push
const panels = new Panels(clock), scene = new Scene(transforms), inspector = new Inspector();
const logger = new LoggerPanel(), recording = new RecordingPanel(clock);
const loader = new Loader((message) => takeTransform(message));
const drawing = { frames: 0, late: 0, rate: 0, ms: 0 };  // of the animation; ms: to draw all frames
const stream = { source: null, key: null, messages: 0, missed: {}, missedBefore: 0 };
let about = {}, topicsShown = "", logged = "", askedContents = 0;
recording.interval = () => panels.interval();

const isJson = (t) => t.schema === "json" || t.schema in (recording.contents?.schemas ?? {}) || t.sample;
const isTransform = (schema) => /FrameTransform|^tf2/.test(schema ?? "");
let topics = [];
const transformTopics = () => topics.filter((t) => isTransform(t.schema)).map((t) => t.topic);
const wanted = () => [...new Set([...panels.shown(), ...scene.topics(), ...inspector.topics(), ...transformTopics()])].sort();
// The messages around the time shown.
const current = () => (clock.live || !recording.contents) && (clock.following || clock.t >= streamed.from) ? streamed : loader.store;

function takeTransform(message) {
  if (message.text.includes("child_frame_id")) transforms.take(message);
}
function take(message) {
  if (!streamed.add(message)) return;
  takeTransform(message);
  panels.take(message);
  clock.end = Math.max(clock.end, message.t);
  ++stream.messages;
}

// Offers the topics; `samples` has a message of each, as far as there is one.
function setTopics(list, schemas, samples) {
  topics = list = list.sort((a, b) => a.topic.localeCompare(b.topic));
  panels.setTopics(list, schemas, samples, (topic) => streamed.list(topic));
  const clouds = list.filter((t) => isCloudSchema(t.schema) || isCloud(samples.get(t.topic)?.value));
  scene.setTopics(clouds);
  $("scans").hidden = !clouds.length;
  inspector.setTopics(list.map((t) => t.topic));
  $("inspector").hidden = !list.length;
  document.body.dataset.ready = "yes";
}

async function showContents(contents, growing) {
  const begins = growing && !clock.live, other = recording.contents?.path !== contents.path;
  if (other && !clock.live) {
    streamed.clear();
    transforms.frames.clear();
    loader.key = "";
  }
  recording.show(contents, growing);
  for (const note of document.querySelectorAll(".from-status")) note.hidden = true;
  $("transport").hidden = false;
  clock.live = growing;
  clock.start = contents.start_s;
  clock.end = Math.max(contents.start_s + contents.seconds, growing && !other ? clock.end : 0);
  if (!growing && clock.following) clock.pause();
  if (begins) { panels.reset(); clock.follow(); }
  if (other && !growing) { panels.reset(); clock.pause(); clock.t = contents.start_s + contents.seconds / 2; }
  const list = contents.topics.filter((t) => t.messages > 0);
  const key = contents.path + list.map((t) => t.topic).join() + growing;
  if (key === topicsShown) return;
  topicsShown = key;
  recording.setTopics();
  const offered = list.filter(isJson), samples = new Map();
  try {
    const end = contents.seconds + 1, { messages } = await askRange({ topic: offered.map((t) => t.topic), from: end, until: end, before: 1 });
    for (const message of messages) { samples.set(message.topic, message); takeTransform(message); }
  } catch (error) { console.warn(error.message); }
  if (key !== topicsShown) return;  // others have been shown meanwhile
  setTopics(offered, contents.schemas, samples);
}
async function readContents() {
  askedContents = Date.now();
  try {
    const contents = await ask("/api/contents");
    if (!logger.growing) await showContents(contents, false);
  } catch (error) {
    if (!recording.contents) $("size").textContent = error.message;
  }
}

// Without a recording to read, as over a serial line from another computer.
function showSamples(status) {
  const samples = samplesOf(status);
  for (const message of samples) if (!(streamed.list(message.topic).at(-1)?.t >= message.t)) take(message);
  clock.start = streamed.from;
  if (!clock.live) { clock.live = true; clock.follow(); }
  const names = samples.map((m) => m.topic);
  if (!names.length || names.every((name) => topics.some((t) => t.topic === name))) return;
  for (const note of document.querySelectorAll(".from-status")) note.hidden = false;
  setTopics(names.map((topic) => ({ topic, schema: "sample", sample: true })), {}, new Map(samples.map((m) => [m.topic, m])));
}

function takeStatus(status) {
  const was = logger.growing, elsewhere = status.file !== logged;
  logger.showStatus(status);
  if (!recording.contents) showSamples(status);
  // The contents of a growing recording are pushed.
  if (!logger.growing && (elsewhere || was !== logger.growing || !recording.contents && Date.now() - askedContents > 3000)) readContents();
  logged = status.file;
}
function takeContents(contents) {
  if (!logger.growing || contents.path !== logged) return;
  if (!recording.contents) { clock.live = false; }  // until now samples of the statuses
  showContents(contents, true).catch(console.error);
}
function takeMessages(text) {
  const lines = text.split("\n");
  for (let i = 0; i + 1 < lines.length; i += 2) take(new Message(lines[i], lines[i + 1]));
}
function listen() {
  stream.source?.close();
  stream.key = wanted().join("\n");
  stream.missedBefore += missedSum();
  stream.missed = {};
  const source = stream.source = new EventSource(query("/api/events", { topic: wanted() }));
  source.onmessage = (e) => takeStatus(JSON.parse(e.data));
  source.addEventListener("problem", (e) => { logger.problem = JSON.parse(e.data); });
  source.addEventListener("contents", (e) => takeContents(JSON.parse(e.data)));
  source.addEventListener("messages", (e) => takeMessages(e.data));
  source.addEventListener("missed", (e) => { stream.missed = JSON.parse(e.data); });
  // A refused EventSource does not reconnect.
  source.onerror = () => { if (source.readyState === EventSource.CLOSED) setTimeout(() => { if (stream.source === source) listen(); }, 3000); };
}
const missedSum = () => Object.values(stream.missed).reduce((sum, n) => sum + n, 0);

// Buttons and the bar of time.
$("play").onclick = () => { if (clock.playing || clock.following) clock.pause(); else clock.play(); };
$("follow").onclick = () => clock.follow();
$("speed").onchange = () => { clock.speed = Number($("speed").value); };
$("time").oninput = () => clock.seek(clock.start + Number($("time").value));
document.addEventListener("keydown", (event) => {
  if (/INPUT|SELECT|BUTTON|SUMMARY|A/.test(event.target.tagName)) return;
  keys({ " ": () => $("play").click(), ",": () => clock.seek(clock.t - 0.1), ".": () => clock.seek(clock.t + 0.1), l: () => clock.follow() })(event);
});
function showTransport(shownStore) {
  const moving = clock.playing || clock.following, at = clock.t - clock.start;
  $("play").textContent = moving ? "Pause" : "Play";
  $("follow").hidden = !clock.live;
  $("follow").setAttribute("aria-pressed", String(clock.following));
  if (document.activeElement !== $("time") || moving) {
    $("time").max = clock.seconds.toFixed(2);
    $("time").value = at.toFixed(2);
  }
  $("time").setAttribute("aria-valuetext", `${at.toFixed(1)} of ${clock.seconds.toFixed(1)} seconds`);
  $("when").textContent = `${Math.max(0, at).toFixed(2)} s / ${durationText(clock.seconds)}`;
  const missed = stream.missedBefore + missedSum();
  $("flow").textContent = `${drawing.rate.toFixed(0)} frames/s` + (stream.source ? `, ${missed} messages missed` : "") + (shownStore === streamed ? "" : loader.busy ? ", reading" : "");
  $("flow").title = Object.entries(stream.missed).map(([topic, n]) => `${topic}: ${n}`).join("\n");
}

let before = performance.now(), described = 0, counted = 0;
function drawAll(now) {
  const seconds = (now - before) / 1000, store = current(), origin = recording.contents?.start_s ?? clock.start;
  before = now;
  ++drawing.frames;
  drawing.late += Math.max(0, Math.round(seconds * 60) - 1);
  const ready = store === streamed || !recording.contents || loader.ensure(clock.t, clock, origin, wanted());
  clock.advance(Math.min(seconds, 0.25), ready);
  panels.draw(origin, !!recording.contents, store);
  if (!$("scans").hidden && (ready || clock.playing)) { scene.update(clock.t, store); scene.draw(); }
  recording.draw();
  if (now - described < 200) return;
  drawing.rate = (drawing.frames - counted) / (now - described) * 1000;
  described = now;
  counted = drawing.frames;
  showTransport(store);
  scene.describe();
  inspector.update(clock.t, store, origin);
  if (stream.source && stream.key !== wanted().join("\n")) listen();
}
function animate(now) {
  requestAnimationFrame(animate);
  // One message must not end the animation.
  const begun = performance.now();
  try { drawAll(now); } catch (error) { console.error(error); }
  drawing.ms += performance.now() - begun;
}
function redraw() {
  readTheme();
  for (const canvas of document.querySelectorAll("canvas")) canvas.changed = true;
}
darkScheme.onchange = redraw;

(async () => {
  for (const id of ["scene", "walk"]) canvasSizes.observe($(id));
  about = await ask("/api/about");
  recording.cell_m = about.cell_m;
  if (about.live) {
    logger.start();
    listen();
  } else {
    await showContents(await ask("/api/contents"), false);
  }
  requestAnimationFrame(animate);
})().catch((error) => { $("size").textContent = error.message; });
