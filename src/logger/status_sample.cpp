#include "logger/status_sample.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "logger/time_parts.hpp"

namespace wayfare::logger {
namespace {

/// With `decimals`; null where it is not finite or far outside of what sensors measure.
std::string number(double value, int decimals) {
  if (!(std::abs(value) < 1e9)) return "null";
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::fixed, decimals)
                       .ptr;
  return {text.data(), end};
}

std::string centimetres(double metres) { return number(std::round(100.0 * metres), 0); }

template <class Items, class Text>
std::string list(const Items& items, Text text) {
  std::string out = "[";
  for (const auto& item : items) out += (out.size() > 1 ? "," : "") + text(item);
  return out + ']';
}

std::string time_text(LogTime time) {
  const auto [seconds, rest] = seconds_and_rest(time);
  std::string ms = std::to_string(rest / 1'000'000);
  ms.insert(0, 3 - ms.size(), '0');
  return "{\"t\":" + std::to_string(seconds) + '.' + ms;
}

std::string vector_text(const Eigen::Vector3d& v, int decimals) {
  return list(std::array{v.x(), v.y(), v.z()}, [&](double x) { return number(x, decimals); });
}

}  // namespace

std::string status_sample(const MargSample& s) {
  return time_text(s.time) + ",\"force\":" + vector_text(s.specific_force_mps2, 2) +
         ",\"rate\":" + vector_text(s.angular_rate_radps, 3) + '}';
}

std::string status_sample(const LaserScan& scan) {
  constexpr std::size_t kSectors = 72;
  const std::size_t beams = scan.ranges_m.size(),
                    width = std::max<std::size_t>(1, (beams + kSectors - 1) / kSectors);
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> nearest_m((beams + width - 1) / width, kNone);
  for (std::size_t i = 0; i < beams; ++i)
    if (scan.returned(i))
      nearest_m[i / width] = std::fmin(nearest_m[i / width], static_cast<double>(scan.ranges_m[i]));
  const double step_deg = scan.bearing_step.degrees();
  const double middle = 0.5 * (static_cast<double>(width) - 1.0);
  return time_text(scan.time) +
         ",\"from_deg\":" + number(scan.first_bearing.degrees() + middle * step_deg, 2) +
         ",\"step_deg\":" + number(static_cast<double>(width) * step_deg, 4) +
         ",\"cm\":" + list(nearest_m, centimetres) + '}';
}

std::string status_sample(const RadarScan& scan) {
  constexpr std::size_t kMost = 24;
  std::vector<RadarPoint> points = scan.points;
  std::stable_sort(points.begin(), points.end(),
                   [](const RadarPoint& a, const RadarPoint& b) { return a.snr_db > b.snr_db; });
  points.resize(std::min(points.size(), kMost));
  return time_text(scan.time) + ",\"cm\":" +
         list(points,
              [](const RadarPoint& p) {
                return list(std::array{p.x_m, p.y_m, p.doppler_m_s}, centimetres);
              }) +
         '}';
}

}  // namespace wayfare::logger
