// Calibration of a robot's wheels, mountings and clocks from one recorded drive.

#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/io/carmen.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/slam/robot_calibration.hpp>

#include "support/chirp_config.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : SlamArguments {
  std::string chirps, corrected;
  RobotCalibrationOptions calibration;
};

/// In degrees and milliseconds; metres and ratios as they are.
struct Shown {
  double factor;
  std::string unit;
  int decimals;
};
Shown shown(const CalibratedParameter& p) {
  if (p.unit == "rad") return {Angle::radians(1.0).degrees(), "deg", 2};
  if (p.unit == "rad/s") return {Angle::radians(1.0).degrees(), "deg/s", 3};
  if (p.unit == "s") return {1e3, "ms", 1};
  return {1.0, p.unit, 4};
}

eval::Table table_of(const RobotCalibration& c) {
  eval::Table table({{"parameter"}, {"unit"}, {"given"}, {"calibrated"}, {"sigma"}, {"result"}});
  for (const CalibratedParameter& p : c.parameters) {
    const Shown s = shown(p);
    const auto text = [&](double value) { return eval::fixed(s.factor * value, s.decimals); };
    table.add_row({p.name, s.unit, text(p.given), p.determined ? text(p.value) : "–",
                   std::isfinite(p.sigma) ? text(p.sigma) : "–",
                   p.determined ? "determined" : "not determined by this drive"});
  }
  return table;
}

/// Correlation of all parameters that are determined.
eval::Table correlations_of(const RobotCalibration& c) {
  std::vector<eval::Table::Column> columns{{"correlation"}};
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < c.parameters.size(); ++i) {
    if (!c.parameters[i].determined) continue;
    columns.push_back({c.parameters[i].name});
    rows.push_back(static_cast<Eigen::Index>(i));
  }
  eval::Table table(columns);
  for (const Eigen::Index i : rows) {
    std::vector<std::string> cells{c.parameters[static_cast<std::size_t>(i)].name};
    for (const Eigen::Index k : rows)
      cells.push_back(
          eval::fixed(c.covariance(i, k) / std::sqrt(c.covariance(i, i) * c.covariance(k, k)), 2));
    table.add_row(cells);
  }
  return table;
}

Facts facts_of(const RobotCalibration& c) {
  Facts facts;
  for (const CalibratedSensor& s : c.sensors)
    facts.emplace_back(s.name, std::to_string(s.measurements) + " measurements, " +
                                   std::to_string(s.outliers) + " outliers, noise " +
                                   eval::fixed(s.noise, 2) + " of what is expected");
  for (const std::string& note : c.notes) facts.emplace_back("note", note);
  return facts;
}

std::string joined(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) (all += all.empty() ? "" : ", ") += name;
  return all;
}

Result<Doubt> run(Options o) {
  Facts radar;
  if (!o.chirps.empty()) {
    const auto chirps = read_chirps(o.chirps);
    if (!chirps) return chirps.error();
    apply(*chirps, o.calibration.velocity);
    for (const auto& [name, text] : facts_of(*chirps)) radar.emplace_back("radar " + name, text);
  }
  if (auto ready = o.prepare({"report.html"}); !ready) return ready.error();
  if (auto ready = check_writable({o.corrected}, o.write()); !ready) return ready.error();
  Doubt doubt;
  const auto recording = read_robot_log(o.log, o.topics, false, &doubt);
  if (!recording) return recording.error();
  const auto found = run_timed("calibration", o.quiet, [&](ProgressLine& progress) {
    return calibrate_robot(*recording, o.calibration, std::ref(progress));
  });
  if (!found) return Error{found.error().code, found.error().message, o.log};
  const RobotCalibration& c = found->slam;
  const auto open = c.undetermined();
  if (!open.empty()) doubt.add("this drive does not determine " + joined(open));
  Facts facts = facts_of(c);
  facts.insert(facts.end(), radar.begin(), radar.end());
  io::Report report("Calibration of a robot", o.log);
  report.doubt(doubt.why).facts(facts).table(table_of(c), "Parameters");
  report.table(correlations_of(c), "Correlations");
  const auto corrected = o.corrected.empty()
                             ? Result<void>{}
                             : io::write_carmen(o.corrected, c.applied_to(*recording), o.write());
  if (auto done = first_error({corrected, o.write_report(report)}); !done) return done.error();
  if (!o.quiet)
    std::printf("%s%s\nreport: %s\n", to_text(facts).c_str(), table_of(c).to_text().c_str(),
                o.path("report.html").c_str());
  return doubt;
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Calibrate a robot on two driven wheels from one drive: sizes and base of the wheels, "
      "mountings and delays of LiDAR and radar, and the gyro.\nLOG is " +
      std::string(kRobotLogs) +
      "; its mountings and wheel base are what is given. Writes report.html. What the drive does "
      "not determine is named, and the exit code is 3. Drive curves to both sides, turns on the "
      "spot and straight parts, with starts and stops, for two minutes.");
  Options o;
  app.add_file("LOG", o.log, "the recorded drive").required();
  add_out(app, o);
  add_chirps(app, o.chirps);
  app.add_option("--corrected", o.corrected,
                 "also write the log with the calibration applied, as CARMEN text")
      .shown_as("FILE");
  add_robot_topics(app, o.topics);
  add_force_and_quiet(app, o);
  add_json(app, o);
  app.example("drive.log --out calibration", "all sensors of a log");
  app.example("drive.log --chirps radar.cfg --corrected calibrated.log --out calibration",
              "with the radar's configuration, and a log for the other programs");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("calibrate_robot", run(o));
}
