// Attitude and heading from a recorded nine-axis unit.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/se3.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/inertial/ahrs.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/text_file.hpp>

#include "recording.hpp"
#include "support/program_files.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

/// State of the filter after a sample.
struct AhrsRow {
  LogTime time;
  bool ready = false;
  SO3d q_world_body;
  Eigen::Vector3d sigma_rad = Eigen::Vector3d::Zero();  ///< about the axes of the world
  Eigen::Vector3d bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d bias_sigma_radps = Eigen::Vector3d::Zero();
  double delay_s = 0.0;
  bool at_rest = false;
  MargUpdateStatus status;
};

struct AhrsRun {
  std::vector<AhrsRow> rows;
  AhrsReport report;
};

template <class World>
AhrsRun run_in(const MargRecording& samples, const AhrsParameters& parameters,
               ProgressLine& progress) {
  Ahrs<World> ahrs(parameters);
  AhrsRun run;
  run.rows.reserve(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const MargUpdateStatus status = ahrs.add(samples[i]);
    run.rows.push_back({samples[i].time, ahrs.ready(), ahrs.q_world_body(),
                        ahrs.world_covariance().diagonal().cwiseSqrt(), ahrs.gyro_bias_radps(),
                        ahrs.gyro_bias_sigma_radps(), ahrs.magnetometer_delay_s(), ahrs.at_rest(),
                        status});
    if (i % 4096 == 0)
      progress.update(static_cast<double>(i) / static_cast<double>(samples.size()));
  }
  run.report = ahrs.report();
  return run;
}

struct AhrsOutputs {
  std::string title;
  const io::MargFile& file;
  const AhrsRun& run;
  double took_s = 0.0;
};

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

const char* name_of(UpdateStatus status) {
  constexpr std::array kNames = {"used", "waiting", "missing", "late", "saturated", "disturbed"};
  return kNames[static_cast<std::size_t>(status)];
}

std::string csv(const AhrsRun& run) {
  std::string out =
      "t_s,roll_deg,pitch_deg,yaw_deg,qw,qx,qy,qz,sigma_x_deg,sigma_y_deg,sigma_z_deg,"
      "bias_x_degps,bias_y_degps,bias_z_degps,bias_sigma_x_degps,bias_sigma_y_degps,"
      "bias_sigma_z_degps,magnetometer_delay_s,at_rest,gyro,accelerometer,magnetometer\n";
  const auto append = [&](auto&& numbers, int decimals) {
    for (const double v : numbers) out += ',' + eval::fixed(v, decimals);
  };
  for (const AhrsRow& row : run.rows) {
    if (!row.ready) continue;
    const auto& q = row.q_world_body.quaternion();
    out += io::format_nanoseconds(row.time.nanoseconds());
    append(Eigen::Vector3d(kDegrees * roll_pitch_yaw_rad(row.q_world_body)), 5);
    append(std::array{q.w(), q.x(), q.y(), q.z()}, 9);
    append(Eigen::Vector3d(kDegrees * row.sigma_rad), 4);
    append(Eigen::Vector3d(kDegrees * row.bias_radps), 6);
    append(Eigen::Vector3d(kDegrees * row.bias_sigma_radps), 6);
    append(std::array{row.delay_s}, 5);
    out += row.at_rest ? ",1" : ",0";
    for (const UpdateStatus i :
         {row.status.gyro, row.status.accelerometer, row.status.magnetometer})
      (out += ',') += name_of(i);
    out += '\n';
  }
  return out;
}

double seconds_of(const AhrsRun& run, const AhrsRow& row) {
  return to_seconds(row.time - run.rows.front().time);
}

/// A curve of `value(i)` over time, with gaps while the filter is not ready.
template <class Value>
io::Series curve(const AhrsOutputs& o, std::string name, Value value,
                 io::Mark mark = io::Mark::line) {
  io::Series series{std::move(name), {}, {}, mark};
  for (std::size_t i = 0; i < o.run.rows.size(); ++i)
    series.add(seconds_of(o.run, o.run.rows[i]), o.run.rows[i].ready ? value(i) : kNone);
  return series;
}

bool has_reference(const AhrsOutputs& o) { return !o.file.reference.empty(); }

eval::AttitudeError error_at(const AhrsOutputs& o, std::size_t i) {
  return eval::attitude_error(o.run.rows[i].q_world_body, o.file.reference[i].q_world_body);
}

void plot_angles(io::Report& report, const AhrsOutputs& o) {
  constexpr std::array kNames = {"roll", "pitch", "yaw"};
  for (int axis = 0; axis < 3; ++axis) {
    io::Plot plot = io::time_plot(kNames[static_cast<std::size_t>(axis)], "angle [deg]");
    plot.series.push_back(io::broken_at_wraps(curve(o, "wayfare", [&](std::size_t i) {
      return kDegrees * roll_pitch_yaw_rad(o.run.rows[i].q_world_body)[axis];
    })));
    if (has_reference(o))
      plot.series.push_back(io::broken_at_wraps(curve(
          o, "reference",
          [&](std::size_t i) {
            const auto& r = o.file.reference[i];
            return r.known ? kDegrees * roll_pitch_yaw_rad(r.q_world_body)[axis] : kNone;
          },
          io::Mark::dashed)));
    report.plot(plot);
  }
}

void plot_errors(io::Report& report, const AhrsOutputs& o) {
  io::Plot plot = io::time_plot("error against the reference", "angle [deg]");
  const auto add = [&](const char* name, Angle eval::AttitudeError::*part) {
    plot.series.push_back(curve(o, name, [&](std::size_t i) {
      return o.file.reference[i].known ? (error_at(o, i).*part).degrees() : kNone;
    }));
  };
  add("heading", &eval::AttitudeError::heading);
  add("inclination", &eval::AttitudeError::inclination);
  report.plot(plot);
}

void plot_states(io::Report& report, const AhrsOutputs& o) {
  const auto& rows = o.run.rows;
  io::Plot sigma = io::time_plot("standard deviation of the attitude", "angle [deg]");
  sigma.series.push_back(curve(
      o, "level", [&](std::size_t i) { return kDegrees * rows[i].sigma_rad.head<2>().norm(); }));
  sigma.series.push_back(
      curve(o, "heading", [&](std::size_t i) { return kDegrees * rows[i].sigma_rad.z(); }));
  report.plot(sigma);
  io::Plot bias = io::time_plot("gyro bias", "rate [deg/s]");
  for (int axis = 0; axis < 3; ++axis)
    bias.series.push_back(curve(o, std::string(1, "xyz"[axis]), [&](std::size_t i) {
      return kDegrees * rows[i].bias_radps[axis];
    }));
  report.plot(bias);
}

void plot_field(io::Report& report, const AhrsOutputs& o) {
  if (!o.file.has_magnetometer) return;
  const auto strength = [&](bool disturbed) {
    return [&o, disturbed](std::size_t i) {
      const bool is = o.run.rows[i].status.magnetometer == UpdateStatus::disturbed;
      return is == disturbed ? o.file.samples[i].magnetic_field_uT.norm() : kNone;
    };
  };
  io::Plot field = io::time_plot("strength of the magnetic field", "field [uT]");
  field.series.push_back(curve(o, "undisturbed", strength(false)));
  field.series.push_back(curve(o, "disturbed", strength(true), io::Mark::points));
  report.plot(field);
  io::Plot delay = io::time_plot("delay of the magnetometer", "delay [ms]");
  delay.series.push_back(
      curve(o, "estimate", [&](std::size_t i) { return 1e3 * o.run.rows[i].delay_s; }));
  report.plot(delay);
}

/// Numbers of readings used, missing and refused, by sensor.
eval::Table status_table(const AhrsReport& r) {
  eval::Table table(
      {{"readings"}, {"used"}, {"waiting"}, {"missing"}, {"late"}, {"saturated"}, {"disturbed"}});
  const auto row = [&](const char* name, const SensorReport& s) {
    std::vector<std::string> cells{name};
    for (const auto n : {s.used, s.waiting, s.missing, s.late, s.saturated, s.disturbed})
      cells.push_back(std::to_string(n));
    table.add_row(std::move(cells));
  };
  row("gyro", r.gyro);
  row("accelerometer", r.accelerometer);
  row("magnetometer", r.magnetometer);
  return table;
}

/// Root mean square errors over the moving samples.
eval::Table error_table(const AhrsOutputs& o) {
  eval::AttitudeRmse rmse;
  for (std::size_t i = 0; i < o.run.rows.size(); ++i)
    if (o.run.rows[i].ready && o.file.moving[i] && o.file.reference[i].known)
      rmse.add(error_at(o, i));
  eval::Table table(
      {{"RMS error, moving"}, {"total", "deg"}, {"heading", "deg"}, {"inclination", "deg"}});
  const auto e = rmse.value();
  table.add_row({std::to_string(rmse.count()) + " samples", eval::fixed(e.total.degrees(), 2),
                 eval::fixed(e.heading.degrees(), 2), eval::fixed(e.inclination.degrees(), 2)});
  return table;
}

io::Report report_of(const AhrsOutputs& o) {
  io::Report report(o.title, "attitude and heading from gyro, accelerometer and magnetometer");
  const double recording_s = seconds_of(o.run, o.run.rows.back());
  const AhrsRow& last = o.run.rows.back();
  const AhrsReport& r = o.run.report;
  report.facts(
      {{"samples", std::to_string(o.run.rows.size())},
       {"recording", eval::fixed(recording_s, 1) + " s"},
       {"took", eval::fixed(o.took_s, 2) + " s"},
       {"heading sigma", eval::fixed(kDegrees * last.sigma_rad.z(), 1) + " deg at the end"},
       {"restarts", std::to_string(r.restarts) + " after gaps"},
       {"reinitialised", "level " + std::to_string(r.level_resets) + ", heading " +
                             std::to_string(r.heading_resets) + " times"}});
  if (has_reference(o)) report.table(error_table(o), "Root mean squares (Laidig et al. 2021)");
  report.table(status_table(r), "Use of the readings");
  plot_angles(report, o);
  if (has_reference(o)) plot_errors(report, o);
  plot_states(report, o);
  plot_field(report, o);
  return report;
}

Result<void> write_ahrs_outputs(const OutputArguments& to, const AhrsOutputs& outputs) {
  return first_error({io::write_file(to.path("attitude.csv"), csv(outputs.run), to.write()),
                      to.write_report(report_of(outputs))});
}

struct Arguments : OutputArguments {
  std::string file, calibration;
  RecordingOptions recording;
  FilterOptions filter;
};

Result<void> run(const Arguments& a) {
  if (auto ready = a.prepare({"attitude.csv", "report.html"}); !ready) return ready;
  auto file = a.recording.read(a.file);
  if (!file) return file.error();
  if (!a.calibration.empty()) {
    const auto calibration = read_calibration(a.calibration);
    if (!calibration) return calibration.error();
    for (MargSample& s : file->samples) s.magnetic_field_uT = (*calibration)(s.magnetic_field_uT);
  }
  AhrsParameters parameters = a.filter.parameters();
  parameters.use_magnetometer = parameters.use_magnetometer && file->has_magnetometer;

  ProgressLine progress("attitude", a.quiet);
  const AhrsRun run = a.filter.enu ? run_in<frame::Enu>(file->samples, parameters, progress)
                                   : run_in<frame::Ned>(file->samples, parameters, progress);
  const double took_s = progress.finish();
  const auto is_ready = [](const AhrsRow& row) { return row.ready; };
  if (std::none_of(run.rows.begin(), run.rows.end(), is_ready))
    return Error{ErrorCode::degenerate,
                 "gives no attitude: no accelerometer reading near gravity with a gyro reading at "
                 "the same time",
                 a.file};
  const AhrsOutputs outputs{"Attitude: " + std::filesystem::path(a.file).filename().string(), *file,
                            run, took_s};
  if (auto done = write_ahrs_outputs(a, outputs); !done || a.quiet) return done;
  if (has_reference(outputs)) std::fputs(error_table(outputs).to_text().c_str(), stdout);
  std::printf("%sreport: %s\n", status_table(run.report).to_text().c_str(),
              a.path("report.html").c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Estimate attitude and heading from a recorded unit with gyro, accelerometer and, "
      "optionally, magnetometer. Writes attitude.csv and report.html.");
  Arguments arguments;
  RecordingOptions::add_path(app, "FILE", arguments.file);
  add_out(app, arguments);
  app.add_file("--calibration", arguments.calibration,
               "of the magnetometer, from calibrate_magnetometer");
  add_force_and_quiet(app, arguments);
  add_json(app, arguments);
  arguments.recording.add_options(app);
  arguments.filter.add_options(app);
  app.example("unit.csv --out attitude",
              "attitude over time and a report of a recorded nine-axis unit");
  app.example("unit.csv --calibration magnetometer.json --out attitude",
              "the same with a calibrated magnetometer");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("ahrs", run(arguments));
}
