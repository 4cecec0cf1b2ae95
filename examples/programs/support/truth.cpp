#include "truth.hpp"

#include <algorithm>
#include <cstdio>

#include <wayfare/io/tum.hpp>

namespace wayfare::examples {
namespace {

Result<Truth> from_text(const std::string& path) {
  auto file = io::read_poses(path);
  if (!file) return file.error();
  // A part of the truth would give errors of a part of the run.
  if (!file->problems.empty()) return file->problems.first().front();
  Truth truth(std::move(file->trajectory), path, file->has_heading);
  truth.heights_m = std::move(file->heights_m);
  return truth;
}

Result<Truth> from_recording(const std::string& path, const ros::TopicNames& topics) {
  const auto file = ros::RecordingFile::open(path);
  if (!file) return file.error();
  auto run = ros::read_truth(*file, topics);
  if (!run) return run.error();
  print_problems(run->problems);
  if (run->truth.empty())
    return Error{ErrorCode::not_found,
                 "contains no true poses on /truth: --truth-topic or --truth-frames names them",
                 path};
  return Truth(std::move(run->truth), path);
}

Result<void> check(const Truth& truth, std::span<const LogTime> times) {
  auto ok = eval::check(truth);
  if (ok) ok = eval::check_overlap(truth, times);
  if (ok) return ok;
  Error error = ok.error();
  error.source = truth.source;
  return error;
}

}  // namespace

void TruthOptions::add_options(CommandLine& app, const std::string& names) {
  app.add_file(
      names, file,
      "true poses on the clock of the log, to compare with, in any frame: TUM text, columns "
      "of text (t_s, x_m, y_m and heading_deg or qx, qy, qz, qw) or a ROS recording; by "
      "default those in the log");
}

Result<Truth> TruthOptions::read(const std::string& log, Trajectory own,
                                 std::span<const LogTime> times,
                                 const ros::TopicNames& topics) const {
  if (!file.empty()) {
    auto truth = ros::RecordingFile::is_one(file) ? from_recording(file, topics) : from_text(file);
    if (!truth) return truth;
    if (auto ok = check(*truth, times); !ok) return ok.error();
    return truth;
  }
  Truth truth(std::move(own), log);
  if (!truth.known()) return truth;
  if (const auto ok = check(truth, times); !ok) {
    std::fprintf(stderr, "the true poses in the log are not used: %s\n",
                 ok.error().to_string().c_str());
    truth.poses.clear();
  }
  return truth;
}

std::vector<LogTime> times_of(const Recording& recording) {
  std::vector<LogTime> times;
  for (const LaserScan& scan : recording.scans) times.push_back(scan.time);
  for (const RadarScan& scan : recording.radar) times.push_back(scan.time);
  if (times.empty())
    for (const OdometrySample& sample : recording.odometry) times.push_back(sample.time);
  std::sort(times.begin(), times.end());
  return times;
}

std::vector<eval::Evaluated> compare(const Truth& truth, const std::vector<NamedTrajectory>& all) {
  std::vector<eval::Evaluated> result;
  if (!truth.known()) return result;
  for (const auto& [name, poses] : all) result.push_back({name, eval::evaluate(poses, truth)});
  return result;
}

TitledTables error_tables(const Truth& truth, std::span<const eval::Evaluated> all,
                          bool same_frame) {
  if (all.empty()) return {};
  return {{"Errors against the truth of " + truth.source, eval::error_table(all, same_frame)},
          {"Rigid alignment to the truth", eval::alignment_table(all)}};
}

void add_errors(io::Report& report, const TitledTables& tables) {
  for (const auto& [title, table] : tables) report.heading(title).table(table);
}

io::Series truth_series(const Truth& truth, const eval::Evaluation& errors) {
  return io::path_series("truth", truth.poses, errors.rigid.alignment.inverse(), io::Mark::dashed);
}

void draw_truth(io::MapPainter& painter, const Truth& truth, const eval::Evaluation& errors) {
  const io::Series path = truth_series(truth, errors);
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < path.x.size(); ++i) points.emplace_back(path.x[i], path.y[i]);
  constexpr int kWide = 4;  // seen below the path
  painter.path(points, io::kGreen);
  for (const Eigen::Vector2d& p : points) painter.dot(p, io::kGreen, kWide);
}

namespace {

using Aligned = eval::AbsoluteError eval::Evaluation::*;

io::Plot distance_plot(const std::string& title, std::span<const eval::Evaluated> all,
                       Aligned aligned) {
  LogTime start = LogTime() + Duration::max();
  for (const auto& [name, errors] : all)
    for (const LogTime time : (errors.*aligned).times) start = std::min(start, time);
  io::Plot plot = io::time_plot(title, "error [m]");
  for (const auto& [name, errors] : all) {
    const eval::AbsoluteError& e = errors.*aligned;
    io::Series series{name, {}, e.translations_m};
    for (const LogTime time : e.times) series.x.push_back(to_seconds(time - start));
    plot.series.push_back(std::move(series));
  }
  return plot;
}

}  // namespace

std::vector<io::Plot> distance_plots(const Truth& truth, std::span<const eval::Evaluated> all) {
  std::vector<io::Plot> plots;
  if (all.empty()) return plots;
  if (truth.has_heading)
    plots.push_back(distance_plot("Distance from the truth, started at the same pose", all,
                                  &eval::Evaluation::start));
  plots.push_back(distance_plot("Distance from the truth after rigid alignment", all,
                                &eval::Evaluation::rigid));
  return plots;
}

}  // namespace wayfare::examples
