// A landmark log replayed pose by pose: time per pose and final cost of the incremental optimiser
// of factor graphs, compared with the batch optimiser started from its last estimate. One after the
// other, so that each finds its own data in the caches.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/graph/incremental.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/landmark_graph.hpp>

#include "growing.hpp"
#include "simulated_streets.hpp"

namespace {

using namespace wayfare;
using bench::milliseconds;

using File = io::GraphFile<SE2d>;
using Sighting = io::GraphMeasurement<LandmarkPosition<SE2d>>;
using ParkGraph =
    FactorGraph<Variables<SE2d, Eigen::Vector2d>, Edges<Between<SE2d>, LandmarkPosition<SE2d>>>;

struct Arguments {
  std::string input;
  std::uint64_t streets_seed = 0;
  int batch_every = 1;
  IncrementalOptions options = kIncrementalDefaults<ParkGraph>;
};

/// What comes with one pose.
struct Step {
  const io::GraphEdge<SE2d>* odometry = nullptr;
  std::vector<const Sighting*> sightings;
};

Result<std::vector<Step>> steps_of(const File& file) {
  std::unordered_map<std::int64_t, std::size_t> pose;
  for (const auto& vertex : file.vertices) pose.emplace(vertex.id, pose.size());
  std::vector<Step> steps(file.vertices.size());
  for (const auto& edge : file.edges) {
    const std::size_t to = pose.at(edge.to);
    if (pose.at(edge.from) + 1 != to || steps[to].odometry != nullptr)
      return Error{ErrorCode::unsupported, "edges between poses other than a chain"};
    steps[to].odometry = &edge;
  }
  for (std::size_t i = 1; i < steps.size(); ++i)
    if (steps[i].odometry == nullptr)
      return Error{ErrorCode::unsupported, "edges between poses other than a chain"};
  for (const Sighting& s : file.all<LandmarkPosition<SE2d>>())
    steps[pose.at(s.ids[0])].sightings.push_back(&s);
  return steps;
}

/// The graph as it grows, in either kind of optimiser.
template <class Graph>
class Replay {
 public:
  Graph graph;

  void add(const Step& step) {
    const bool first = step.odometry == nullptr;
    const SE2d pose = first ? SE2d() : graph[last_] * step.odometry->measurement;
    const auto added = id_of(graph.add(pose));
    if (first)
      (void)graph.fix(added);  // it was added just now
    else
      check(graph, Between<SE2d>{step.odometry->measurement, step.odometry->information}, last_,
            added);
    last_ = added;
    for (const Sighting* s : step.sightings) {
      auto tree = trees_.find(s->ids[1]);
      if (tree == trees_.end())
        tree =
            trees_.emplace(s->ids[1], id_of(graph.add(Eigen::Vector2d(pose * s->edge.measurement))))
                .first;
      check(graph, s->edge, last_, tree->second);
    }
  }
  bool failed = false;

 private:
  template <class X>
  static VariableId<X> id_of(const VariableId<X>& id) {
    return id;
  }
  template <class X>
  VariableId<X> id_of(const Result<VariableId<X>>& id) {
    failed = failed || !id;
    return id ? *id : VariableId<X>{};
  }
  void check(auto& growing, const auto& edge, const auto&... ends) {
    if constexpr (std::is_void_v<decltype(growing.add(edge, ends...))>)
      growing.add(edge, ends...);
    else
      failed = failed || !growing.add(edge, ends...);
  }

  VariableId<SE2d> last_;
  std::unordered_map<std::int64_t, VariableId<Eigen::Vector2d>> trees_;
};

Result<File> log_of(const Arguments& a) {
  if (a.input.empty()) return bench::SimulatedStreets(a.streets_seed).log();
  auto any = io::read_g2o(a.input);
  if (!any) return any.error();
  File* const file = std::get_if<File>(&*any);
  if (file == nullptr) return Error{ErrorCode::unsupported, "a planar log is needed", a.input};
  return std::move(*file);
}

/// Of one optimiser, after each pose; NaN where it did not solve.
struct Run {
  std::vector<double> ms, cost;
  int fell_back = 0;
};

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

Error refused() { return {ErrorCode::invalid, "an edge was refused"}; }

Result<Run> replay_incrementally(const std::vector<Step>& steps,
                                 const IncrementalOptions& options) {
  Replay<IncrementalGraphOptimiser<ParkGraph>> growing;
  Run run;
  for (const Step& step : steps) {
    Result<IncrementalReport> report = IncrementalReport{};
    run.ms.push_back(milliseconds([&] {
      growing.add(step);
      report = growing.graph.update(options);
    }));
    if (growing.failed) return refused();
    if (!report) return report.error();
    run.cost.push_back(report->cost);
    run.fell_back += report->fell_back ? 1 : 0;
  }
  return run;
}

/// Solves after every `every`-th pose and at the end, each time from its last estimate.
Result<Run> replay_in_batch(const std::vector<Step>& steps, int every) {
  Replay<ParkGraph> whole;
  GraphOptimiser<ParkGraph> batch;
  Run run;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    whole.add(steps[i]);
    if (whole.failed) return refused();
    const bool solve = i > 0 && (i % static_cast<std::size_t>(every) == 0 || i + 1 == steps.size());
    Result<OptimiseReport> optimum = OptimiseReport{};
    run.ms.push_back(solve ? milliseconds([&] { optimum = batch.optimise(whole.graph); }) : kNone);
    if (!optimum) return optimum.error();
    run.cost.push_back(solve ? optimum->final_cost : kNone);
  }
  return run;
}

void print(const Run& growing, const Run& whole) {
  double all_ms = 0.0, incremental_ms = 0.0, batch_ms = 0.0, sum_percent = 0.0, worst_percent = 0.0;
  int solved = 0;
  for (std::size_t i = 0; i < growing.ms.size(); ++i) {
    all_ms += growing.ms[i];
    if (std::isnan(whole.ms[i])) continue;
    ++solved;
    incremental_ms += growing.ms[i];
    batch_ms += whole.ms[i];
    const double percent = 100.0 * (growing.cost[i] - whole.cost[i]) / std::max(1.0, whole.cost[i]);
    worst_percent = std::max(worst_percent, percent);
    sum_percent += percent;
  }
  std::printf("poses          %zu (%d of them solved in batch)\n", growing.ms.size(), solved);
  std::printf("incremental    %.1f ms in total, %.3f per pose, %.1f at most, %d fallbacks\n",
              all_ms, all_ms / static_cast<double>(growing.ms.size()),
              *std::max_element(growing.ms.begin(), growing.ms.end()), growing.fell_back);
  std::printf("batch          %.1f ms, incremental at the same poses %.1f ms: ratio %.1f\n",
              batch_ms, incremental_ms, batch_ms / incremental_ms);
  std::printf("cost           %.8g, batch %.8g, excess %.3g %% in the mean, %.3g at most\n",
              growing.cost.back(), whole.cost.back(), sum_percent / solved, worst_percent);
}

Result<void> run(const Arguments& a) {
  const auto file = log_of(a);
  if (!file) return file.error();
  const auto steps = steps_of(*file);
  if (!steps) return steps.error();

  const auto growing = replay_incrementally(*steps, a.options);
  if (!growing) return growing.error();
  const auto whole = replay_in_batch(*steps, a.batch_every);
  if (!whole) return whole.error();
  print(*growing, *whole);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine line(
      "Replay a landmark log pose by pose with the incremental optimiser and with the batch "
      "optimiser, started from its last estimate: a log, or simulated streets.");
  Arguments a;
  line.add_option("file", a.input, "landmark log (ODOMETRY, LANDMARK), plain or gzip");
  line.add_option("--streets", a.streets_seed, "seed of a simulated log, without a file")
      .show_default();
  bench::add_growing_options(line, a.batch_every, a.options);
  line.example("victoria.log", "a log of odometry and landmarks");
  if (const auto code = line.parse(argc, argv)) return *code;
  return examples::exit_code("bench_growing_landmarks", run(a));
}
