#include <wayfare/nav/travel_direction.hpp>

#include <algorithm>
#include <cmath>

namespace wayfare {
namespace {

constexpr std::size_t kMostPoints = 120;
constexpr double kTurnStep_rad = 0.0175;
/// Points farther from the next are too sparse to be found on a surface.
constexpr double kDense_m = 0.15;

/// The end point of each beam; NaN without a return.
std::vector<Eigen::Vector2d> points_of(const LaserScan& scan) {
  std::vector<Eigen::Vector2d> points(scan.ranges_m.size(),
                                      Eigen::Vector2d::Constant(std::nan("")));
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!scan.returned(i) || !(scan.ranges_m[i] > 0.0F)) continue;
    const double b = scan.bearing(i).radians(), r = static_cast<double>(scan.ranges_m[i]);
    points[i] = {r * std::cos(b), r * std::sin(b)};
  }
  return points;
}

/// Squared distance of a point from the segment between two points.
double squared_distance(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                        const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double n = along.squaredNorm();
  const double u = n > 0.0 ? std::clamp((p - a).dot(along) / n, 0.0, 1.0) : 0.0;
  return (p - a - u * along).squaredNorm();
}

/// Squared distance of a point from the surface that beams near its bearing hit, at most `most`;
/// negative outside the field of view.
double from_surface(const LaserScan& scan, const std::vector<Eigen::Vector2d>& points,
                    const Eigen::Vector2d& p, double most) {
  constexpr double kConnected_m = 0.3;
  constexpr int kReach = 3;
  const double bearing = std::atan2(p.y(), p.x()) - scan.first_bearing.radians();
  const double at =
      wrap_to_pi(bearing - 0.5 * scan.bearing_step.radians() * static_cast<double>(points.size())) /
          scan.bearing_step.radians() +
      0.5 * static_cast<double>(points.size());
  const int n = static_cast<int>(points.size()), middle = static_cast<int>(std::lround(at));
  if (middle < 0 || middle >= n) return -1.0;
  double least = most;
  for (int i = std::max(middle - kReach, 0); i <= std::min(middle + kReach, n - 1); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (std::isnan(points[k].x())) continue;
    const bool connected = i + 1 < n && (points[k + 1] - points[k]).norm() < kConnected_m;
    least = std::min(least, connected ? squared_distance(p, points[k], points[k + 1])
                                      : (p - points[k]).squaredNorm());
  }
  return least;
}

bool usable(const LaserScan& scan) {
  return scan.ranges_m.size() > 1 && std::isfinite(scan.bearing_step.radians()) &&
         scan.bearing_step.radians() != 0.0 && std::isfinite(scan.first_bearing.radians());
}

}  // namespace

double TravelDirection::cost(double distance_m, double turn_rad) const {
  const SE2d motion = SE2d(distance_m * std::cos(0.5 * turn_rad),
                           distance_m * std::sin(0.5 * turn_rad), Angle::radians(turn_rad));
  const SE2d T_now_before = (T_base_laser_.inverse() * motion * T_base_laser_).inverse();
  const double most = options_.far_m * options_.far_m;
  double sum = 0.0, n = 0.0;
  for (const Eigen::Vector2d& p : before_) {
    const double square = from_surface(now_, now_points_, T_now_before * p, most);
    if (square >= 0.0) sum += square, n += 1.0;
  }
  return n > 0.0 ? sum / n : most;
}

double TravelDirection::least_cost(double distance_m, double turn_rad) const {
  double least = cost(distance_m, turn_rad);
  for (double off = kTurnStep_rad; off <= options_.turn_error_rad; off += kTurnStep_rad)
    for (const double turn : {turn_rad - off, turn_rad + off})
      least = std::min(least, cost(distance_m, turn));
  return least;
}

int TravelDirection::add(const LaserScan& scan, double distance_m, double turn_rad) {
  if (!usable(scan)) return log_odds_ < 0.0 ? -1 : 1;
  now_ = scan;
  now_points_ = points_of(scan);
  const double d = std::abs(distance_m);
  if (!before_.empty() && d >= options_.least_distance_m && std::isfinite(d + turn_rad)) {
    const double p = options_.reversal_probability;
    const double forward = 1.0 / (1.0 + std::exp(-log_odds_));
    const double next = (1.0 - p) * forward + p * (1.0 - forward);
    const double gain = (least_cost(-d, turn_rad) - least_cost(d, turn_rad)) *
                        options_.independent_points /
                        (2.0 * options_.point_sigma_m * options_.point_sigma_m);
    log_odds_ = std::log(next / (1.0 - next)) +
                std::clamp(gain, -options_.greatest_log_odds, options_.greatest_log_odds);
  }
  before_.clear();
  const std::size_t every = now_points_.size() / kMostPoints + 1;
  for (std::size_t i = 0; i + 1 < now_points_.size(); i += every)
    if ((now_points_[i + 1] - now_points_[i]).norm() < kDense_m) before_.push_back(now_points_[i]);
  return log_odds_ < 0.0 ? -1 : 1;
}

bool counts_without_sign(std::span<const MotionSample> motion) {
  constexpr double kStanding_m_s = 0.005;
  std::size_t backward = 0, moving = 0;
  for (const MotionSample& s : motion) {
    backward += s.speed_m_s < -kStanding_m_s ? 1 : 0;
    moving += std::abs(s.speed_m_s) > kStanding_m_s ? 1 : 0;
  }
  return moving > 0 && 1000 * backward <= moving;
}

SignedMotion sign_motion(const Recording& recording, std::span<const MotionSample> motion,
                         const TravelDirectionOptions& options) {
  SignedMotion result{{motion.begin(), motion.end()}, 0};
  TravelDirection direction(options, recording.T_base_laser);
  std::size_t next = 0;
  for (const LaserScan& scan : recording.scans) {
    const std::size_t first = next;
    double distance = 0.0, turn = 0.0;
    for (; next < motion.size() && motion[next].time <= scan.time; ++next) {
      const double dt = next > 0 ? to_seconds(motion[next].time - motion[next - 1].time) : 0.0;
      distance += dt * motion[next].speed_m_s;
      turn += dt * motion[next].turn_rate_rad_s;
    }
    const int sign = direction.add(scan, distance, turn);
    for (std::size_t i = first; sign < 0 && i < next; ++i) {
      result.motion[i].speed_m_s = -motion[i].speed_m_s;
      ++result.reversed;
    }
  }
  return result;
}

}  // namespace wayfare
