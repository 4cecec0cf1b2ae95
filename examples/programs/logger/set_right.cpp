#include "set_right.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <system_error>

#include <wayfare/logger/clock_readings.hpp>

#include "support/command_line.hpp"

namespace wayfare::examples {
namespace {

std::string utc(LogTime time) {
  const std::time_t seconds = time.nanoseconds() / 1'000'000'000;
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S", &parts);
  return text.data();
}

/// Of all files, in order of their stamps.
Result<std::vector<logger::ClockReading>> readings_of(const std::vector<std::string>& files) {
  std::vector<logger::ClockReading> all;
  std::string run;
  for (const std::string& file : files) {
    const auto clock = logger::read_clock(file);
    if (!clock) return clock.error();
    if (file == files.front()) run = clock->run;
    if (clock->run != run)
      return Error{ErrorCode::invalid, "is of another run of the logger than " + files.front(),
                   file};
    all.insert(all.end(), clock->readings.begin(), clock->readings.end());
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  return all;
}

}  // namespace

Result<void> set_right(const SetRight& what) {
  const auto readings = readings_of(what.files);
  if (!readings) return readings.error();
  std::printf("%3s  %-19s  %-19s  %s\n", "", "stamp (UTC)", "computer's clock", "offset");
  for (std::size_t i = 0; i < readings->size(); ++i) {
    const logger::ClockReading& reading = (*readings)[i];
    std::printf("%3zu  %s  %s  %.6f s\n", i + 1, utc(reading.stamp).c_str(),
                utc(reading.wall).c_str(), to_seconds(reading.offset()));
  }
  if (what.out.empty()) return {};
  const auto count = static_cast<int>(readings->size());
  if (what.reading > count)
    return bad_use("--reading: there are " + std::to_string(count) + " readings");
  const int chosen = what.reading == 0 ? count : what.reading;
  const Duration offset = (*readings)[static_cast<std::size_t>(chosen - 1)].offset();
  std::error_code code;
  std::filesystem::create_directories(what.out, code);
  for (const std::string& file : what.files) {
    const auto copy = std::filesystem::path(what.out) / std::filesystem::path(file).filename();
    const auto moved = logger::move_stamps(file, copy.string(), offset);
    if (!moved) return moved.error();
    std::printf("%s: moved by %.6f s\n", copy.c_str(), to_seconds(offset));
    for (const Error& problem : moved->first())
      std::fprintf(stderr, "logger: %s\n", problem.to_string().c_str());
  }
  return {};
}

}  // namespace wayfare::examples
