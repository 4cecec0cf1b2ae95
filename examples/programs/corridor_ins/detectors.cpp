#include "detectors.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numbers>
#include <utility>

#include <wayfare/core/statistics.hpp>
#include <wayfare/eval/table.hpp>

namespace wayfare::examples {
namespace {

double microseconds() {
  return 1e6 * static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

/// Directions have no sense: the difference is within ±90°.
double difference_deg(const DetectorEpoch& e) {
  const double off = (e.windows->direction - e.tracked->direction).radians();
  return Angle::radians(std::remainder(off, std::numbers::pi)).degrees();
}

std::string angle_text(const std::optional<CorridorWalls>& walls) {
  return walls ? eval::fixed(walls->direction.degrees(), 4) : "nan";
}

}  // namespace

std::vector<DetectorEpoch> compare_detectors(const Recording& recording,
                                             const WallOptions& options) {
  WallDetector detector(options);
  std::vector<DetectorEpoch> epochs;
  std::optional<CorridorWalls> last;
  for (const LaserScan& scan : recording.scans) {
    DetectorEpoch e{scan.time, {}, {}, false, 0.0, 0.0};
    const double begin = microseconds();
    if (last) e.tracked = detector.track(scan, *last);
    e.acquired = !e.tracked;
    if (e.acquired) e.tracked = detector.acquire(scan);
    const double middle = microseconds();
    e.windows = detector.fit_windows(scan);
    e.tracked_us = middle - begin;
    e.windows_us = microseconds() - middle;
    last = e.tracked;
    // The search of the next scan: around these walls, not within their own errors.
    if (last) last->covariance.setZero();
    epochs.push_back(std::move(e));
  }
  return epochs;
}

void add_detector_facts(const std::vector<DetectorEpoch>& epochs, Facts& facts) {
  double tracked_us = 0.0, windows_us = 0.0;
  std::size_t tracked = 0, windows = 0, acquired = 0;
  std::vector<double> off;
  for (const DetectorEpoch& e : epochs) {
    tracked_us += e.tracked_us, windows_us += e.windows_us;
    tracked += e.tracked ? 1 : 0, windows += e.windows ? 1 : 0, acquired += e.acquired ? 1 : 0;
    if (e.tracked && e.windows) off.push_back(std::abs(difference_deg(e)));
  }
  const auto n = static_cast<double>(epochs.size());
  facts.emplace_back("tracking", eval::fixed(tracked_us / n, 1) + " us a scan, walls in " +
                                     std::to_string(tracked) + " scans, " +
                                     std::to_string(acquired) + " acquisitions");
  facts.emplace_back("curve fitting", eval::fixed(windows_us / n, 1) + " us a scan, walls in " +
                                          std::to_string(windows) + " scans");
  if (!off.empty())
    facts.emplace_back("angle between both", eval::fixed(median_of(off), 3) + " deg, median");
}

std::string detectors_text(const std::vector<DetectorEpoch>& epochs) {
  std::string text =
      "# time angle_tracking_deg angle_windows_deg tracking_us windows_us acquired\n";
  for (const DetectorEpoch& e : epochs) {
    std::array<char, 200> line{};
    std::snprintf(line.data(), line.size(), "%.6f %s %s %.0f %.0f %d\n", e.time.seconds(),
                  angle_text(e.tracked).c_str(), angle_text(e.windows).c_str(), e.tracked_us,
                  e.windows_us, e.acquired ? 1 : 0);
    text += line.data();
  }
  return text;
}

std::vector<io::Plot> detector_plots(const std::vector<DetectorEpoch>& epochs) {
  io::Plot angle = io::time_plot("Direction of the walls", "deg");
  io::Plot time = io::time_plot("Time to find the walls", "us");
  io::Series tracked{"tracking", {}, {}}, windows{"curve fitting", {}, {}, io::Mark::points};
  io::Series tracked_us{"tracking", {}, {}}, windows_us{"curve fitting", {}, {}};
  for (const DetectorEpoch& e : epochs) {
    const double t = to_seconds(e.time - epochs.front().time);
    if (e.tracked) tracked.add(t, e.tracked->direction.degrees());
    if (e.tracked && e.windows) windows.add(t, e.tracked->direction.degrees() + difference_deg(e));
    tracked_us.add(t, e.tracked_us);
    windows_us.add(t, e.windows_us);
  }
  angle.series = {std::move(tracked), std::move(windows)};
  time.series = {std::move(tracked_us), std::move(windows_us)};
  return {std::move(angle), std::move(time)};
}

}  // namespace wayfare::examples
