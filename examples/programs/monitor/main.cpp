// Shows a recording, or a running logger, in a browser.

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "server.hpp"
#include "support/command_line.hpp"

namespace {

volatile std::sig_atomic_t end_requested = 0;

}  // namespace

int main(int argc, char** argv) {
  using namespace wayfare;
  examples::CommandLine app(
      "Serve a page on this computer that shows a logger's recording (contents, inertial plots, "
      "scans, radar points, path and map, CSV and MCAP export), and a running logger's status with "
      "buttons to start, stop and check it.");
  examples::MonitorOptions o;
  app.add_file("RECORDING", o.recording, "a logger's recording (.mcap)");
  app.add_option("--live", o.live, "control socket, or serial control line, of a running logger");
  app.add_number("--baud", o.baud, 50, 10'000'000,
                 "bits per second of that line, as of the logger's control.baud")
      .needs("--live");
  app.add_option("--host", o.host,
                 "address to listen on; all but loopback addresses require a token")
      .show_default();
  app.add_number("--port", o.port, 0, 65535, "port to listen on; 0: any free port");
  app.add_option("--host-name", o.host_names,
                 "another name of this computer by which browsers may address it; repeatable");
  app.add_option("--token", o.token,
                 "required in every request, and visible to other users of this computer; default: "
                 "generated, on a loopback address for commands only");
  app.add_option("--token-file", o.token_file,
                 "file that gets the token, readable by this user only, while the monitor runs; "
                 "default: $XDG_RUNTIME_DIR/wayfare_monitor_PORT.token");
  app.example("recording.mcap", "a recording at http://127.0.0.1:8090");
  app.example("--live control.sock --port 8100", "a running logger");
  if (const auto code = app.parse(argc, argv)) return *code;
  if (o.recording.empty() && o.live.empty())
    return examples::exit_code("monitor", examples::bad_use("needs a recording or a live logger"));
  const char* const runtime =
      std::getenv("XDG_RUNTIME_DIR");  // NOLINT(concurrency-mt-unsafe): one thread yet
  if (o.token_file.empty() && runtime != nullptr)
    o.token_file = std::string(runtime) + "/wayfare_monitor_" + std::to_string(o.port) + ".token";
  const auto end = [](int) { end_requested = 1; };
  std::signal(SIGINT, end);
  std::signal(SIGTERM, end);
  std::signal(SIGPIPE, SIG_IGN);
  const auto server = examples::MonitorServer::start(o);
  if (!server) return examples::exit_code("monitor", server.error());
  std::printf("%s\n", (*server)->url().c_str());
  std::fflush(stdout);
  while (end_requested == 0) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  return 0;
}
