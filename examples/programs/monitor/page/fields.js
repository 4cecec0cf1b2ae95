// Fields of messages, from their JSON schema and from the messages.

const paths = new Map();
const pathOf = (field) => {
  let path = paths.get(field);
  if (!path) paths.set(field, path = field.split("."));
  return path;
};

// NaN where there is no number.
function numberAt(value, field) {
  for (const name of pathOf(field)) {
    if (value === null || value === undefined) return NaN;
    value = value[name];
  }
  if (typeof value === "boolean") return value ? 1 : 0;
  return typeof value === "number" ? value : NaN;
}
function valueAt(value, field) {
  for (const name of pathOf(field)) value = value?.[name];
  return value;
}

// Physical units that the schema names (`"unit": "m"`, or brackets in its description), else of
// well-known names.
const unitsByName = [
  [/_mps2$/, "m/s²"], [/_mps$/, "m/s"], [/_mmps$/, "mm/s"], [/_radps$/, "rad/s"], [/_e7_deg$/, "10⁻⁷ °"], [/_e5_deg$/, "10⁻⁵ °"],
  [/_m$/, "m"], [/_mm$/, "mm"], [/_c$/, "°C"], [/_ns$/, "ns"], [/_us$/, "µs"], [/_ms$/, "ms"], [/_percent$/, "%"], [/_dbm$/, "dBm"],
  [/^angular_(velocity|rate)|gyro/, "rad/s"], [/linear_acceleration|specific_force|force/, "m/s²"],
  [/magnetic/, "µT"], [/angle|bearing|roll|pitch|yaw/, "rad"], [/range|position|distance|altitude|translation/, "m"],
  [/velocity|doppler|speed/, "m/s"], [/pressure/, "Pa"], [/temperature/, "°C"], [/snr|noise|_db$/, "dB"],
  [/latitude|longitude|_deg$/, "°"], [/bytes_per_s/, "B/s"], [/_per_s$/, "1/s"], [/seconds|_s$|increment/, "s"],
];
function unitOf(field, schema) {
  let node = schema, unit = "";
  for (const name of pathOf(field)) {
    node = node?.properties?.[name] ?? node?.items;
    unit = node?.unit ?? /\[([^\]]+)\]/.exec(node?.description ?? "")?.[1] ?? unit;
  }
  return unit || unitsByName.find(([name]) => name.test(field))?.[1] || "";
}

const hasType = (schema, name) => [schema?.type].flat().includes(name);
const isNumeric = (schema, value) => typeof value === "number" || typeof value === "boolean" ||
  (value === undefined || value === null) && ["number", "integer", "boolean"].some((t) => hasType(schema, t));

// What can be plotted: fields of numbers, objects of such fields together, and lists of numbers.
function choicesOf(schema, value, prefix = "", found = []) {
  const names = new Set([...Object.keys(schema?.properties ?? {}), ...Object.keys(value ?? {})]);
  const numbers = [], within = (name) => (prefix ? prefix + "." : "") + name;
  const deeper = [];
  for (const name of names) {
    if (!prefix && name === "timestamp") continue;
    const inner = schema?.properties?.[name], v = value?.[name], field = within(name);
    if (isNumeric(inner, v)) numbers.push(field);
    else if (Array.isArray(v) && v.length > 1 && v.length < 10 && v.every((x) => typeof x === "number")) {
      const each = v.map((_, i) => `${field}.${i}`);
      found.push({ field, kind: "numbers", fields: each.slice(0, 8) }, ...each.map((one) => ({ field: one, kind: "numbers", fields: [one] })));
    } else if (Array.isArray(v) && v.length && v.every((x) => x === null || typeof x === "number") ||
             !v && hasType(inner, "array") && isNumeric(inner.items, undefined))
      found.push({ field, kind: "list", fields: [field] });
    else if (Array.isArray(v)) v.slice(0, 32).forEach((x, i) => { if (x && typeof x === "object") deeper.push([inner?.items, x, `${field}.${i}`]); });
    else if (v && typeof v === "object" || inner?.properties) deeper.push([inner, v, field]);
  }
  if (prefix && numbers.length > 1) found.push({ field: prefix, kind: "numbers", fields: numbers.slice(0, 8) });
  for (const field of numbers) found.push({ field, kind: "numbers", fields: [field] });
  for (const [inner, v, field] of deeper) if (field.split(".").length < 6) choicesOf(inner, v, field, found);
  return found;
}
