// Hard and soft iron of a magnetometer from a recording in all orientations.

#include <cstdio>
#include <string>
#include <vector>

#include <wayfare/inertial/magnetometer_calibration.hpp>

#include "recording.hpp"
#include "support/program_files.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Arguments : OutputArguments {
  std::string file;
  RecordingOptions recording;
  MagnetometerCalibrationOptions options;
};

void print(const MagnetometerCalibration& c) {
  const auto row = [](const char* name, const Eigen::Vector3d& v, const Eigen::Vector3d& sigma) {
    std::printf("%-14s", name);
    for (int i = 0; i < 3; ++i) std::printf("  %9.4f +- %.4f", v[i], sigma[i]);
    std::printf("\n");
  };
  row("offset [uT]", c.offset_uT, c.offset_sigma_uT);
  row("correction", c.correction.row(0), c.correction_sigma.row(0));
  row("", c.correction.row(1), c.correction_sigma.row(1));
  row("", c.correction.row(2), c.correction_sigma.row(2));
  std::printf("%-14s  %9.4f uT\n", "field", c.field_uT);
  std::printf("%-14s  %9.4f uT, %.4f before\n", "residual", c.residual_uT, c.raw_residual_uT);
  std::printf("%-14s  %9zu\n", "readings used", c.used);
}

io::Report report_of(const MagnetometerCalibration& c, const std::string& file) {
  eval::Table table({{""}, {"x"}, {"y"}, {"z"}});
  const auto row = [&](const char* name, const Eigen::Vector3d& v, const Eigen::Vector3d& sigma) {
    std::vector<std::string> cells{name};
    for (int i = 0; i < 3; ++i) cells.push_back(eval::mean_std(v[i], sigma[i], 6));
    table.add_row(std::move(cells));
  };
  row("offset [uT]", c.offset_uT, c.offset_sigma_uT);
  for (int i = 0; i < 3; ++i) row("correction", c.correction.row(i), c.correction_sigma.row(i));
  io::Report report("Calibration of the magnetometer of " + file);
  report.table(table, "Values and their standard deviations")
      .facts({{"field", eval::fixed(c.field_uT, 4) + " uT"},
              {"residual", eval::fixed(c.residual_uT, 4) + " uT"},
              {"residual before", eval::fixed(c.raw_residual_uT, 4) + " uT"},
              {"readings used", std::to_string(c.used)}});
  return report;
}

Result<void> run(const Arguments& a) {
  if (auto ok = check_writable({a.out}, a.write()); !ok) return ok;
  if (auto ok = a.prepare_json(); !ok) return ok;
  const auto file = a.recording.read(a.file);
  if (!file) return file.error();
  if (!file->has_magnetometer)
    return Error{ErrorCode::not_found, "has no magnetometer columns", a.file};
  std::vector<Eigen::Vector3d> readings;
  for (const MargSample& s : file->samples) readings.push_back(s.magnetic_field_uT);
  const auto calibration = calibrate_magnetometer(readings, a.options);
  if (!calibration) return Error{calibration.error().code, calibration.error().message, a.file};
  if (!a.quiet) print(*calibration);
  if (auto done = a.write_json(report_of(*calibration, a.file)); !done || a.out.empty())
    return done;
  return write_calibration(a.out, *calibration, a.write());
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Calibrate a magnetometer from a recording in all orientations: calibrated = correction (raw "
      "- offset). Values are printed with their standard deviations.");
  Arguments arguments;
  RecordingOptions::add_path(app, "FILE", arguments.file);
  app.add_option("--out", arguments.out, "JSON file for the calibration, for ahrs --calibration")
      .shown_as("FILE");
  add_force_and_quiet(app, arguments);
  add_json(app, arguments);
  app.add_option("--field", arguments.options.field_uT,
                 "strength of the local magnetic field, uT (default: keep the mean strength)")
      .positive();
  arguments.recording.add_options(app);
  app.example("turned.csv --out magnetometer.json",
              "calibration of a unit that was turned through all orientations");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("calibrate_magnetometer", run(arguments));
}
