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

/// Opens `url`; returns the output of the browser's script.
std::string browse(const std::string& url, const std::string& picture,
                   const std::vector<std::string>& expressions) {
  const char* folder = std::getenv("WAYFARE_PICTURES");
  const std::string shot = folder == nullptr ? "/dev/null" : std::string(folder) + "/" + picture;
  std::string command = "node '" WAYFARE_BROWSE "' '" + url + "' '" + shot + "' 1100";
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
  return "new Uint32Array(document.getElementById(\"" + id + "\").getContext(\"2d\")" +
         ".getImageData(0, 0, 600, 150).data.buffer).filter((p) => p !== 0).length > 500";
}

TEST(MonitorInABrowser, ShowsARecording) {
  if (!has_browser()) GTEST_SKIP() << "needs Debian's packages chromium and nodejs";
  const Recorded recorded;
  const auto server = serve({.recording = recorded.path, .token = "sesame"});
  EXPECT_EQ(
      browse(server->url(), "recording.png",
             {"document.body.dataset.ready === \"yes\"",
              "document.querySelectorAll(\"#topics tr\").length === 4", drawn("force"),
              drawn("rate"), drawn("scan"), "document.getElementById(\"make\").click() || true",
              "document.getElementById(\"map\").naturalWidth > 10"}),
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
                   {seen, "kept.units.unit.t.length > 15", "kept.radars.radar !== undefined",
                    "kept.scans.lidar !== undefined", drawn("force"), drawn("rate"), drawn("scan"),
                    click("#check"), in_order}),
            "all true\n");
  EXPECT_EQ(browse(server->url(), "live_map.png",
                   {"document.getElementById(\"state\").textContent === \"idle\"",
                    click("[data-command=B]"), "document.body.dataset.ready === \"yes\"",
                    "document.querySelector(\".from-status\").hidden", drawn("scan"),
                    click("#make"), "document.getElementById(\"map\").naturalWidth > 10",
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
