#include "nav_outputs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include <wayfare/core/se3.hpp>
#include <wayfare/core/statistics.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/io/tum.hpp>

#include "degree.hpp"

namespace wayfare::examples {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

bool in_outage(const std::vector<NavOutage>& outages, double t) {
  return std::any_of(outages.begin(), outages.end(), [&](const NavOutage& o) {
    return t > o.start_s && t < o.start_s + o.length_s;
  });
}

void position_row(eval::Table& table, const std::string& name,
                  const std::vector<double>& horizontal, const std::vector<double>& vertical) {
  const Summary h = summarise(horizontal);
  table.add_row({name, std::to_string(h.count), eval::fixed(h.rmse, 2),
                 eval::fixed(quantile(horizontal, 0.95), 2), eval::fixed(h.max, 2),
                 eval::fixed(summarise(vertical).rmse, 2)});
}

eval::Table position_table(const NavOutputs& run, const eval::NavErrors& errors,
                           const eval::PlainGnss& plain) {
  eval::Table table({{""},
                     {"epochs"},
                     {"horizontal RMSE", "m"},
                     {"95 %", "m"},
                     {"largest", "m"},
                     {"vertical RMSE", "m"}});
  std::vector<double> all_h, all_v, outside_h, outside_v, plain_h, plain_v;
  for (std::size_t i = 0; i < errors.time_s.size(); ++i) {
    all_h.push_back(errors.horizontal(i)), all_v.push_back(errors.error[2][i]);
    if (in_outage(run.outages, errors.time_s[i])) continue;
    outside_h.push_back(all_h.back()), outside_v.push_back(all_v.back());
  }
  for (const Eigen::Vector3d& e : plain.error_ned_m) {
    if (!e.allFinite()) continue;
    plain_h.push_back(e.head<2>().norm()), plain_v.push_back(e.z());
  }
  position_row(table, "filter", all_h, all_v);
  if (!run.outages.empty()) position_row(table, "filter, outside outages", outside_h, outside_v);
  if (!plain_h.empty())
    position_row(table, run.recording.recording.ranges.empty() ? "fixes" : "plain GNSS", plain_h,
                 plain_v);
  return table;
}

eval::Table axes_table(const eval::NavErrors& errors) {
  constexpr std::array kAxes = {"north [m]",
                                "east [m]",
                                "down [m]",
                                "velocity north [m/s]",
                                "velocity east [m/s]",
                                "velocity down [m/s]",
                                "roll [deg]",
                                "pitch [deg]",
                                "yaw [deg]"};
  eval::Table table({{"error"}, {"RMSE"}, {"mean"}, {"largest"}, {"within 3\u03c3", "%"}});
  for (std::size_t k = 0; k < eval::NavErrors::kCount; ++k) {
    std::vector<double> known, sizes;
    double inside = 0.0;
    for (std::size_t i = 0; i < errors.time_s.size(); ++i) {
      const double e = errors.error[k][i];
      if (!std::isfinite(e)) continue;
      known.push_back(e), sizes.push_back(std::abs(e));
      inside += std::abs(e) <= 3.0 * errors.sigma[k][i] ? 1.0 : 0.0;
    }
    if (known.empty()) continue;
    const Summary s = summarise(known);
    table.add_row({kAxes[k], eval::fixed(s.rmse, 3), eval::fixed(s.mean, 3),
                   eval::fixed(summarise(sizes).max, 3),
                   eval::fixed(100.0 * inside / static_cast<double>(known.size()), 1)});
  }
  return table;
}

const char* name_of(InnovationRecord::Kind kind) {
  constexpr std::array kNames = {
      "range [m]",  "range rate [m/s]", "position [m]", "velocity [m/s]", "sideways velocity [m/s]",
      "standstill", "phase change [m]", "wheels [m/s]"};
  static_assert(kNames.size() == InnovationRecord::kKinds);
  return kNames[static_cast<std::size_t>(kind)];
}

eval::Table innovation_table(const GnssInsResult& run) {
  struct Sums {
    double count = 0.0, accepted = 0.0, squares = 0.0, normalised = 0.0;
  };
  std::map<InnovationRecord::Kind, Sums> kinds;
  for (const InnovationRecord& r : run.innovations) {
    Sums& s = kinds[r.kind];
    s.count += 1.0;
    if (!r.accepted) continue;
    s.accepted += 1.0;
    s.squares += r.innovation * r.innovation;
    s.normalised += r.innovation * r.innovation / (r.sigma * r.sigma);
  }
  eval::Table table({{"innovations"}, {"offered"}, {"accepted", "%"}, {"RMS"}, {"RMS", "\u03c3"}});
  for (const auto& [kind, s] : kinds)
    table.add_row({name_of(kind), eval::fixed(s.count, 0),
                   eval::fixed(100.0 * s.accepted / s.count, 2),
                   eval::fixed(std::sqrt(s.squares / s.accepted), 3),
                   eval::fixed(std::sqrt(s.normalised / s.accepted), 2)});
  return table;
}

/// Of the positions and ranges, if the filter refused most of them.
Doubt refused_measurements(const GnssInsResult& run) {
  using Kind = InnovationRecord::Kind;
  Doubt doubt;
  for (const auto& [kind, what] :
       {std::pair(Kind::range, "ranges"), std::pair(Kind::position, "positions")}) {
    std::size_t all = 0, refused = 0;
    for (const InnovationRecord& r : run.innovations) {
      if (r.kind != kind) continue;
      ++all;
      refused += r.accepted ? 0 : 1;
    }
    if (2 * refused > all)
      doubt.add(std::to_string(refused) + " of " + std::to_string(all) + " " + what +
                " are refused by the filter");
  }
  return doubt;
}

eval::Table outage_errors(const NavOutputs& run, const eval::NavErrors& errors) {
  eval::Table table(
      {{"outage"}, {"satellites left"}, {"RMSE", "m"}, {"largest", "m"}, {"at the end", "m"}});
  for (const NavOutage& o : run.outages) {
    std::vector<double> within;
    for (std::size_t i = 0; i < errors.time_s.size(); ++i)
      if (in_outage({o}, errors.time_s[i])) within.push_back(errors.horizontal(i));
    const Summary s = summarise(within);
    table.add_row({eval::fixed(o.start_s, 1) + " s, " + eval::fixed(o.length_s, 1) + " s long",
                   std::to_string(o.satellites_left), eval::fixed(s.rmse, 2), eval::fixed(s.max, 2),
                   eval::fixed(within.empty() ? kNan : within.back(), 2)});
  }
  return table;
}

double travelled_m(const std::vector<GnssInsPoint>& points) {
  double length = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double dt = to_seconds(points[i].nav.time - points[i - 1].nav.time);
    length += dt * points[i].nav.velocity_ned_mps.norm();
  }
  return length;
}

Facts facts_of(const NavOutputs& run) {
  const GnssInsRecording& r = run.recording.recording;
  const double recording_s = to_seconds(r.imu.back().time - r.imu.front().time);
  Facts facts = {{"recording", eval::fixed(recording_s, 1) + " s"},
                 {"inertial samples", std::to_string(r.imu.size())}};
  if (!r.ranges.empty()) {
    double satellites = 0.0;
    for (const RangeEpoch& e : r.ranges) satellites += static_cast<double>(e.satellites.size());
    facts.emplace_back("range epochs",
                       std::to_string(r.ranges.size()) + ", " +
                           eval::fixed(satellites / static_cast<double>(r.ranges.size()), 1) +
                           " satellites on average");
  }
  if (!r.fixes.empty()) facts.emplace_back("fixes", std::to_string(r.fixes.size()));
  if (!run.run.points.empty()) {
    facts.emplace_back("started after",
                       eval::fixed(run.seconds(run.run.points.front().nav.time), 1) + " s");
    facts.emplace_back("travelled", eval::fixed(travelled_m(run.run.points), 0) + " m");
  }
  facts.emplace_back("took", eval::fixed(run.took_s, 2) + " s, " +
                                 eval::fixed(recording_s / std::max(run.took_s, 1e-9), 0) +
                                 " times real time");
  if (!run.run.notices.empty())
    facts.emplace_back("notices", std::to_string(run.run.notices.size()));
  return facts;
}

void append_fixed(std::string& out, double value, int decimals) {
  out += ' ';
  out += eval::fixed(value, decimals);
}

/// The points at the rate of trajectory.txt.
template <class Take>
void for_each_shown(const NavOutputs& run, const Take& take) {
  const double period_s = run.output_rate_hz > 0.0 ? 1.0 / run.output_rate_hz : 0.0;
  double next_s = -1e300;
  for (const GnssInsPoint& p : run.run.points) {
    const double t = run.seconds(p.nav.time);
    if (t < next_s) continue;
    if (period_s > 0.0) next_s = (std::floor(t / period_s + 1e-6) + 1.0) * period_s - 1e-6;
    take(p);
  }
}

std::string trajectory_text(const NavOutputs& run) {
  std::string out =
      "t_s lat_deg lon_deg h_m vn_mps ve_mps vd_mps roll_deg pitch_deg yaw_deg "
      "sn_m se_m sd_m svn_mps sve_mps svd_mps sx_deg sy_deg sz_deg\n";
  for_each_shown(run, [&](const GnssInsPoint& p) {
    out += io::format_nanoseconds(p.nav.time.nanoseconds());
    append_fixed(out, p.nav.position.latitude.degrees(), 10);
    append_fixed(out, p.nav.position.longitude.degrees(), 10);
    append_fixed(out, p.nav.position.height_m, 4);
    for (const double v : p.nav.velocity_ned_mps) append_fixed(out, v, 4);
    for (const double a : roll_pitch_yaw_rad(p.nav.q_nb)) append_fixed(out, a / kDegree, 4);
    for (Eigen::Index k = 0; k < 6; ++k) append_fixed(out, p.sigma[k], 4);
    for (Eigen::Index k = 6; k < 9; ++k) append_fixed(out, p.sigma[k] / kDegree, 4);
    out += '\n';
  });
  return out;
}

/// Errors of the unit and of the receiver's clock, once a second.
std::string states_text(const NavOutputs& run) {
  std::string out = "t_s";
  for (const std::string prefix : {"", "s"})
    for (const char* name :
         {"bgx_degps", "bgy_degps", "bgz_degps", "bax_mps2", "bay_mps2", "baz_mps2", "kgx", "kgy",
          "kgz", "kax", "kay", "kaz", "clock_m", "drift_mps"})
      out += " " + prefix + name;
  out += '\n';
  double next_s = -1e300;
  for (const GnssInsPoint& p : run.run.points) {
    const double t = run.seconds(p.nav.time);
    if (t < next_s) continue;
    next_s = t + 1.0 - 1e-6;
    out += io::format_nanoseconds(p.nav.time.nanoseconds());
    const auto unit = [](Eigen::Index k) { return k < 3 ? 1.0 / kDegree : 1.0; };
    for (Eigen::Index k = 0; k < 12; ++k) append_fixed(out, p.imu_errors[k] * unit(k), 6);
    append_fixed(out, p.clock_bias_m, 3);
    append_fixed(out, p.clock_drift_mps, 4);
    for (Eigen::Index k = 0; k < 14; ++k)
      append_fixed(out, p.sigma[ins_state::kGyroBias + k] * unit(k), 6);
    out += '\n';
  }
  return out;
}

/// In east-north-up axes at the first point; body forward-left-up.
io::Trajectory3 local_trajectory(const std::vector<GnssInsPoint>& points) {
  const Geodetic origin = points.front().nav.position;
  const Eigen::Matrix3d ecef_origin = rotation_ecef_ned(origin);
  const Eigen::Matrix3d enu_ned = (Eigen::Matrix3d() << 0, 1, 0, 1, 0, 0, 0, 0, -1).finished();
  const Eigen::Matrix3d frd_flu = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  io::Trajectory3 result;
  result.reserve(points.size());
  for (const GnssInsPoint& p : points) {
    const Eigen::Matrix3d origin_here = ecef_origin.transpose() * rotation_ecef_ned(p.nav.position);
    const Eigen::Matrix3d rotation = enu_ned * origin_here * p.nav.q_nb.matrix() * frd_flu;
    result.push_back(
        {p.nav.time, Transform3<frame::Map, frame::Base>(SE3d(
                         enu_ned * ned_from_geodetic(p.nav.position, origin), SO3d(rotation)))});
  }
  return result;
}

}  // namespace

NavFindings evaluate(const NavOutputs& run) {
  NavFindings f;
  f.doubt = refused_measurements(run.run);
  f.plain = eval::plain_gnss(run.recording.recording, run.recording.truth);
  f.facts = facts_of(run);
  const char* what = run.config.truth_is_true ? "Errors against the reference"
                                              : "Differences from another solution, not errors";
  if (!run.recording.truth.states.empty()) {
    f.errors = eval::nav_errors(run.run.points, run.recording.truth,
                                run.config.truth_is_antenna ? run.config.filter.antenna_lever_arm_m
                                                            : Eigen::Vector3d::Zero().eval(),
                                run.recording.recording.imu.front().time);
    f.tables.emplace_back(what, position_table(run, f.errors, f.plain));
    f.tables.emplace_back(run.recording.truth.has_attitude
                              ? "By axis"
                              : "By axis; yaw against the reference's course above 3 m/s",
                          axes_table(f.errors));
    if (!run.outages.empty()) f.tables.emplace_back("Outages", outage_errors(run, f.errors));
  }
  f.tables.emplace_back("Innovations: about 1 \u03c3 if the filter is consistent",
                        innovation_table(run.run));
  return f;
}

std::string summary(const NavOutputs& run, const NavFindings& f) {
  std::string out = to_text(f.facts, 17);
  for (const std::string& remark : run.recording.remarks) out += "note: " + remark + "\n";
  return out + to_text(f.tables);
}

std::vector<GnssFix> track_of(const NavOutputs& run) {
  std::vector<GnssFix> track;
  for_each_shown(run, [&](const GnssInsPoint& p) {
    GnssFix fix;
    fix.time = p.nav.time;
    fix.position = p.nav.position;
    fix.position_covariance_ned_m2 = p.sigma.head<3>().cast<double>().cwiseAbs2().asDiagonal();
    fix.velocity_ned_mps = p.nav.velocity_ned_mps;
    track.push_back(fix);
  });
  return track;
}

Result<void> write_nav_outputs(const OutputArguments& to, const NavOutputs& run,
                               const NavFindings& findings) {
  const io::WriteOptions options = to.write();
  return first_error(
      {io::write_file(to.path("trajectory.txt"), trajectory_text(run), options),
       io::write_tum(to.path("trajectory.tum"), local_trajectory(run.run.points), options),
       io::write_file(to.path("states.txt"), states_text(run), options),
       to.write_report(report_of(run, findings))});
}

}  // namespace wayfare::examples
