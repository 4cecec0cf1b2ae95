// Points of laser scans and point clouds, in metres in the frame of the sensor.

const isCloud = (value) => !!value && (Array.isArray(value.ranges) && value.start_angle !== undefined ||
  Array.isArray(value.fields) && value.point_stride > 0 || Array.isArray(value.points) && typeof value.points[0] === "object");
const isCloudSchema = (name) => /LaserScan|PointCloud|LidarNodes/.test(name);
// Messages that do not have a whole turn each.
const isPart = (name) => /LidarNodes/.test(name);

// Readers of the types of foxglove.PackedElementField, from 1.
const packedTypes = [null, ["getUint8", 1], ["getInt8", 1], ["getUint16", 2], ["getInt16", 2],
  ["getUint32", 4], ["getInt32", 4], ["getFloat32", 4], ["getFloat64", 8]];

// n points: x, y, z and further columns by name.
function finished(n, columns, value) {
  const { bearing, range, angle, distance } = columns;
  if (!columns.x && bearing && range) {
    columns.x = range.map((r, i) => r * Math.cos(bearing[i]));
    columns.y = range.map((r, i) => r * Math.sin(bearing[i]));
  } else if (!columns.x && angle && distance) {
    // Nodes of an RPLIDAR: degrees clockwise, quarters of a millimetre.
    columns.x = distance.map((r, i) => (r > 0 ? r / 4000 * Math.cos(angle[i] * Math.PI / 180) : NaN));
    columns.y = distance.map((r, i) => (r > 0 ? -r / 4000 * Math.sin(angle[i] * Math.PI / 180) : NaN));
  }
  for (const axis of ["x", "y", "z"]) columns[axis] ??= new Float32Array(n);
  const pose = value.pose ? poseMatrix(value.pose.position, value.pose.orientation) : identity;
  return { n, columns, pose, frame: value.frame_id ?? "" };
}

function scanPoints(scan) {
  const beams = scan.ranges.length, step = beams > 1 ? (scan.end_angle - scan.start_angle) / (beams - 1) : 0;
  const most = scan.range_max ?? Infinity, least = scan.range_min ?? 0;
  const returned = [];
  for (let i = 0; i < beams; ++i) {
    const r = scan.ranges[i];
    if (r !== null && r > 0 && r >= least && r < most) returned.push(i);
  }
  const columns = {
    bearing: Float32Array.from(returned, (i) => scan.start_angle + i * step),
    range: Float32Array.from(returned, (i) => scan.ranges[i]),
  };
  if (scan.intensities?.length === beams) columns.intensity = Float32Array.from(returned, (i) => scan.intensities[i]);
  return finished(returned.length, columns, scan);
}

function packedPoints(cloud) {
  const text = atob(cloud.data ?? ""), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  const view = new DataView(bytes.buffer), stride = cloud.point_stride, n = Math.floor(bytes.length / stride);
  const columns = {};
  for (const { name, offset, type } of cloud.fields) {
    const [read, size] = packedTypes[type] ?? [];
    if (!read || !(offset >= 0) || offset + size > stride) continue;
    const column = columns[name] = new Float32Array(n);
    for (let i = 0, at = offset; i < n; ++i, at += stride) column[i] = view[read](at, true);
  }
  return finished(n, columns, cloud);
}

function listedPoints(cloud) {
  const columns = {};
  for (const name of Object.keys(cloud.points[0] ?? {}))
    columns[name] = Float32Array.from(cloud.points, (p) => p[name]);
  return finished(cloud.points.length, columns, cloud);
}

// Of a message, or null; kept with it.
function pointsOf(message) {
  if (!message) return null;
  if (message.points === undefined) {
    const value = message.value;
    message.points = null;
    if (isCloud(value))
      message.points = value.ranges ? scanPoints(value) : value.fields ? packedPoints(value) : listedPoints(value);
  }
  return message.points;
}
