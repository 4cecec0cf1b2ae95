// How an inertial unit errs, from a long record of it at rest: the parameters a filter starts from.

#include <cstdio>
#include <filesystem>
#include <string>

#include <wayfare/eval/table.hpp>

#include "findings.hpp"
#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/nav_config.hpp"
#include "support/program_files.hpp"
#include "support/ros_topics.hpp"

namespace {

using namespace wayfare;

struct Options {
  std::string file, out, config;
  examples::RecordFormat format;
  bool force = false;
};

constexpr const char* kParameters = "parameters.json";
constexpr const char* kReport = "report.html";

Result<void> write(const Options& o, const examples::RestRecord& record,
                   const examples::UnitFit& fit, const io::WriteOptions& writing) {
  const auto path = [&o](const char* name) {
    return (std::filesystem::path(o.out) / name).string();
  };
  examples::NavConfig config;
  if (!o.config.empty()) {
    auto read = examples::read_nav_config(o.config);
    if (!read) return read.error();
    config = *std::move(read);
  }
  config.note = "imu_noise from " + o.file + " at rest; scale factors are not seen there";
  config.filter.imu = examples::nominal_noise(fit);
  if (auto done = io::write_file(path(kParameters), examples::format_nav_config(config), writing);
      !done)
    return done;
  io::Report report("Noise of an inertial unit at rest",
                    o.file + ": " + std::to_string(record.readings) + " readings, " +
                        eval::fixed(record.rate_hz, 1) + " a second, " +
                        eval::fixed(record.length_s() / 3600.0, 2) + " h");
  report.table(examples::allan_table(fit), "Parts of the Allan variance and where they prevail");
  report.table(examples::gauss_markov_table(fit), "Slow errors by their autocorrelation");
  for (const std::string& remark : examples::remarks(fit)) report.paragraph(remark);
  for (const io::Plot& plot : examples::allan_plots(fit)) report.plot(plot);
  if (auto done = report.write(path(kReport), writing); !done) return done;
  std::printf("parameters: %s\nreport: %s\n", path(kParameters).c_str(), path(kReport).c_str());
  return {};
}

Result<void> run(const Options& o) {
  const io::WriteOptions writing{o.force ? io::Existing::replace : io::Existing::refuse};
  if (!o.out.empty()) {
    if (auto ready = examples::prepare_files(o.out, {kParameters, kReport}, writing); !ready)
      return ready;
  }
  const auto record = examples::read_rest_record(o.file, o.format);
  if (!record) return record.error();
  const examples::UnitFit fit = examples::fit_unit(*record);
  std::printf("%s: %zu readings, %.3f a second, %.2f h\n\n%s\n%s\n", o.file.c_str(),
              record->readings, record->rate_hz, record->length_s() / 3600.0,
              examples::allan_table(fit).to_text().c_str(),
              examples::gauss_markov_table(fit).to_text().c_str());
  for (const std::string& remark : examples::remarks(fit)) std::printf("%s\n", remark.c_str());
  return o.out.empty() ? Result<void>{} : write(o, *record, fit, writing);
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Find how an inertial unit errs from a long record of it at rest: Allan deviation and "
      "Gauss-Markov\nfits, axis by axis. With --out a report with the curves, and parameters.json "
      "for gnss_ins --config.");
  Options o;
  app.add_option("FILE", o.file,
                 "columns of text, a float table, or raw float32, gzip or not; or a ROS recording "
                 "(ROS 2's .mcap, ROS 1's .bag)")
      .required()
      .existing_file();
  app.add_option("--rate", o.format.rate_hz, "readings a second; 0: by the file's times")
      .range(0.0, 1e6)
      .show_default();
  app.add_flag("--raw", o.format.raw,
               "rows of six float32: gx gy gz in degrees a second, ax ay az in g");
  examples::add_imu_topic(app, o.format.topics);
  app.add_option("--out", o.out, "folder for the results, made where needed");
  app.add_option("--config", o.config, "mounting and filter options for parameters.json")
      .existing_file();
  app.add_flag("--force", o.force, "replace files of an earlier run");
  if (const auto code = app.parse(argc, argv)) return *code;
  return examples::exit_code("allan", run(o));
}
