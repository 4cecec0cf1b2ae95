// False loops of several kinds added to a pose graph: which of them each method finds, over seeds.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/graph/loop_consistency.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/g2o.hpp>

#include "methods.hpp"
#include "sets.hpp"
#include "support/program_files.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options {
  std::string input, write;
  std::vector<std::string> methods{"cycles"};
  int loops = 1000, first = 1, seeds = 3;
  bool decidable = false;
};

/// Shares of one set, in per cent, or of the worst of several.
struct Score {
  double found = 100.0;      ///< false loops rejected, of all false
  double kept = 100.0;       ///< true loops kept, of all true
  double precision = 100.0;  ///< false loops, of the rejected
  double error_m = 0.0;      ///< RMSE of positions relative to the optimum without false loops
  double total_s = 0.0, processor_s = 0.0;
  int undecided = 0;
};

struct Summary {
  Score mean{0.0, 0.0, 0.0}, worst;
  int sets = 0, failed = 0;

  void add(const Score& s) {
    ++sets;
    mean.found += s.found, mean.kept += s.kept, mean.precision += s.precision;
    worst.found = std::min(worst.found, s.found);
    worst.kept = std::min(worst.kept, s.kept);
    worst.precision = std::min(worst.precision, s.precision);
    worst.error_m = std::max(worst.error_m, s.error_m);
    worst.total_s = std::max(worst.total_s, s.total_s);
    worst.processor_s = std::max(worst.processor_s, s.processor_s);
    worst.undecided = std::max(worst.undecided, s.undecided);
  }
};

template <LieGroup G>
double rmse(const PoseGraph<G>& a, const PoseGraph<G>& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.poses.size(); ++k)
    sum += (a.poses[k].translation() - b.poses[k].translation()).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.poses.size()));
}

template <LieGroup G>
Score score(const PoseGraph<G>& clean, const PoseGraph<G>& graph, const Rejection& found) {
  const auto loops = std::count_if(clean.edges.begin(), clean.edges.end(),
                                   [](const auto& edge) { return edge.robust; });
  const auto added = static_cast<double>(graph.edges.size() - clean.edges.size());
  const auto wrong =
      static_cast<double>(std::count_if(found.rejected.begin(), found.rejected.end(), [&](int k) {
        return static_cast<std::size_t>(k) < clean.edges.size();
      }));
  const auto rejected = static_cast<double>(found.rejected.size());
  Score s;
  s.found = 100.0 * (rejected - wrong) / added;
  s.kept = 100.0 * (1.0 - wrong / static_cast<double>(loops));
  s.precision = rejected > 0.0 ? 100.0 * (rejected - wrong) / rejected : 100.0;
  s.error_m = rmse(clean, graph);
  s.total_s = found.total_s;
  s.processor_s = found.processor_s;
  s.undecided = static_cast<int>(found.undecided.size());
  return s;
}

/// For graphs of one's own: the set as a file, with the false loops last.
template <LieGroup G>
Result<void> write_set(const io::GraphFile<G>& file, const PoseGraph<G>& graph,
                       const std::string& path) {
  io::GraphFile<G> with = file;
  for (std::size_t k = with.edges.size(); k < graph.edges.size(); ++k) {
    const auto& e = graph.edges[k];
    const auto id = [&](int pose) { return file.vertices[static_cast<std::size_t>(pose)].id; };
    with.edges.push_back({id(e.from), id(e.to), e.measurement, e.information});
  }
  return io::write_g2o(path, with);
}

void add_row(eval::Table& table, const std::string& set, const std::string& method,
             const Summary& s) {
  const double sets = std::max(s.sets, 1);
  const auto both = [&](double mean, double worst) {
    return eval::fixed(mean / sets, 2) + " / " + eval::fixed(worst, 2);
  };
  table.add_row({set, method, both(s.mean.found, s.worst.found), both(s.mean.kept, s.worst.kept),
                 both(s.mean.precision, s.worst.precision), eval::significant(s.worst.error_m, 3),
                 std::to_string(s.worst.undecided), eval::fixed(s.worst.total_s, 2),
                 eval::fixed(s.worst.processor_s, 2), std::to_string(s.failed)});
}

/// What could be known at best: the number of true loops that would be accepted among
/// `o.loops` false ones if all the other true loops were known to be true.
template <LieGroup G>
Result<int> count_decidable(const PoseGraph<G>& clean, const Options& o) {
  LoopConsistencyOptions options;
  PoseGraph<G> all = clean;
  const auto scale = optimise_consistent_loops(all, options);
  if (!scale) return scale.error();
  options.noise_scale = scale->noise_scale;
  options.max_false /= 1.0 + o.loops;
  int decidable = 0;
  for (std::size_t k = 0; k < clean.edges.size(); ++k) {
    if (!clean.edges[k].robust) continue;
    PoseGraph<G> graph = clean;
    for (auto& edge : graph.edges) edge.robust = false;
    graph.edges[k].robust = true;
    const auto found = optimise_consistent_loops(graph, options);
    if (!found) return found.error();
    decidable += found->rejected.empty() ? 1 : 0;
  }
  return decidable;
}

template <LieGroup G>
Result<void> run(const io::GraphFile<G>& file, const Options& o) {
  PoseGraph<G> clean = io::to_pose_graph(file);
  if (clean.size() < 100 || clean.edges.size() <= clean.poses.size())
    return Error{ErrorCode::degenerate, o.input + ": fewer than 100 poses, or no loops"};
  if (auto done = start_from_chordal(clean); !done) return done;
  if (auto done = optimise(clean); !done) return done.error();
  if (o.decidable) {
    const auto count = count_decidable(clean, o);
    if (!count) return count.error();
    std::printf("%d true loops would be accepted among %d false ones if all others were known\n",
                *count, o.loops);
    return {};
  }
  eval::Table table({{"false loops"},
                     {"method"},
                     {"found, mean / worst", "%"},
                     {"true kept, mean / worst", "%"},
                     {"precision, mean / worst", "%"},
                     {"largest error", "m"},
                     {"most undecided"},
                     {"longest time", "s"},
                     {"longest processor time", "s"},
                     {"errors"}});
  for (const FalseLoops kind :
       {FalseLoops::random, FalseLoops::groups_10, FalseLoops::groups_30, FalseLoops::local}) {
    std::map<std::string, Summary> summaries;
    for (int seed = o.first; seed < o.first + o.seeds; ++seed) {
      const auto set =
          FalseLoopMaker<G>(clean, static_cast<std::uint64_t>(seed)).with(kind, o.loops);
      if (!o.write.empty()) {
        const std::string name = std::string(name_of(kind)) + ' ' + std::to_string(seed);
        if (auto done = write_set(file, set, o.write + '/' + name + ".g2o"); !done) return done;
      }
      for (const std::string& method : o.methods) {
        PoseGraph<G> graph = set;
        const auto found = reject(method, graph);
        if (found)
          summaries[method].add(score(clean, graph, *found));
        else
          ++summaries[method].failed;
      }
    }
    for (const std::string& method : o.methods)
      add_row(table, name_of(kind), method, summaries[method]);
  }
  std::printf("%s", table.to_text().c_str());
  return {};
}

Result<void> run(const Options& o) {
  for (const auto& method : o.methods) {
    const auto names = method_names();
    if (std::find(names.begin(), names.end(), method) == names.end())
      return bad_use("there is no method " + method);
  }
  const auto file = io::read_g2o(o.input);
  if (!file) return file.error();
  return std::visit([&](const auto& graph) { return run(graph, o); }, *file);
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine line(
      "False loops added to the optimum of a pose graph: which of them each method finds, how many "
      "true ones it keeps, and the error of the positions, as mean and worst over seeds.");
  Options o;
  line.add_file("file", o.input, "g2o file of poses, 2D or 3D, plain or gzip").required();
  line.add_number("--loops", o.loops, 1, 1'000'000, "number of false loops of a set");
  line.add_number("--first-seed", o.first, 0, 1'000'000, "seed of the first set");
  line.add_number("--seeds", o.seeds, 1, 1'000'000, "number of sets of each kind");
  line.add_option("--rejection", o.methods, "cycles, gnc, dcs, pcm or pcm-scaled").delimiter(',');
  line.add_flag("--decidable", o.decidable,
                "instead: the true loops that would be accepted if all others were known");
  line.add_option("--write", o.write, "folder for the sets as g2o files, false loops last")
      .shown_as("DIR");
  line.example("graph.g2o --loops 500 --rejection cycles,gnc", "two methods beside each other");
  if (const auto code = line.parse(argc, argv)) return *code;
  return exit_code("false_loops", run(o));
}
