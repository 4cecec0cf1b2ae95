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

Result<void> run(const Arguments& a) {
  if (auto ok = refuse_existing({a.out}, a.write()); !ok) return ok;
  const auto file = a.recording.read(a.file);
  if (!file) return file.error();
  if (!file->has_magnetometer)
    return Error{ErrorCode::not_found, "has no magnetometer columns", a.file};
  std::vector<Eigen::Vector3d> readings;
  for (const MargSample& s : file->samples) readings.push_back(s.magnetic_field_uT);
  const auto calibration = calibrate_magnetometer(readings, a.options);
  if (!calibration) return Error{calibration.error().code, calibration.error().message, a.file};
  print(*calibration);
  if (a.out.empty()) return {};
  return write_calibration(a.out, *calibration, a.write());
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Calibrate a magnetometer from a recording in all orientations: calibrated = correction (raw "
      "- offset). Values are printed with their standard deviations.");
  Arguments arguments;
  RecordingOptions::add_path(app, "FILE", arguments.file);
  app.add_option("--out", arguments.out, "JSON file for the calibration, for ahrs --calibration");
  app.add_flag("--force", arguments.force, "replace an existing file");
  app.add_option("--field", arguments.options.field_uT,
                 "strength of the local magnetic field, uT (default: keep the mean strength)")
      .positive();
  arguments.recording.add_options(app);
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("calibrate_magnetometer", run(arguments));
}
