// The time that is shown: it follows a running logger, or is played, paused and set.

class Clock {
  constructor() {
    Object.assign(this, {
      start: 0, end: 0, t: 0, speed: 1, playing: false,
      live: false,       // the recording grows
      following: false,  // its end is shown
    });
  }
  get seconds() { return Math.max(0, this.end - this.start); }
  // The messages of the last moments arrive in groups: the clock stays behind them.
  get behind() { return this.end - 0.2; }
  follow() { this.following = this.live; this.playing = false; this.t = this.behind; }
  pause() { this.following = this.playing = false; }
  play() {
    if (this.t >= this.end - 1e-3) this.t = this.start;
    this.playing = true;
    this.following = false;
  }
  seek(t) { this.following = false; this.t = limited(t, this.start, this.end); }

  // `ready`: the messages at the time shown are there.
  advance(seconds, ready) {
    if (this.following) {
      const late = this.behind - (this.t + seconds);
      // Small differences are caught up with smoothly.
      this.t = Math.abs(late) > 1 ? this.behind : this.t + seconds + 0.05 * late;
    } else if (this.playing && ready) {
      this.t += seconds * this.speed;
      if (this.t < this.end) return;
      this.t = this.end;
      if (this.live) this.follow(); else this.playing = false;
    }
  }
}
