// Requests to the monitor's server.

const token = new URLSearchParams(location.search).get("token") ||
  new URLSearchParams(location.hash.slice(1)).get("token") || "";

// Values that are lists repeat their name.
function query(path, values = {}) {
  const all = new URLSearchParams();
  for (const [name, value] of Object.entries(values))
    for (const one of [value].flat()) all.append(name, one);
  if (token) all.set("token", token);
  return path + (all.size ? "?" + all : "");
}

// Retried while the server is busy.
async function fetched(path, values) {
  for (let again = 0; ; ++again) {
    const answer = await fetch(query(path, values));
    if (answer.ok) return answer;
    if (again === 5 || (answer.status !== 503 && answer.status !== 429))
      throw new Error((await answer.text()).trim());
    await pause(200 * 2 ** again);
  }
}

const ask = async (path, values) => (await fetched(path, values)).json();

// A message; its text is parsed where it is needed.
class Message {
  constructor(head, text) {
    const { topic, t, m } = JSON.parse(head);
    Object.assign(this, { topic, t, m, text, parsed: undefined });
  }
  static of(topic, t, value) {
    const text = JSON.stringify(value);
    const made = new Message(JSON.stringify({ topic, t, m: t }), text);
    made.parsed = value;
    return made;
  }
  get value() {
    if (this.parsed === undefined) {
      try { this.parsed = JSON.parse(this.text); } catch { this.parsed = null; }
    }
    return this.parsed;
  }
}

// Messages in two lines each, and the time up to which all are there.
async function askRange(values) {
  const lines = (await (await fetched("/api/range", values)).text()).trimEnd().split("\n");
  const { until } = JSON.parse(lines.pop()), messages = [];
  for (let i = 0; i + 1 < lines.length; i += 2) messages.push(new Message(lines[i], lines[i + 1]));
  return { until, messages };
}
