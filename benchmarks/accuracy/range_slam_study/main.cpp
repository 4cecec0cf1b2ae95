// Range-only SLAM on recordings with the truth: errors of the path and of the beacons.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <matio.h>

#include <wayfare/eval/table.hpp>
#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/text_file.hpp>

#include "range_run.hpp"
#include "support/command_line.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Arguments {
  std::string odometry, ranges, truth;
  RangeNoise noise;
};

struct Truth {
  std::vector<Eigen::Vector2d> path;     // of each pose
  std::vector<Eigen::Vector2d> beacons;  // in the order of the recording's
};

/// A matrix of a MATLAB file.
Result<Eigen::MatrixXd> read_matrix(mat_t& file, const char* name, const std::string& path) {
  const std::unique_ptr<matvar_t, decltype(&Mat_VarFree)> variable(Mat_VarRead(&file, name),
                                                                   Mat_VarFree);
  if (!variable || variable->class_type != MAT_C_DOUBLE || variable->rank != 2)
    return Error{ErrorCode::parse, "has no matrix " + std::string(name), path};
  return Eigen::MatrixXd(Eigen::Map<const Eigen::MatrixXd>(
      static_cast<const double*>(variable->data), static_cast<Eigen::Index>(variable->dims[0]),
      static_cast<Eigen::Index>(variable->dims[1])));
}

/// GT: time, x, y, heading of every pose; TL: number, x, y of every beacon.
Result<Truth> read_truth(const std::string& path, const RangeRun& run) {
  const auto content = io::read_file(path);  // libmatio reads files, and no gzip
  if (!content) return content.error();
  const auto copy = std::filesystem::temp_directory_path() / "wayfare_range_slam_study.mat";
  if (auto done = io::write_file(copy, content->bytes, {io::Existing::replace}); !done)
    return done.error();
  const std::unique_ptr<mat_t, decltype(&Mat_Close)> file(Mat_Open(copy.c_str(), MAT_ACC_RDONLY),
                                                          Mat_Close);
  std::filesystem::remove(copy);
  if (!file) return Error{ErrorCode::parse, "not a MATLAB file", path};
  const auto gt = read_matrix(*file, "GT", path), tl = read_matrix(*file, "TL", path);
  if (!gt) return gt.error();
  if (!tl) return tl.error();
  if (gt->cols() < 3 || tl->cols() < 3 || std::cmp_not_equal(gt->rows(), run.steps.size() + 1))
    return Error{ErrorCode::invalid, "does not have a position for every pose", path};
  Truth truth;
  for (Eigen::Index i = 0; i < gt->rows(); ++i) truth.path.emplace_back((*gt)(i, 1), (*gt)(i, 2));
  for (const int beacon : run.beacons) {
    Eigen::Index row = 0;
    while (row < tl->rows() && (*tl)(row, 0) != beacon) ++row;
    if (row == tl->rows())
      return Error{ErrorCode::invalid, "does not have beacon " + std::to_string(beacon), path};
    truth.beacons.emplace_back((*tl)(row, 1), (*tl)(row, 2));
  }
  return truth;
}

/// Root mean square and largest distance after rigid alignment; then those of the beacons.
std::vector<std::string> errors(const char* name, const RangeGraph& graph, const Truth& truth) {
  std::vector<Eigen::Vector2d> path;
  for (const SE2d& pose : graph.all<SE2d>()) path.push_back(pose.translation());
  const SE2d alignment = eval::rigid_alignment(path, truth.path);
  double sum = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double e = (alignment * path[i] - truth.path[i]).norm();
    sum += e * e;
    largest = std::max(largest, e);
  }
  std::vector<std::string> row{name,
                               eval::fixed(std::sqrt(sum / static_cast<double>(path.size())), 2),
                               eval::fixed(largest, 2)};
  const auto& beacons = graph.all<Eigen::Vector2d>();
  for (std::size_t k = 0; k < beacons.size(); ++k)
    row.push_back(eval::fixed((alignment * beacons[k] - truth.beacons[k]).norm(), 2));
  return row;
}

void print_residuals(const RangeGraph& graph) {
  double odometry = 0.0, ranges = 0.0, robust = 0.0;
  int outliers = 0, count = 0;
  graph.each_edge([&]<class E>(const E& edge, const auto&, const auto&... x) {
    const double s = squared_error(edge, x...);
    if constexpr (std::is_same_v<E, Between<SE2d>>) {
      odometry += s;
    } else {
      ++count;
      ranges += s;
      robust += robust_value(edge, s).cost;
      outliers += s > 9.0 ? 1 : 0;
    }
  });
  std::printf(
      "squared errors of odometry %.1f, of %d ranges %.1f (robust %.1f), %d ranges beyond three "
      "standard deviations\n",
      odometry, count, ranges, robust, outliers);
}

Result<void> run(const Arguments& a) {
  const auto recording = read_range_run(a.odometry, a.ranges);
  if (!recording) return recording.error();
  const auto truth = read_truth(a.truth, *recording);
  if (!truth) return truth.error();
  std::vector<eval::Table::Column> columns{{"path"}, {"RMS", "m"}, {"max", "m"}};
  for (const int beacon : recording->beacons)
    columns.push_back({"beacon " + std::to_string(beacon), "m"});
  eval::Table table(columns);
  std::printf("%zu poses, %zu ranges to %zu beacons\n", recording->steps.size() + 1,
              recording->ranges.size(), recording->beacons.size());
  table.add_row(errors("odometry", range_graph(*recording, false, a.noise), *truth));
  for (const bool free_scale : {false, true}) {
    RangeGraph graph = range_graph(*recording, free_scale, a.noise);
    const auto report = optimise(graph);
    if (!report) return report.error();
    const char* const name = free_scale ? "SLAM, scale of ranges free" : "SLAM, ranges as they are";
    std::printf("%s: cost %.6g -> %.6g in %d iterations, %.1f ms; ranges %.2f %% too long\n", name,
                report->initial_cost, report->final_cost, report->iterations,
                1e3 * report->times.total_s, 100.0 * graph.all<RangeScale>().front()[0]);
    print_residuals(graph);
    table.add_row(errors(name, graph, *truth));
  }
  std::printf("%s", table.to_text().c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Range-only SLAM on a recording of a robot with ranging radios and its truth: errors of the "
      "path after rigid alignment, and of the beacons by the same alignment.");
  Arguments a;
  app.add_option("ODOMETRY", a.odometry, "lines: time, distance, change of heading").required();
  app.add_option("RANGES", a.ranges, "lines: time, sender, receiver, range").required();
  app.add_option("TRUTH", a.truth, "MATLAB file with GT (path) and TL (beacons)").required();
  app.add_option("--forward", a.noise.forward_m, "standard deviation of a step's length, m")
      .positive()
      .show_default();
  app.add_option("--sideways", a.noise.sideways_m, "and across it, m").positive().show_default();
  app.add_option("--heading", a.noise.heading_rad, "and of its change of heading, rad")
      .positive()
      .show_default();
  app.add_option("--range", a.noise.range_m, "standard deviation of a range, m")
      .positive()
      .show_default();
  app.add_option("--kernel", a.noise.kernel, "scale of the Cauchy kernel of ranges, sigmas")
      .positive()
      .show_default();
  app.example("odometry.txt ranges.txt truth.mat", "errors of the path and of the beacons");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("range_slam_study", run(a));
}
