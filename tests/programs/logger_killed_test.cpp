// The logger program killed without warning, and against the limit of a file's size.
// WAYFARE_LOGGER_KILLS is the number of kills (5 by default).

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "logger/simulated_devices.hpp"

namespace wayfare {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::wayfare::testing::Played;
using ::wayfare::testing::raw_channel;
using ::wayfare::testing::SimulatedDevice;
using ::wayfare::testing::TemporaryFolder;
using ::wayfare::testing::wait_for;

/// Starts the logger on `config`, with a file-size limit.
pid_t start_logger(const std::string& config, const std::string& errors = "/dev/null",
                   rlim_t limit = RLIM_INFINITY) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  const int fd = ::open(errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  ::dup2(fd, 2);
  const rlimit most{limit, limit};
  ::setrlimit(RLIMIT_FSIZE, &most);
  // A coverage profile cut short would spoil those of later runs.
  if (limit != RLIM_INFINITY) ::setenv("LLVM_PROFILE_FILE", "/dev/null", 1);
  ::execl(WAYFARE_LOGGER, "logger", "--config", config.c_str(), "--record", "--quiet",
          static_cast<char*>(nullptr));
  ::_exit(127);
}

/// The recordings of a folder.
std::vector<std::string> recordings(const std::string& folder) {
  std::vector<std::string> found;
  if (!std::filesystem::exists(folder)) return found;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    found.push_back(entry.path().string());
  return found;
}

/// A configuration for one device that records into `folder`.
std::string configure(const TemporaryFolder& folder, const std::string& port) {
  const std::string path = folder / "logger.json";
  std::ofstream(path) << R"({"folder": ")" << (folder / "out")
                      << R"(", "sensors": [{"name": "unit", "port": ")" << port << R"("}]})";
  return path;
}

TEST(LoggerProgram, LosesAFifthOfASecondAtMostWhenKilled) {
  const char* kills_text = std::getenv("WAYFARE_LOGGER_KILLS");
  const int kills = kills_text == nullptr ? 5 : std::atoi(kills_text);
  std::mt19937 random(20260501);
  double worst_s = 0.0, least_s = 1e9;
  for (int k = 0; k < kills; ++k) {
    const TemporaryFolder folder;
    // The number of bytes gives the time: 20 000 per second.
    const double rate = 20000.0;
    SimulatedDevice device{{"unit", "raw", 115200, ""}, rate, std::string(50'000, '\0')};
    for (char& byte : device.capture) byte = static_cast<char>(random());
    Played played(device, 1.0, 2.0);
    const pid_t logger = start_logger(configure(folder, played.path()));
    ASSERT_TRUE(wait_for(30s, [&] { return !recordings(folder / "out").empty(); }));
    std::this_thread::sleep_for(200ms);  // it is ready
    played.start();
    const auto begin = std::chrono::steady_clock::now();
    std::this_thread::sleep_for(std::chrono::microseconds(100'000 + random() % 900'000));
    ::kill(logger, SIGKILL);
    const std::chrono::duration<double> sent_for = std::chrono::steady_clock::now() - begin;
    ::waitpid(logger, nullptr, 0);
    played.stop();
    const auto reader = io::McapReader::open(recordings(folder / "out").at(0));
    ASSERT_TRUE(reader) << k;
    EXPECT_FALSE(reader->contents().indexed);
    const auto raw = raw_channel(*reader, "/unit/raw");
    ASSERT_EQ(raw.bytes, played.bytes().substr(0, raw.bytes.size())) << k;
    const double missing_s = sent_for.count() - static_cast<double>(raw.bytes.size()) / rate;
    worst_s = std::max(worst_s, missing_s);
    if (sent_for.count() > 0.4) least_s = std::min(least_s, missing_s);
  }
  std::printf("killed %d times, at most %.3f s missing\n", kills, worst_s);
  // By default the machine may be busy with other tests.
  EXPECT_LT(kills_text == nullptr ? least_s : worst_s, 0.2);
}

TEST(LoggerProgram, SaysSoWhereAFileMayNotGrow) {
  const TemporaryFolder folder;
  SimulatedDevice device{{"unit", "raw", 115200, ""}, 200'000.0, std::string(10'000, 'x')};
  Played played(device, 1.0, 3.0);
  const std::string config = configure(folder, played.path());
  const pid_t logger = start_logger(config, folder / "errors", 100'000);
  ASSERT_TRUE(wait_for(30s, [&] { return !recordings(folder / "out").empty(); }));
  played.start();
  // The file is at its limit if it does not grow while the device sends.
  std::uintmax_t size = 0;
  const auto at_limit = [&] {
    const auto before =
        std::exchange(size, std::filesystem::file_size(recordings(folder / "out").at(0)));
    std::this_thread::sleep_for(300ms);
    return size > 60'000 && size == before;
  };
  ASSERT_TRUE(wait_for(30s, at_limit));
  // It still responds, and ends with the error.
  ASSERT_EQ(::kill(logger, SIGTERM), 0);
  int status = 0;
  ::waitpid(logger, &status, 0);
  played.stop();
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
  std::ifstream in(folder / "errors");
  const std::string errors((std::istreambuf_iterator<char>(in)), {});
  EXPECT_THAT(errors, HasSubstr("cannot be written"));
  const auto reader = io::McapReader::open(recordings(folder / "out").at(0));
  ASSERT_TRUE(reader);
  const auto raw = raw_channel(*reader, "/unit/raw");
  EXPECT_GT(raw.bytes.size(), 50'000U);
  EXPECT_EQ(raw.bytes, played.bytes().substr(0, raw.bytes.size()));
}

}  // namespace
}  // namespace wayfare
