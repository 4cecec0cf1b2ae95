// Attitude errors of wayfare's filter, Madgwick's and Mahony's on recordings with a reference.

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/inertial/ahrs.hpp>

#include "ahrs/recording.hpp"
#include "support/program_files.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Arguments {
  std::vector<std::string> files;
  bool quiet = false;
  double madgwick_gain = MadgwickRule{}.gain;
  double mahony_gain = MahonyRule{}.proportional_gain;
  double mahony_integral = MahonyRule{}.integral_gain;
  RecordingOptions recording;
  FilterOptions filter;
};

/// Of wayfare, Madgwick, Mahony.
template <class World>
std::vector<eval::AttitudeError> errors_of(const io::MargFile& file, const Arguments& a) {
  const bool magnetometer = !a.filter.no_magnetometer;
  Ahrs<World> ours(a.filter.parameters());
  MadgwickAhrs<World> madgwick({a.madgwick_gain, magnetometer});
  MahonyAhrs<World> mahony({a.mahony_gain, a.mahony_integral, magnetometer});
  return {io::attitude_rmse(ours, file), io::attitude_rmse(madgwick, file),
          io::attitude_rmse(mahony, file)};
}

std::vector<std::string> row(const std::string& name, const std::vector<double>& values) {
  std::vector<std::string> cells{name};
  for (const double v : values) cells.push_back(eval::fixed(v, 2));
  return cells;
}

Result<void> run(const Arguments& a) {
  eval::Table table({{"recording"},
                     {"wayfare: total", "deg"},
                     {"heading"},
                     {"inclination"},
                     {"Madgwick: total", "deg"},
                     {"heading"},
                     {"inclination"},
                     {"Mahony: total", "deg"},
                     {"heading"},
                     {"inclination"}});
  std::vector<double> sums(9, 0.0);
  ProgressLine progress("attitude", a.quiet);
  for (std::size_t i = 0; i < a.files.size(); ++i) {
    const auto file = a.recording.read(a.files[i]);
    if (!file) return file.error();
    if (file->reference.empty())
      return Error{ErrorCode::not_found, "has no reference (columns qw qx qy qz)", a.files[i]};
    const auto errors =
        a.filter.enu ? errors_of<frame::Enu>(*file, a) : errors_of<frame::Ned>(*file, a);
    std::vector<double> values;
    for (const auto& e : errors)
      for (const Angle angle : {e.total, e.heading, e.inclination})
        values.push_back(angle.degrees());
    for (std::size_t k = 0; k < values.size(); ++k) sums[k] += values[k];
    const auto name = std::filesystem::path(a.files[i]).filename().string();
    table.add_row(row(name.substr(0, name.find('.')), values));
    progress.update(static_cast<double>(i + 1) / static_cast<double>(a.files.size()));
  }
  progress.finish();
  for (double& sum : sums) sum /= static_cast<double>(a.files.size());
  table.add_row(row("mean", sums));
  std::printf("%s", table.to_text().c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Print the attitude errors of wayfare's filter, Madgwick's and Mahony's on nine-axis "
      "recordings with a reference: root mean squares over the moving samples, as Laidig et al. "
      "2021 define them.");
  Arguments arguments;
  RecordingOptions::add_path(app, "FILES", arguments.files);
  app.add_flag("--quiet", arguments.quiet, kQuietHelp);
  app.add_option("--madgwick", arguments.madgwick_gain, "Madgwick's beta").show_default();
  app.add_option("--mahony", arguments.mahony_gain, "Mahony's proportional gain").show_default();
  app.add_option("--mahony-integral", arguments.mahony_integral, "Mahony's integral gain")
      .show_default();
  arguments.recording.add_options(app);
  arguments.filter.add_options(app);
  app.example("unit1.csv unit2.csv", "one row for each recording");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("attitude_table", run(arguments));
}
