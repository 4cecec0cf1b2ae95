#include "inertial.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <wayfare/core/statistics.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/io/tum.hpp>

namespace wayfare::examples {
namespace {

using Estimates = std::vector<RadarInertialEstimate>;

Result<RadarInertialOptions> odometry_options(const InertialOptions& o) {
  RadarInertialOptions options;
  if (!o.rotation.empty()) {
    const Eigen::Quaterniond q(o.rotation[3], o.rotation[0], o.rotation[1], o.rotation[2]);
    if (!(std::abs(q.norm() - 1.0) < 0.01))
      return bad_use("--rotation is no unit quaternion: its length is not 1");
    options.q_unit_radar = SO3d(q.normalized());
  }
  if (!o.lever.empty()) options.lever_m = {o.lever[0], o.lever[1], o.lever[2]};
  return options;
}

std::vector<ImuSample> samples_of(const io::MargFile& file) {
  std::vector<ImuSample> all;
  for (const MargSample& s : file.samples)
    if (s.angular_rate_radps.allFinite() && s.specific_force_mps2.allFinite())
      all.push_back({s.time, s.angular_rate_radps, s.specific_force_mps2});
  return all;
}

double path_length(const Estimates& all) {
  double length = 0.0;
  for (std::size_t i = 1; i < all.size(); ++i)
    length += (all[i].position_m - all[i - 1].position_m).norm();
  return length;
}

/// Largest distance between both passes. The backward one begins where the other ends, at another
/// heading: it is moved there, turned about the vertical by what fits best.
struct Agreement {
  double largest_m = 0.0, mean_m = 0.0, velocity_m_s = 0.0, tilt_deg = 0.0;
};
Agreement agreement(const Estimates& there, const Estimates& back, LogTime about) {
  struct Pair {
    RadarInertialEstimate forward, backward;
  };
  std::vector<Pair> pairs;
  std::size_t k = back.size();
  for (const RadarInertialEstimate& f : there) {
    const LogTime mirrored = about + (about - f.time);
    while (k > 0 && back[k - 1].time > mirrored + Duration(20'000'000)) --k;
    if (k == 0) break;
    if (back[k - 1].time >= mirrored - Duration(20'000'000)) pairs.push_back({f, back[k - 1]});
  }
  Agreement a;
  if (pairs.size() < 2) return a;
  Eigen::Vector3d mf = Eigen::Vector3d::Zero(), mb = mf;
  const auto n = static_cast<double>(pairs.size());
  for (const Pair& p : pairs) mf += p.forward.position_m / n, mb += p.backward.position_m / n;
  double s = 0.0, c = 0.0;
  for (const Pair& p : pairs) {
    // The heading of both passes, at their own zeros.
    const SO3d turn = p.forward.q_enu_unit * p.backward.q_enu_unit.inverse();
    const Eigen::Matrix3d r = turn.matrix();
    s += r(1, 0) - r(0, 1), c += r(0, 0) + r(1, 1);
  }
  const SO3d align = SO3d::exp({0.0, 0.0, std::atan2(s, c)});
  double sum = 0.0, squares = 0.0, tilt = 0.0;
  for (const Pair& p : pairs) {
    const Eigen::Vector3d d = p.forward.position_m - mf - align * (p.backward.position_m - mb);
    a.largest_m = std::max(a.largest_m, d.norm());
    sum += d.norm() / n;
    squares += (p.forward.velocity_m_s + align * p.backward.velocity_m_s).squaredNorm() / n;
    const Eigen::Vector3d up(0.0, 0.0, 1.0);
    const double cosine =
        (p.forward.q_enu_unit.inverse() * up).dot(p.backward.q_enu_unit.inverse() * up);
    tilt += std::acos(std::clamp(cosine, -1.0, 1.0)) / n;
  }
  a.mean_m = sum, a.velocity_m_s = std::sqrt(squares), a.tilt_deg = Angle::radians(tilt).degrees();
  return a;
}

/// Estimated speed while the radar measures none.
std::pair<double, double> stillness(const Estimates& all, const std::vector<RadarVelocity>& radar) {
  std::vector<double> speeds;
  double still_s = 0.0;
  std::size_t k = 0;
  for (std::size_t i = 1; i < all.size(); ++i) {
    while (k < radar.size() && radar[k].time < all[i].time) ++k;
    const bool still = k > 0 && radar[k - 1].velocity_m_s.norm() < 0.02;
    if (!still) continue;
    speeds.push_back(all[i].velocity_m_s.norm());
    still_s += to_seconds(all[i].time - all[i - 1].time);
  }
  return {still_s, speeds.empty() ? NAN : quantile(speeds, 0.95)};
}

Facts facts_of(const InertialResult& r, const std::vector<RadarVelocity>& radar, LogTime about) {
  const Estimates &there = r.forward.estimates, &back = r.backward.estimates;
  const Agreement a = agreement(there, back, about);
  const auto [still_s, still_m_s] = stillness(there, radar);
  const Eigen::Vector3d end = there.back().position_m - there.front().position_m;
  double low = 0.0, high = 0.0;
  for (const RadarInertialEstimate& e : there)
    low = std::min(low, e.position_m.z()), high = std::max(high, e.position_m.z());
  const auto text = [](double value, const char* unit) {
    return eval::fixed(value, 3) + " " + unit;
  };
  return {{"path", text(path_length(there), "m") + ", heights over " + text(high - low, "m")},
          {"start to end", text(end.norm(), "m")},
          {"at rest", text(still_s, "s") + ", speed below " + text(still_m_s, "m/s") + " in 95 %"},
          {"backwards", "position differs by " + text(a.mean_m, "m") + ", at most " +
                            text(a.largest_m, "m") + "; velocity by " +
                            text(a.velocity_m_s, "m/s") + "; tilt by " + text(a.tilt_deg, "deg")},
          {"rejected", std::to_string(r.forward.counts.rejected) + " of " +
                           std::to_string(r.forward.counts.rejected + r.forward.counts.velocities) +
                           " velocities"}};
}

}  // namespace

void InertialOptions::add_options(CommandLine& app) {
  app.add_flag("--inertial", use,
               "also the path in space, with the attitude of the inertial unit beside the radar: "
               "path.tum");
  unit.add_options(app);
  app.add_option("--rotation", rotation,
                 "quaternion x y z w from the radar's axes to the unit's; by default they agree")
      .expected(4);
  app.add_option("--lever", lever, "position of the radar in the unit's axes, m").expected(3);
  app.add_number("--radar-delay", radar_delay_s, -1.0, 1.0,
                 "how late the radar's stamps are on the unit's clock, s");
}

Result<InertialResult> run_inertial(const InertialOptions& o, const SlamArguments& arguments,
                                    std::vector<RadarVelocity> velocities) {
  const auto options = odometry_options(o);
  if (!options) return options.error();
  const auto readings = o.unit.read(arguments.log, arguments.topics);
  if (!readings) return readings.error();
  if (!*readings)
    return Error{ErrorCode::not_found, "contains no inertial unit: give --unit", arguments.log};
  const std::vector<ImuSample> unit = samples_of((*readings)->file);
  for (RadarVelocity& v : velocities) v.time = v.time - from_seconds(o.radar_delay_s);
  InertialResult result;
  result.forward = run_radar_inertial(unit, velocities, *options);
  if (result.forward.estimates.size() < 2)
    return Error{ErrorCode::not_found,
                 "no inertial readings at the times of the radar: are they on one clock?",
                 arguments.log};
  const LogTime about = result.forward.estimates.back().time;
  result.backward = run_radar_inertial(reversed_in_time(unit, about),
                                       reversed_in_time(velocities, about), *options);
  result.facts = facts_of(result, velocities, about);
  return result;
}

Result<void> write_path(const InertialResult& result, const std::string& path,
                        const io::WriteOptions& options) {
  io::Trajectory3 poses;
  for (const RadarInertialEstimate& e : result.forward.estimates)
    poses.push_back(
        {e.time, Transform3<frame::Map, frame::Base>(SE3d(e.position_m, e.q_enu_unit))});
  return io::write_tum(path, std::span<const io::StampedPose3>(poses), options);
}

void add_plots(const InertialResult& result, io::Report& report) {
  const Estimates& all = result.forward.estimates;
  io::Plot view = io::top_view("Path from above"), height = io::time_plot("Height", "z [m]");
  io::Plot attitude = io::time_plot("Attitude", "angle [deg]");
  view.series = {{"path", {}, {}}};
  height.series = {{"height", {}, {}}};
  attitude.series = {{"roll", {}, {}}, {"pitch", {}, {}}, {"yaw", {}, {}}};
  for (const RadarInertialEstimate& e : all) {
    const double t = to_seconds(e.time - all.front().time);
    view.series[0].add(e.position_m.x(), e.position_m.y());
    height.series[0].add(t, e.position_m.z());
    const Eigen::Matrix3d r = e.q_enu_unit.matrix();
    const double angles[] = {std::atan2(r(2, 1), r(2, 2)), -std::asin(std::clamp(r(2, 0), -1., 1.)),
                             std::atan2(r(1, 0), r(0, 0))};
    for (std::size_t k = 0; k < 3; ++k)
      attitude.series[k].add(t, Angle::radians(angles[k]).degrees());
  }
  report.heading("With the inertial unit").facts(result.facts).plot(view).plot(height);
  report.plot(attitude);
}

}  // namespace wayfare::examples
