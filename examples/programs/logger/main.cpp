// Records several devices. Ends on SIGINT, SIGTERM, or the remote command T.

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>
#include <thread>

#include "config.hpp"
#include "support/command_line.hpp"

namespace {

using namespace wayfare;
using namespace std::chrono_literals;

volatile std::sig_atomic_t end_requested = 0;

struct Arguments {
  std::string config;
  bool record = false;
  bool quiet = false;
};

void print(const logger::LoggerStatus& s) {
  std::printf("%-10s %8.1f s %10.3f MB  %llu dropped", logger::name_of(s.state), s.seconds,
              static_cast<double>(s.written) * 1e-6, static_cast<unsigned long long>(s.dropped));
  for (const logger::SensorStatus& sensor : s.sensors)
    std::printf("  | %s %s %.1f kB/s %s", sensor.name.c_str(), logger::name_of(sensor.state),
                sensor.bytes_per_s * 1e-3, sensor.decoding.sample.c_str());
  if (!s.error.empty()) std::printf("  | %s", s.error.c_str());
  std::printf("\n");
  std::fflush(stdout);
}

Result<void> run(const Arguments& a) {
  auto options = examples::read_logger_config(a.config);
  if (!options) return options.error();
  std::error_code code;
  std::filesystem::create_directories(options->folder, code);
  auto started = logger::Logger::start(std::move(*options));
  if (!started) return started.error();
  logger::Logger& logger = **started;
  if (a.record)
    if (auto begun = logger.begin(); !begun) return begun;
  for (int tick = 1; logger.status().state != logger::LoggerState::terminated; ++tick) {
    std::this_thread::sleep_for(50ms);
    if (end_requested != 0) logger.terminate();
    if (!a.quiet && tick % 20 == 0) print(logger.status());
  }
  const logger::LoggerStatus end = logger.status();
  if (!a.quiet) print(end);
  if (!a.quiet && !end.file.empty()) std::printf("recording: %s\n", end.file.c_str());
  if (!end.error.empty()) return Error{ErrorCode::io, end.error};
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Record several devices into one MCAP file: their bytes and the decoded messages. Begins on "
      "the remote command B, or immediately with --record.");
  Arguments a;
  app.add_file("--config", a.config, "JSON file of sensors and options; see --print-config")
      .required();
  app.add_flag("--record", a.record, "begin to record immediately");
  app.add_flag("--quiet", a.quiet, "no status on the terminal");
  app.add_print(
      "--print-config", [] { return examples::example_logger_config(); },
      "print an example of --config, and exit");
  if (const auto code = app.parse(argc, argv)) return *code;
  const auto end = [](int) { end_requested = 1; };
  std::signal(SIGINT, end);
  std::signal(SIGTERM, end);
  // A file-size limit and a disconnected listener are reported as errors of the write.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  return examples::exit_code("logger", run(a));
}
