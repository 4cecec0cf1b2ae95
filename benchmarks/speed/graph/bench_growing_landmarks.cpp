// A landmark log replayed pose by pose: time per pose and final cost of the incremental optimiser
// of factor graphs, compared with the batch optimiser started from its last estimate.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
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

namespace {

using namespace wayfare;
using bench::milliseconds;

using File = io::GraphFile<SE2d>;
using Sighting = io::GraphMeasurement<LandmarkPosition<SE2d>>;
using ParkGraph =
    FactorGraph<Variables<SE2d, Eigen::Vector2d>, Edges<Between<SE2d>, LandmarkPosition<SE2d>>>;

struct Arguments {
  std::string input;
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

Result<void> run(const Arguments& a) {
  const auto any = io::read_g2o(a.input);
  if (!any) return any.error();
  const File* const file = std::get_if<File>(&*any);
  if (file == nullptr) return Error{ErrorCode::unsupported, "a planar log is needed", a.input};
  const auto steps = steps_of(*file);
  if (!steps) return steps.error();

  Replay<IncrementalGraphOptimiser<ParkGraph>> growing;
  Replay<ParkGraph> whole;
  GraphOptimiser<ParkGraph> batch;
  double incremental_ms = 0.0, incremental_then_ms = 0.0, batch_ms = 0.0, worst_ms = 0.0;
  double cost = 0.0, batch_cost = 0.0, worst_percent = 0.0, sum_percent = 0.0;
  int solved = 0, fell_back = 0;
  for (std::size_t i = 0; i < steps->size(); ++i) {
    Result<IncrementalReport> report = IncrementalReport{};
    const double ms = milliseconds([&] {
      growing.add((*steps)[i]);
      report = growing.graph.update(a.options);
    });
    if (!report) return report.error();
    incremental_ms += ms;
    worst_ms = std::max(worst_ms, ms);
    cost = report->cost;
    fell_back += report->fell_back ? 1 : 0;
    whole.add((*steps)[i]);
    if (growing.failed) return Error{ErrorCode::invalid, "an edge was refused", a.input};
    if (i == 0 || (i % static_cast<std::size_t>(a.batch_every) != 0 && i + 1 != steps->size()))
      continue;
    Result<OptimiseReport> optimum = OptimiseReport{};
    batch_ms += milliseconds([&] { optimum = batch.optimise(whole.graph); });
    if (!optimum) return optimum.error();
    ++solved;
    incremental_then_ms += ms;
    batch_cost = optimum->final_cost;
    const double percent = 100.0 * (cost - batch_cost) / std::max(1.0, batch_cost);
    worst_percent = std::max(worst_percent, percent);
    sum_percent += percent;
  }
  std::printf("poses          %zu (%d of them solved in batch)\n", steps->size(), solved);
  std::printf("incremental    %.1f ms in total, %.3f per pose, %.1f at most, %d fallbacks\n",
              incremental_ms, incremental_ms / static_cast<double>(steps->size()), worst_ms,
              fell_back);
  std::printf("batch          %.1f ms, incremental at the same poses %.1f ms: ratio %.1f\n",
              batch_ms, incremental_then_ms, batch_ms / incremental_then_ms);
  std::printf("cost           %.8g, batch %.8g, excess %.3g %% in the mean, %.3g at most\n", cost,
              batch_cost, sum_percent / solved, worst_percent);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine line(
      "Replay a landmark log pose by pose with the incremental optimiser and with the batch "
      "optimiser, started from its last estimate.");
  Arguments a;
  line.add_option("file", a.input, "landmark log (ODOMETRY, LANDMARK), plain or gzip").required();
  bench::add_growing_options(line, a.batch_every, a.options);
  if (const auto code = line.parse(argc, argv)) return *code;
  return examples::exit_code("bench_growing_landmarks", run(a));
}
