// The tuner killed and resumed; run by several processes; one of them lost. WAYFARE_TUNE_KILLS is
// the number of kills (3 by default).

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace wayfare {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;
using Clock = std::chrono::steady_clock;

/// In a process group of its own, so that its children can be found.
pid_t start(const Words& words, const std::string& errors = "/dev/null") {
  const pid_t child = ::fork();
  if (child != 0) return child;
  const int out = ::open(errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  ::dup2(out, 1);
  ::dup2(out, 2);
  std::vector<char*> arguments;
  for (const std::string& w : words) arguments.push_back(const_cast<char*>(w.c_str()));
  arguments.push_back(nullptr);
  ::execv(arguments[0], arguments.data());
  ::_exit(127);
}

int finish(pid_t child) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

std::string content(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class TuneProgram : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("wayfare_tune_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    drive_ = finish(start({WAYFARE_SIMULATE_DRIVE, "--out", (folder_ / "drive").string(),
                           "--imu-rate", "20", "--satellites", "6", "--quiet"}));
    const auto begin = Clock::now();
    whole_ = finish(start(tune("whole")));
    took_ = Clock::now() - begin;
  }
  /// A failure in SetUpTestSuite would count as a test skipped.
  void SetUp() override {
    ASSERT_EQ(drive_, 0);
    ASSERT_EQ(whole_, 0);
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static Words tune(const std::string& out, bool resume = false) {
    Words words = {WAYFARE_TUNE,
                   "--training",
                   (folder_ / "drive").string(),
                   "--out",
                   (folder_ / out).string(),
                   "--population",
                   "32",
                   "--generations",
                   "8",
                   "--threads",
                   "1",
                   "--quiet"};
    if (resume) words.push_back("--resume");
    return words;
  }
  static fs::path checkpoint(const std::string& out) { return folder_ / out / "run_01.checkpoint"; }
  /// After the first generation, before the last.
  static void wait_for_checkpoint(const std::string& out) {
    for (int i = 0; i < 10'000 && !fs::exists(checkpoint(out)); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  static void expect_same_as_whole(const std::string& out) {
    for (const char* file : {"run_01.checkpoint", "tuned.json"})
      EXPECT_EQ(content(folder_ / out / file), content(folder_ / "whole" / file)) << file;
  }

  static inline fs::path folder_;
  static inline int drive_ = -1, whole_ = -1;  // exit codes
  static inline std::chrono::duration<double> took_{};
};

TEST_F(TuneProgram, EndsAsIfItHadNeverBeenKilled) {
  const char* kills_text = std::getenv("WAYFARE_TUNE_KILLS");
  const int kills = kills_text == nullptr ? 3 : std::atoi(kills_text);
  std::mt19937 random(20260502);
  std::uniform_real_distribution<double> share(0.02, 0.98);
  int broken = 0;
  for (int k = 0; k < kills; ++k) {
    const std::string out = "killed_" + std::to_string(k);
    const pid_t child = start(tune(out));
    std::this_thread::sleep_for(share(random) * took_);
    ::kill(child, SIGKILL);
    finish(child);
    // A checkpoint is always complete.
    const std::string saved = content(checkpoint(out));
    if (!saved.empty()) {
      EXPECT_THAT(saved, ::testing::EndsWith("end\n"));
    }
    broken += saved == content(checkpoint("whole")) ? 0 : 1;
    ASSERT_EQ(finish(start(tune(out, true))), 0) << k;
    expect_same_as_whole(out);
    fs::remove_all(folder_ / out);
  }
  std::printf("killed %d times, %d of them before the last generation\n", kills, broken);
}

TEST_F(TuneProgram, EndsAfterTheRunningGenerationWhenAsked) {
  const pid_t child = start(tune("stopped"));
  wait_for_checkpoint("stopped");
  ::kill(child, SIGINT);
  EXPECT_EQ(finish(child), 0);
  EXPECT_THAT(content(checkpoint("stopped")), ::testing::EndsWith("end\n"));
  ASSERT_EQ(finish(start(tune("stopped", true))), 0);
  expect_same_as_whole("stopped");
}

TEST_F(TuneProgram, RefusesACheckpointOfOtherDrives) {
  ASSERT_EQ(finish(start({WAYFARE_SIMULATE_DRIVE, "--out", (folder_ / "other").string(), "--seed",
                          "5", "--imu-rate", "20", "--quiet"})),
            0);
  fs::copy(folder_ / "whole", folder_ / "mixed");
  Words words = tune("mixed", true);
  words[2] = (folder_ / "other").string();
  const std::string errors = (folder_ / "errors").string();
  EXPECT_EQ(finish(start(words, errors)), 1);
  EXPECT_THAT(content(errors), ::testing::HasSubstr("made on other drives"));
}

#ifdef WAYFARE_MPIEXEC

Words launched(const Words& words) {
  ::setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
  ::setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
  ::setenv("OMPI_MCA_rmaps_base_oversubscribe", "1", 1);
  ::setenv("OMPI_MCA_hwloc_base_binding_policy", "none", 1);
  ::setenv("LSAN_OPTIONS", "detect_leaks=0", 1);  // Open MPI leaks
  Words all = {WAYFARE_MPIEXEC, "-n", "2"};
  all.insert(all.end(), words.begin(), words.end());
  return all;
}

TEST_F(TuneProgram, TwoProcessesDoWhatOneDoes) {
  ASSERT_EQ(finish(start(launched(tune("two")), (folder_ / "errors").string())), 0)
      << content(folder_ / "errors");
  expect_same_as_whole("two");
}

/// The child processes of `parent`.
std::vector<pid_t> children_of(pid_t parent) {
  std::vector<pid_t> found;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string stat = content(entry.path() / "stat");
    const auto after = stat.rfind(')');
    if (after == std::string::npos) continue;
    if (std::atoi(stat.c_str() + after + 4) == parent) found.push_back(std::stoi(name));
  }
  return found;
}

TEST_F(TuneProgram, ALostProcessEndsTheRunAndLosesNoGeneration) {
  const std::string errors = (folder_ / "errors").string();
  const pid_t launcher = start(launched(tune("lost")), errors);
  wait_for_checkpoint("lost");
  const auto ranks = children_of(launcher);
  ASSERT_FALSE(ranks.empty());
  ::kill(ranks.back(), SIGKILL);
  EXPECT_NE(finish(launcher), 0);
  EXPECT_THAT(content(errors), ::testing::HasSubstr("exited on signal 9"));
  EXPECT_THAT(content(checkpoint("lost")), ::testing::EndsWith("end\n"));
  ASSERT_EQ(finish(start(tune("lost", true))), 0);
  expect_same_as_whole("lost");
}

#endif

}  // namespace
}  // namespace wayfare
