// Noise of an inertial unit from a long recording at rest: nominal parameters of a filter.

#include <cstdio>
#include <string>

#include "findings.hpp"
#include "support/nav_config.hpp"
#include "support/program_files.hpp"
#include "support/ros_topics.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : OutputArguments {
  std::string file, config;
  RecordFormat format;
};

constexpr const char* kParameters = "parameters.json";
constexpr const char* kReport = "report.html";

Result<void> write(const Options& o, const RestRecord& record, const UnitFit& fit) {
  auto config = read_nav_config(o.config);
  if (!config) return config.error();
  config->note = "imu_noise from " + o.file + " at rest; scale factors are not observable at rest";
  config->filter.imu = nominal_noise(fit);
  io::Report report("Noise of an inertial unit at rest",
                    o.file + ": " + std::to_string(record.readings) + " samples, " +
                        eval::fixed(record.rate_hz, 1) + " per second, " +
                        eval::fixed(record.length_s() / 3600.0, 2) + " h");
  report.table(allan_table(fit),
               "Components of the Allan variance and the times where they dominate");
  report.table(gauss_markov_table(fit), "Slow errors from the autocorrelation");
  for (const std::string& remark : remarks(fit)) report.paragraph(remark);
  for (const io::Plot& plot : allan_plots(fit)) report.plot(plot);
  const auto done =
      first_error({io::write_file(o.path(kParameters), format_nav_config(*config), o.write()),
                   report.write(o.path(kReport), o.write())});
  if (done)
    std::printf("parameters: %s\nreport: %s\n", o.path(kParameters).c_str(),
                o.path(kReport).c_str());
  return done;
}

Result<void> run(const Options& o) {
  if (!o.out.empty())
    if (auto ready = o.prepare({kParameters, kReport}); !ready) return ready;
  const auto record = read_rest_record(o.file, o.format);
  if (!record) return record.error();
  const UnitFit fit = fit_unit(*record);
  std::printf("%s: %zu readings, %.3f per second, %.2f h\n\n%s\n%s\n", o.file.c_str(),
              record->readings, record->rate_hz, record->length_s() / 3600.0,
              allan_table(fit).to_text().c_str(), gauss_markov_table(fit).to_text().c_str());
  for (const std::string& remark : remarks(fit)) std::printf("%s\n", remark.c_str());
  return o.out.empty() ? Result<void>{} : write(o, *record, fit);
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Noise of an inertial unit from a long recording at rest: Allan deviation and Gauss-Markov\n"
      "fits for each axis. With --out a report with the curves, and parameters.json for gnss_ins "
      "--config.");
  Options o;
  app.add_option("FILE", o.file,
                 "columns of text, a float table, or raw float32, gzip or not; or a ROS recording "
                 "(ROS 2's .mcap, ROS 1's .bag)")
      .required()
      .existing_file();
  app.add_option("--rate", o.format.rate_hz, "samples per second; 0: from the times in the file")
      .range(0.0, 1e6)
      .show_default();
  app.add_flag("--raw", o.format.raw, "rows of six float32: gx gy gz in deg/s, ax ay az in g");
  add_imu_topic(app, o.format.topics);
  app.add_option("--out", o.out, "folder for the results, created if needed");
  app.add_option("--config", o.config, "mounting and filter options for parameters.json")
      .existing_file();
  app.add_flag("--force", o.force, "replace existing files");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("allan", run(o));
}
