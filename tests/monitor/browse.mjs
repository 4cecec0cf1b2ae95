// Opens a page in headless Chromium over its debugging protocol:
//   node --experimental-websocket browse.mjs URL PICTURE.png WIDTH EXPRESSION...
// Waits until each expression is true (at most half a minute), then takes the picture.
import { spawn } from "node:child_process";
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";

const [url, picture, width, ...expressions] = process.argv.slice(2);
const profile = await mkdtemp(join(tmpdir(), "wayfare-browser-"));
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
const browser = spawn("chromium", [
  "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
  "--remote-debugging-port=0", `--user-data-dir=${profile}`, `--window-size=${width},1400`, "about:blank",
], { stdio: "ignore" });

async function within(seconds, what, f) {
  for (const end = Date.now() + seconds * 1000; Date.now() < end; await pause(100)) {
    const value = await f().catch(() => undefined);
    if (value) return value;
  }
  throw new Error(`not within ${seconds} s: ${what}`);
}

let status = 1;
try {
  const port = await within(30, "the browser", async () =>
    (await readFile(join(profile, "DevToolsActivePort"), "utf8")).split("\n")[0]);
  const target = await within(10, "a page", async () =>
    (await (await fetch(`http://127.0.0.1:${port}/json/list`)).json()).find((t) => t.type === "page"));
  const socket = new WebSocket(target.webSocketDebuggerUrl);
  await new Promise((done, fail) => { socket.onopen = done; socket.onerror = fail; });
  const answers = new Map(), outside = [];
  let last = 0;
  socket.onmessage = ({ data }) => {
    const message = JSON.parse(data);
    answers.get(message.id)?.(message.result);
    const asked = message.params?.request?.url;
    if (asked && !asked.startsWith("data:") && !asked.startsWith("blob:") && new URL(asked).host !== new URL(url).host) outside.push(asked);
  };
  const call = (method, params = {}) => new Promise((done) => {
    answers.set(++last, done);
    socket.send(JSON.stringify({ id: last, method, params }));
  });
  await call("Network.enable");
  await call("Page.enable");
  await call("Page.navigate", { url });
  for (const expression of expressions)
    await within(30, expression, async () =>
      (await call("Runtime.evaluate", { expression, awaitPromise: true })).result.value);
  await pause(300);
  const shot = await call("Page.captureScreenshot", { captureBeyondViewport: true });
  await writeFile(picture, Buffer.from(shot.data, "base64"));
  if (outside.length) throw new Error("asked outside: " + outside.join(" "));
  console.log("all true");
  status = 0;
} catch (error) {
  console.log(String(error));
}
browser.kill();
await new Promise((done) => (browser.exitCode === null ? browser.once("exit", done) : done()));
await rm(profile, { recursive: true, force: true }).catch(() => {});
process.exit(status);
