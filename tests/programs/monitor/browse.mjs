// Opens a page in headless Chromium over its debugging protocol:
//   node browse.mjs URL PICTURE.png WIDTH[:dark] EXPRESSION...
// Waits until each expression is true (at most half a minute), then takes a screenshot. Dialogs of the
// page are confirmed; its errors, and requests to other hosts, are failures. Texts are printed.
import { spawn } from "node:child_process";
import { mkdtemp, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";

const [url, picture, size, ...expressions] = process.argv.slice(2);
const [width, scheme = "light"] = size.split(":");
const profile = await mkdtemp(join(tmpdir(), "wayfare-browser-"));
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
const browser = spawn("chromium", [
  "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
  "--remote-debugging-pipe", `--user-data-dir=${profile}`, `--window-size=${width},1400`, "about:blank",
], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
const gone = new Promise((done) => { browser.once("exit", done); browser.once("error", done); });

// The pipe carries JSON messages, each terminated by a zero byte.
const answers = new Map(), outside = [], errors = [];
let last = 0, session, held = "";
function take(message) {
  answers.get(message.id)?.(message.result ?? {});
  if (message.method === "Page.javascriptDialogOpening") call("Page.handleJavaScriptDialog", { accept: true });
  if (message.method === "Runtime.exceptionThrown") errors.push(message.params.exceptionDetails.exception?.description ?? message.params.exceptionDetails.text);
  if (message.method === "Runtime.consoleAPICalled" && message.params.type === "error")
    errors.push(message.params.args.map((a) => a.description ?? a.value).join(" "));
  const asked = message.params?.request?.url;
  if (asked && !/^(data|blob):/.test(asked) && new URL(asked).host !== new URL(url).host) outside.push(asked);
}
browser.stdio[4].setEncoding("utf8").on("data", (text) => {
  const messages = (held + text).split("\0");
  held = messages.pop();
  messages.forEach((m) => take(JSON.parse(m)));
});
browser.stdio[3].on("error", () => {});
function call(method, params = {}) {
  return new Promise((done) => {
    answers.set(++last, done);
    browser.stdio[3].write(JSON.stringify({ id: last, method, params, sessionId: session }) + "\0");
  });
}

async function within(seconds, what, f) {
  for (const end = Date.now() + seconds * 1000; Date.now() < end; await pause(100)) {
    const value = await Promise.race([f(), pause(seconds * 1000), gone]).catch(() => undefined);
    if (value) return value;
  }
  throw new Error(`not within ${seconds} s: ${what}`);
}

let status = 1;
try {
  const targetId = await within(60, "the browser", async () =>
    (await call("Target.createTarget", { url: "about:blank" })).targetId);
  session = (await call("Target.attachToTarget", { targetId, flatten: true })).sessionId;
  await call("Network.enable");
  await call("Page.enable");
  await call("Runtime.enable");
  await call("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: scheme }] });
  await call("Emulation.setDeviceMetricsOverride", { width: Number(width), height: 1400, deviceScaleFactor: 1, mobile: false });
  await call("Emulation.setScrollbarsHidden", { hidden: true });
  await call("Page.navigate", { url });
  for (const expression of expressions) {
    const value = await within(30, expression, async () =>
      (await call("Runtime.evaluate", { expression, awaitPromise: true })).result.value);
    if (typeof value === "string") console.log(value);
  }
  await pause(300);
  const shot = await call("Page.captureScreenshot", { captureBeyondViewport: true });
  await writeFile(picture, Buffer.from(shot.data, "base64"));
  if (outside.length) throw new Error("asked outside: " + outside.join(" "));
  if (errors.length) throw new Error("errors of the page: " + errors.join(" | "));
  console.log("all true");
  status = 0;
} catch (error) {
  console.log([String(error), ...errors].join("\n"));
}
browser.kill();
await gone;
await rm(profile, { recursive: true, force: true }).catch(() => {});
process.exit(status);
