#include "nav_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <wayfare/io/report.hpp>
#include <wayfare/io/text_file.hpp>

#include "degree.hpp"
#include "progress_line.hpp"

namespace wayfare::examples {
namespace {

using Cause = DriveFinding::Cause;

std::string list(const Eigen::Vector3d& v, int decimals) {
  return "[" + eval::fixed(v.x(), decimals) + ", " + eval::fixed(v.y(), decimals) + ", " +
         eval::fixed(v.z(), decimals) + "]";
}

std::string mounting_text(const SO3d& q) { return list(roll_pitch_yaw_rad(q) / kDegree, 1); }

eval::Table estimate_table(const NavConfig& config, const DriveEstimate& e) {
  eval::Table table({{""}, {"found"}, {"\u03c3"}, {"configured"}});
  const GnssInsOptions& o = config.filter;
  table.add_row(
      {"specific force, median [m/s\u00b2]", eval::fixed(e.force_size_mps2, 3), "", "9.81"});
  table.add_row({"mounting_deg", e.q_body_imu ? mounting_text(*e.q_body_imu) : "not observable",
                 e.q_body_imu ? eval::fixed(e.mounting_sigma_rad / kDegree, 1) : "",
                 mounting_text(o.q_body_imu)});
  table.add_row({"imu_time_offset_s",
                 e.imu_time_offset_s ? eval::fixed(*e.imu_time_offset_s, 3) : "not observable",
                 e.imu_time_offset_s ? eval::fixed(e.time_offset_sigma_s, 3) : "",
                 eval::fixed(o.imu_time_offset_s, 3)});
  table.add_row({"antenna_lever_arm_m",
                 e.antenna_lever_arm_m ? list(*e.antenna_lever_arm_m, 2) : "not observable",
                 e.antenna_lever_arm_m ? list(e.lever_arm_sigma_m, 2) : "",
                 list(o.antenna_lever_arm_m, 2)});
  table.add_row({"gyro_factor", list(config.gyro_factor.cwiseProduct(e.gyro_factor), 5), "",
                 list(config.gyro_factor, 5)});
  table.add_row({"accel_factor", list(config.accel_factor.cwiseProduct(e.accel_factor), 5), "",
                 list(config.accel_factor, 5)});
  return table;
}

eval::Table finding_table(const std::vector<DriveFinding>& findings) {
  eval::Table table({{"finding"}, {"what helps"}});
  for (const DriveFinding& f : findings) table.add_row({f.text, f.option});
  return table;
}

}  // namespace

bool doubtful(const DriveFinding& finding) {
  return finding.cause != Cause::no_velocity && finding.cause != Cause::at_rest;
}

std::string line_of(const DriveFinding& finding) {
  return finding.text + "; what helps: " + finding.option;
}

Doubt doubt_of(const std::vector<DriveFinding>& findings) {
  const auto first = std::find_if(findings.begin(), findings.end(), doubtful);
  if (first == findings.end()) return {};
  const auto more = std::count_if(first + 1, findings.end(), doubtful);
  return {line_of(*first) +
          (more > 0 ? " (and " + std::to_string(more) + " more: gnss_ins --check)" : "")};
}

NavConfig found_config(NavConfig config, const DriveEstimate& estimate) {
  config.filter = corrected(config.filter, estimate);
  config.gyro_factor = config.gyro_factor.cwiseProduct(estimate.gyro_factor);
  config.accel_factor = config.accel_factor.cwiseProduct(estimate.accel_factor);
  return config;
}

Result<Doubt> check_nav_recording(const OutputArguments& out, const std::string& config_path,
                                  const NavConfig& config, const io::NavRecording& recording) {
  DriveCheck check = check_drive(recording.recording, config.filter);
  ProgressLine progress("refining", out.quiet);
  refine_estimate(recording.recording, config.filter, check.estimate);
  progress.finish();
  const auto json = updated_nav_config(config_path, found_config(config, check.estimate));
  if (!json) return json.error();
  TitledTables tables = {{"The unit", estimate_table(config, check.estimate)}};
  if (!check.findings.empty()) tables.emplace_back("Findings", finding_table(check.findings));
  io::Report report("Check of a drive", config.note);
  for (const auto& [title, table] : tables) report.heading(title).table(table);
  if (auto done = first_error(
          {io::write_file(out.path("found.json"), *json, out.write()), out.write_report(report)});
      !done)
    return done.error();
  if (!out.quiet) {
    std::printf("%s", to_text({tables.front()}).c_str());
    for (const std::string& remark : recording.remarks) std::printf("note: %s\n", remark.c_str());
    for (const DriveFinding& f : check.findings) std::printf("found: %s\n", line_of(f).c_str());
    if (check.findings.empty()) std::printf("nothing speaks against the description\n");
    std::printf("description: %s\n", out.path("found.json").c_str());
  }
  return doubt_of(check.findings);
}

}  // namespace wayfare::examples
