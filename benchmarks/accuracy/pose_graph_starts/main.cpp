// Linear systems that pose graphs take from each start, and whether they reach the optimum.

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/g2o.hpp>

#include "streets.hpp"
#include "support/program_files.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options {
  std::vector<std::string> inputs;
  std::vector<std::string> starts{"file", "odometry", "tree", "chordal"};
  std::vector<int> rises{0, 2}, streets;
  StreetOptions drive;
};

constexpr std::pair<const char*, StartMethod> kStarts[] = {{"file", StartMethod::given},
                                                           {"odometry", StartMethod::odometry},
                                                           {"tree", StartMethod::tree},
                                                           {"chordal", StartMethod::chordal}};

struct Outcome {
  std::string start, error;
  OptimiseReport report;
  int rises = 0;
  double processor_s = 0.0;
};

double processor_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

template <class G>
Outcome solve(PoseGraph<G> graph, const std::pair<const char*, StartMethod>& start, int rises) {
  Outcome o;
  o.start = start.first;
  o.rises = rises;
  const auto report = [&]() -> Result<OptimiseReport> {
    if (auto done = start_from(graph, start.second); !done) return done.error();
    const double from_s = processor_s();
    OptimiseOptions options;
    options.max_rises = rises;
    auto optimised = optimise(graph, options);
    o.processor_s = processor_s() - from_s;
    return optimised;
  }();
  if (report)
    o.report = *report;
  else
    o.error = report.error().to_string();
  return o;
}

template <class G>
void add_rows(eval::Table& table, const std::string& name, const PoseGraph<G>& graph,
              const Options& o) {
  std::vector<Outcome> all;
  for (const auto& start : kStarts)
    for (const int rises : o.rises)
      if (std::ranges::find(o.starts, start.first) != o.starts.end())
        all.push_back(solve(graph, start, rises));
  double least = std::numeric_limits<double>::infinity();
  for (const Outcome& s : all)
    if (s.error.empty()) least = std::min(least, s.report.final_cost);
  for (const Outcome& s : all) {
    if (!s.error.empty()) {
      table.add_row({name, s.start, std::to_string(s.rises), s.error});
      continue;
    }
    const bool reached = s.report.final_cost <= least * (1.0 + 1e-4) + 1e-9;
    table.add_row({name, s.start, std::to_string(s.rises), std::to_string(s.report.iterations),
                   eval::significant(s.report.initial_cost, 5),
                   eval::significant(s.report.final_cost, 7), reached ? "yes" : "no",
                   s.report.fell_back ? "yes" : "", eval::fixed(1e3 * s.processor_s, 1)});
  }
}

Result<void> run(const Options& o) {
  eval::Table table({{"graph"},
                     {"start"},
                     {"rises"},
                     {"systems"},
                     {"before"},
                     {"after"},
                     {"least"},
                     {"damped"},
                     {"processor time", "ms"}});
  for (const std::string& path : o.inputs) {
    const auto file = io::read_g2o(path);
    if (!file) return file.error();
    std::visit(
        [&](const auto& any) {
          add_rows(table, path.substr(path.find_last_of('/') + 1), io::to_pose_graph(any), o);
        },
        *file);
  }
  for (const int poses : o.streets) {
    StreetOptions drive = o.drive;
    drive.poses = poses;
    add_rows(table, "streets " + std::to_string(poses), Streets(drive).drive(), o);
  }
  std::printf("%s", table.to_text().c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine line(
      "Linear systems that pose graphs take from each start (their file's poses, odometry, a "
      "spanning tree, chordal relaxation), for several numbers of steps that may raise the cost; "
      "\"least\" says whether the lowest cost of all of them was reached within 0.01 %.");
  Options o;
  line.add_option("files", o.inputs, "g2o files of poses, 2D or 3D, plain or gzip");
  line.add_option("--rises", o.rises, "numbers of rises that Gauss-Newton may take").delimiter(',');
  line.add_option("--starts", o.starts, "file, odometry, tree, chordal").delimiter(',');
  line.add_option("--streets", o.streets, "numbers of poses of simulated drives").delimiter(',');
  line.add_number("--seed", o.drive.seed, 0, 1'000'000'000, "of the random numbers");
  line.add_option("--drift", o.drive.drift_rad_m,
                  "systematic turn of a drive's initial poses, rad/m")
      .show_default();
  line.add_positive("--sigma-rad", o.drive.sigma_rad, "noise of a drive's edges");
  line.add_positive("--sigma-m", o.drive.sigma_m, "noise of a drive's edges");
  line.example("graph.g2o --streets 15000,20000 --drift 0.001", "a file and two simulated drives");
  if (const auto code = line.parse(argc, argv)) return *code;
  return exit_code("pose_graph_starts", run(o));
}
