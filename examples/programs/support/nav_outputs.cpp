#include "nav_outputs.hpp"

#include <cmath>
#include <numbers>

#include <wayfare/core/so3.hpp>
#include <wayfare/io/time_text.hpp>
#include <wayfare/io/tum.hpp>

namespace wayfare::examples {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

void append_fixed(std::string& out, double value, int decimals) {
  out += ' ';
  out += eval::fixed(value, decimals);
}

std::string trajectory_text(const NavOutputs& run) {
  std::string out =
      "t_s lat_deg lon_deg h_m vn_mps ve_mps vd_mps roll_deg pitch_deg yaw_deg "
      "sn_m se_m sd_m svn_mps sve_mps svd_mps sx_deg sy_deg sz_deg\n";
  const double period_s = run.output_rate_hz > 0.0 ? 1.0 / run.output_rate_hz : 0.0;
  double next_s = -1e300;
  for (const GnssInsPoint& p : run.run.points) {
    const double t = run.seconds(p.nav.time);
    if (t < next_s) continue;
    if (period_s > 0.0) next_s = (std::floor(t / period_s + 1e-6) + 1.0) * period_s - 1e-6;
    out += io::format_nanoseconds(p.nav.time.nanoseconds());
    append_fixed(out, p.nav.position.latitude.degrees(), 10);
    append_fixed(out, p.nav.position.longitude.degrees(), 10);
    append_fixed(out, p.nav.position.height_m, 4);
    for (const double v : p.nav.velocity_ned_mps) append_fixed(out, v, 4);
    for (const double a : roll_pitch_yaw_rad(p.nav.q_nb)) append_fixed(out, a / kDegree, 4);
    for (Eigen::Index k = 0; k < 6; ++k) append_fixed(out, p.sigma[k], 4);
    for (Eigen::Index k = 6; k < 9; ++k) append_fixed(out, p.sigma[k] / kDegree, 4);
    out += '\n';
  }
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

std::vector<std::string> nav_output_names() {
  return {"trajectory.txt", "trajectory.tum", "states.txt", "report.html"};
}

Result<void> write_nav_outputs(const OutputArguments& to, const NavOutputs& run,
                               const NavFindings& findings) {
  const io::WriteOptions options = to.write();
  return first_error(
      {io::write_file(to.path("trajectory.txt"), trajectory_text(run), options),
       io::write_tum(to.path("trajectory.tum"), local_trajectory(run.run.points), options),
       io::write_file(to.path("states.txt"), states_text(run), options),
       report_of(run, findings).write(to.path("report.html"), options)});
}

}  // namespace wayfare::examples
