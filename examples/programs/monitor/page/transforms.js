// Poses of sensors: rotation and translation in twelve numbers, row by row.

const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];

function poseMatrix({ x = 0, y = 0, z = 0 } = {}, { x: a = 0, y: b = 0, z: c = 0, w = 1 } = {}) {
  const n = a * a + b * b + c * c + w * w, s = n > 0 ? 2 / n : 0;
  return [
    1 - s * (b * b + c * c), s * (a * b - c * w), s * (a * c + b * w), x,
    s * (a * b + c * w), 1 - s * (a * a + c * c), s * (b * c - a * w), y,
    s * (a * c - b * w), s * (b * c + a * w), 1 - s * (a * a + b * b), z,
  ];
}
function product(p, q) {
  const out = new Array(12);
  for (let i = 0; i < 12; i += 4)
    for (let k = 0; k < 4; ++k)
      out[i + k] = p[i] * q[k] + p[i + 1] * q[4 + k] + p[i + 2] * q[8 + k] + (k === 3 ? p[i + 3] : 0);
  return out;
}
function inverse(p) {
  const out = [p[0], p[4], p[8], 0, p[1], p[5], p[9], 0, p[2], p[6], p[10], 0];
  for (let i = 0; i < 12; i += 4) out[i + 3] = -(out[i] * p[3] + out[i + 1] * p[7] + out[i + 2] * p[11]);
  return out;
}

// Of each frame its parent and its poses over time.
class Transforms {
  constructor() { this.frames = new Map(); }
  // Messages with one transform or a list of them; others are ignored.
  take(message) {
    const value = message.value;
    for (const one of Array.isArray(value?.transforms) ? value.transforms : [value]) {
      if (!one?.child_frame_id || one.parent_frame_id === undefined) continue;
      let frame = this.frames.get(one.child_frame_id);
      if (!frame) this.frames.set(one.child_frame_id, frame = { poses: [] });
      frame.parent = one.parent_frame_id;
      const pose = { t: message.t, matrix: poseMatrix(one.translation, one.rotation) };
      let i = frame.poses.length;
      while (i > 0 && frame.poses[i - 1].t > pose.t) --i;
      if (i > 0 && frame.poses[i - 1].t === pose.t) frame.poses[i - 1] = pose; else frame.poses.splice(i, 0, pose);
      if (frame.poses.length > 2000) frame.poses.shift();
    }
  }
  root(frame) {
    for (let i = 0; i < 100 && this.frames.has(frame); ++i) frame = this.frames.get(frame).parent;
    return frame;
  }
  names() {
    const all = new Set();
    for (const [child, { parent }] of this.frames) all.add(parent).add(child);
    return [...all];
  }
  // From the frame to its root at a time; poses hold until the next.
  toRoot(frame, t) {
    let all = identity;
    for (let i = 0; i < 100 && this.frames.has(frame); ++i) {
      const { parent, poses } = this.frames.get(frame);
      all = product((poses.findLast((p) => p.t <= t) ?? poses[0]).matrix, all);
      frame = parent;
    }
    return all;
  }
  // Null where the frames are not connected.
  between(from, to, t) {
    if (from === to) return identity;
    if (this.root(from) !== this.root(to)) return null;
    return product(inverse(this.toRoot(to, t)), this.toRoot(from, t));
  }
}
