// The monitor's page in a browser. WAYFARE_PICTURES is a folder for the browser's screenshots.

#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "monitor_support.hpp"

namespace wayfare::examples {
namespace {

bool has_browser() {
  return std::system("command -v chromium >/dev/null && command -v node >/dev/null") == 0;
}

/// Opens `url` at a width, of the dark scheme if it ends in `:dark`; returns the output of the
/// browser's script.
std::string browse(const std::string& url, const std::string& picture,
                   const std::vector<std::string>& expressions, const std::string& width = "1100") {
  const char* folder = std::getenv("WAYFARE_PICTURES");
  const std::string shot = folder == nullptr ? "/dev/null" : std::string(folder) + "/" + picture;
  std::string command = "node '" WAYFARE_BROWSE "' '" + url + "' '" + shot + "' " + width;
  for (const std::string& expression : expressions) command += " '" + expression + "'";
  std::string out;
  FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;)
    out.append(buffer, n);
  ::pclose(pipe);
  return out;
}

/// Whether something was drawn on a canvas.
std::string drawn(const std::string& id) {
  return "document.getElementById(\"" + id + "\") !== null && " +
         "new Uint32Array(document.getElementById(\"" + id + "\").getContext(\"2d\")" +
         ".getImageData(0, 0, 500, 180).data.buffer).filter((p) => p !== 0).length > 500";
}

TEST(MonitorInABrowser, ShowsARecording) {
  if (!has_browser()) GTEST_SKIP() << "needs Debian's packages chromium and nodejs";
  const Recorded recorded;
  const auto server = serve({.recording = recorded.path, .token = "sesame"});
  EXPECT_EQ(
      browse(server->url(), "recording.png",
             {"document.body.dataset.ready === \"yes\"",
              "document.querySelectorAll(\"#topics tr\").length === 4", drawn("plot1"),
              drawn("plot2"), drawn("scene"), "document.getElementById(\"make\").click() || true",
              "document.getElementById(\"map\").naturalWidth > 10"}),
      "all true\n");
}

/// Whether no more than the width is needed.
const std::string kFits = "document.documentElement.scrollWidth <= innerWidth";
/// Whether screen readers have a name for all that can be used.
const std::string kNamed =
    "[...document.querySelectorAll(\"button, select, input, canvas, summary, a, img\")].every((e) "
    "=> (e.getAttribute(\"aria-label\") || e.alt || e.textContent || "
    "e.closest(\"label\")?.textContent || \"\").trim() !== \"\")";

TEST(MonitorInABrowser, PlaysARecording) {
  if (!has_browser()) GTEST_SKIP() << "needs Debian's packages chromium and nodejs";
  const Recorded recorded;
  const auto server = serve({.recording = recorded.path});
  const std::string at_s = "(clock.t - clock.start)";
  EXPECT_EQ(
      browse(
          server->url(), "play.png",
          {"document.body.dataset.ready === \"yes\" && loader.store.at(\"/lidar/scan\", "
           "clock.t) !== null",
           // Set in the middle, it plays at eight times the speed up to the end and stops there.
           "Math.abs(" + at_s + " - 10) < 0.1",
           "($(\"speed\").value = \"8\", $(\"speed\").onchange(), $(\"play\").click(), true)",
           "!clock.playing && " + at_s + " > 19.9",
           "Math.abs(loader.store.at(\"/lidar/scan\", clock.t).t - clock.start - 19.8) < 0.01",
           // Backwards, beyond what is kept.
           "($(\"time\").value = \"3.05\", $(\"time\").oninput(), true)",
           "Math.abs(loader.store.at(\"/lidar/scan\", clock.t).t - clock.start - 3) < 0.01",
           // Zoom to a second: the curve has all of its samples.
           "(panels.zoom(0.05, clock.t), true)",
           "panels.plots[0].past.t.filter((t, i, all) => i === 0 || t > all[i - 1]).length > 100 "
           "&& Math.abs(panels.plots[0].past.t[1] - panels.plots[0].past.t[0] - 0.01) < 1e-6",
           // The keyboard reads values.
           "(panels.plots[0].canvas.onkeydown(new KeyboardEvent(\"keydown\", "
           "{ key: \"ArrowRight\" })), true)",
           "/s: x 0.2, y 0, z .* m.s²$/.test(panels.plots[0].readout.textContent)",
           "($(\"inspector\").open = true, $(\"inspected\").value = \"/unit/imu\", true)",
           "$(\"tree\").textContent.includes(\"angular_velocity\")",
           "($(\"export_shown\").click(), [...document.querySelectorAll(\"#topics "
           "a\")].every((a) => /from=2\\.\\d+&until=3\\.\\d+/.test(a.href)))",
           "(panels.add(\"/lidar/scan\", \"ranges\"), true)", drawn("plot3"), kFits, kNamed}),
      "all true\n");
}

TEST(MonitorInABrowser, FitsATelephoneAndTheDark) {
  if (!has_browser()) GTEST_SKIP() << "needs Debian's packages chromium and nodejs";
  const Recorded recorded;
  const auto server = serve({.recording = recorded.path});
  EXPECT_EQ(browse(server->url(), "narrow.png",
                   {"document.body.dataset.ready === \"yes\"",
                    "panels.plots.every((p) => p.past !== null)", drawn("plot1"),
                    "($(\"inspector\").open = true)", kFits,
                    "getComputedStyle(document.body).backgroundColor === \"rgb(21, 27, 33)\"",
                    "($(\"from_side\").click(), !scene.isFlat)", drawn("scene")},
                   "390:dark"),
            "all true\n");
}

// Two sensors on a base, one turned by a quarter; the poses are in two forms.
TEST(MonitorInABrowser, AppliesTransforms) {
  if (!has_browser()) GTEST_SKIP() << "needs Debian's packages chromium and nodejs";
  const TemporaryFolder folder;
  auto writer = *io::McapWriter::create(folder / "mounted.mcap");
  const auto put = [&](const char* topic, const char* schema, const std::string& text) {
    const auto channel =
        *writer.add_channel(topic, "json", *writer.add_schema(schema, "jsonschema", "{}"));
    EXPECT_TRUE(writer.write(channel, at(0.0), at(0.0), text));
    EXPECT_TRUE(writer.write(channel, at(1.0), at(1.0), text));
  };
  put("/tf_static", "foxglove.FrameTransforms",
      R"({"transforms":[{"parent_frame_id":"base","child_frame_id":"lidar",)"
      R"("translation":{"x":1,"y":2,"z":3},"rotation":{"x":0,"y":0,"z":1,"w":1}}]})");
  put("/tf", "foxglove.FrameTransform",
      R"({"parent_frame_id":"base","child_frame_id":"radar","translation":{"x":0,"y":0,"z":-1}})");
  put("/lidar/scan", "foxglove.LaserScan",
      logger::laser_scan_json({at(0.0), Angle(), Angle::degrees(90.0), 0.1F, 9.0F, {2.0F}},
                              "lidar"));
  put("/radar/points", "foxglove.PointCloud",
      logger::point_cloud_json({at(0.0), {{4.0F, 0.0F, 0.0F, 1.0F, 9.0F}}}, "radar"));
  EXPECT_TRUE(writer.close());
  const auto server = serve({.recording = folder / "mounted.mcap"});
  // Two metres ahead of the scanner, which looks to the left of the base.
  const auto placed = [](const std::string& topic, const std::string& xyz) {
    return "(() => { const { points: { columns: { x, y, z } }, matrix: m } = scene.layers.get(\"" +
           topic + "\"); return " + xyz +
           ".every((v, k) => Math.abs(m[4 * k] * x[0] + m[4 * k + 1] * y[0] + m[4 * k + 2] * z[0] "
           "+ m[4 * k + 3] - v) < 1e-6); })()";
  };
  EXPECT_EQ(browse(server->url(), "transforms.png",
                   {"document.body.dataset.ready === \"yes\"", "scene.layers.size === 2",
                    placed("/lidar/scan", "[1, 4, 3]"), placed("/radar/points", "[4, 0, -1]"),
                    "[...$(\"fixed_frame\").options].map((o) => o.value).join() === "
                    "\",base,lidar,radar\"",
                    "(scene.fixed = \"lidar\", true)", placed("/radar/points", "[-2, -3, -4]")}),
            "all true\n");
}

TEST(MonitorInABrowser, StartsAndStopsALiveLogger) {
  if (!has_browser()) GTEST_SKIP() << "needs Debian's packages chromium and nodejs";
  const Live live;
  const auto server = serve({.live = live.folder / "control"});
  const auto click = [](const std::string& command) {
    return "document.querySelector(\"[data-command=" + command + "]\").click() || true";
  };
  const auto state = [](const std::string& name) {
    return "document.getElementById(\"state\").textContent === \"" + name + "\"";
  };
  EXPECT_EQ(
      browse(server->url(), "live.png",
             {state("idle"), click("B"), state("recording"), click("S"), state("idle"), click("B"),
              state("recording"), "document.querySelectorAll(\"#sensors tr\").length === 1"}),
      "all true\n");
  EXPECT_EQ(live.running->status().state, logger::LoggerState::recording);
}

// No recording can be read: graphs of the samples in the statuses. Then one grows, and its map.
TEST(MonitorInABrowser, ShowsALoggerOverASerialLine) {
  if (!has_browser()) GTEST_SKIP() << "needs Debian's packages chromium and nodejs";
  const Line line;
  const LiveDevices live(line);
  const auto server = serve({.live = line.second(), .baud = 115200});
  const std::string seen = "document.querySelector(\".from-status\").hidden === false";
  const std::string in_order =
      "document.getElementById(\"checked\").textContent.includes(\"3 of 3 sensors in order\")";
  const auto click = [](const std::string& what) {
    return "document.querySelector(\"" + what + "\").click() || true";
  };
  EXPECT_EQ(browse(server->url(), "line.png",
                   {seen, "streamed.list(\"/unit/latest\").length > 15",
                    "streamed.list(\"/radar/latest\").length > 0",
                    "streamed.list(\"/lidar/latest\").length > 0", drawn("plot1"), drawn("plot2"),
                    drawn("scene"), click("#check"), in_order}),
            "all true\n");
  EXPECT_EQ(browse(server->url(), "live_map.png",
                   {"document.getElementById(\"state\").textContent === \"idle\"",
                    click("[data-command=B]"), "document.body.dataset.ready === \"yes\"",
                    "document.querySelector(\".from-status\").hidden", drawn("scene"),
                    // Every message since the beginning, pushed.
                    "streamed.list(\"/lidar/scan\").length > 8 && missedSum() === 0",
                    "(() => { const n = streamed.list(\"/unit/imu\"); return n.length > 100 && "
                    "n.every((m, i) => i === 0 || m.t >= n[i - 1].t); })()",
                    // A page that stalls for a while draws less, and says so.
                    "(window.lateBefore = drawing.late) >= 0",
                    "(() => { for (const end = performance.now() + 300; performance.now() < end;); "
                    "return true; })()",
                    "drawing.late - lateBefore >= 10", "clock.following",
                    // Back in time, from the recording that grows; and live again.
                    "(clock.seek(clock.start + 1), !clock.following)",
                    "(panels.fixed = [clock.start - 1, clock.start + 2], true)",
                    "panels.plots[0].past !== null && panels.plots[0].past.t.length > 50",
                    "($(\"follow\").click(), clock.following)", click("#make"),
                    "document.getElementById(\"map\").naturalWidth > 10",
                    "document.getElementById(\"making\").textContent.includes(\"followed\")",
                    "(window.first = window.first || document.getElementById(\"map\").src) !== "
                    "document.getElementById(\"map\").src"}),
            "all true\n");
}

TEST(MonitorInABrowser, SaysWhenTheLoggerIsGone) {
  if (!has_browser()) GTEST_SKIP() << "needs Debian's packages chromium and nodejs";
  Live live;
  const auto server = serve({.live = live.folder / "control"});
  std::thread end([&] {
    if (!wait_for(120s,
                  [&] { return live.running->status().state == logger::LoggerState::terminated; }))
      return;
    live.running.reset();
  });
  EXPECT_EQ(browse(server->url(), "gone.png",
                   {"document.getElementById(\"state\").textContent === \"idle\"",
                    "document.querySelector(\"[data-command=T]\").click() || true",
                    "document.getElementById(\"state\").className === \"lost\"",
                    "document.querySelectorAll(\"[data-command]:disabled\").length === 3"}),
            "all true\n");
  end.join();
  EXPECT_EQ(live.running, nullptr);
}

}  // namespace
}  // namespace wayfare::examples
