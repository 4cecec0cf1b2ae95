// Messages by topic and time, bounded in bytes and time.

class Store {
  constructor(bytes, seconds) {
    Object.assign(this, { most: bytes, seconds });
    this.clear();
  }
  clear() {
    this.topics = new Map();
    this.bytes = 0;
    this.from = Infinity;  // all messages of the topics from here on are there
    this.newest = -Infinity;
  }
  // False for a message that is there already.
  add(message) {
    let list = this.topics.get(message.topic);
    if (!list) this.topics.set(message.topic, list = []);
    let i = list.length;
    while (i > 0 && list[i - 1].t > message.t) --i;
    // A new connection repeats what the last one had.
    for (let k = i; k > 0 && list[k - 1].t === message.t; --k) if (list[k - 1].text === message.text) return false;
    list.splice(i, 0, message);
    this.bytes += message.text.length;
    this.newest = Math.max(this.newest, message.t);
    this.from = Math.min(this.from, message.t);
    this.trim(this.newest - this.seconds);
    return true;
  }
  // The last message of each topic stays.
  trim(before) {
    if (this.from >= before && this.bytes <= this.most) return;
    if (this.bytes > this.most) before = Math.max(before, (this.from + this.newest) / 2);
    for (const list of this.topics.values()) {
      let n = 0;
      while (n + 1 < list.length && list[n + 1].t <= before) this.bytes -= list[n++].text.length;
      list.splice(0, n);
    }
    this.from = before;
  }
  // The last message up to `t`.
  at(topic, t) {
    const list = this.topics.get(topic);
    if (!list) return null;
    let low = 0, high = list.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (list[middle].t <= t) low = middle + 1; else high = middle;
    }
    return low > 0 ? list[low - 1] : null;
  }
  list(topic) { return this.topics.get(topic) || []; }
  // Mean interval of a topic's messages.
  interval(topic) {
    const list = this.list(topic);
    return list.length < 3 ? Infinity : (list.at(-1).t - list[0].t) / (list.length - 1);
  }
}

// Messages of a recording around the time that is shown, read ahead of the clock.
class Loader {
  constructor(onMessage) {
    this.store = new Store(64e6, 120);
    this.onMessage = onMessage;
    this.key = "";
    this.until = -Infinity;
    this.busy = false;
  }
  covers(t) { return t >= this.begin && t <= this.until; }
  // False while the messages at `t` are not there yet.
  ensure(t, clock, start, topics) {
    const key = topics.join("\n"), ahead = 2 * clock.speed;
    if (key !== this.key || !(t >= this.begin - 1e-6 && t <= this.until + 1e-6)) {
      if (!this.busy) {
        this.key = key;
        this.read(t, 0.5, start, topics, true);
      }
      return false;
    }
    if (clock.playing && !this.busy && this.until < Math.min(t + ahead, clock.end))
      this.read(this.until, ahead + 1, start, topics, false);
    return true;
  }
  async read(from, seconds, start, topics, replace) {
    this.busy = true;
    try {
      const values = { topic: topics, from: Math.max(0, from - start), until: Math.max(0, from - start) + seconds };
      if (replace) values.before = 1;
      const { until, messages } = await askRange(values);
      if (replace) {
        this.store.clear();
        this.begin = from;
      }
      for (const message of messages) {
        this.store.add(message);
        this.onMessage(message);
      }
      this.until = start + until;
      this.begin = Math.max(this.begin, Math.min(from, this.store.newest - this.store.seconds));
    } catch (error) {
      console.warn(error.message);
      await pause(1000);
    }
    this.busy = false;
  }
}
