#include "solve.hpp"

#include <cstdio>
#include <string>

#include <wayfare/eval/table.hpp>
#include <wayfare/io/report.hpp>

namespace wayfare::examples {

void print(const Outcome& outcome, const Arguments& a) {
  const OptimiseReport& r = outcome.report;
  if (a.start != StartMethod::given) std::printf("start      %.1f ms\n", 1e3 * outcome.start_s);
  if (a.rejects()) {
    std::printf("rounds     %d\nrejected   %zu edges\n", outcome.rounds, outcome.rejected.size());
    if (!outcome.undecided.empty())
      std::printf("undecided  %zu of these\n", outcome.undecided.size());
    std::printf("without rejected edges:\n");
  }
  std::printf("before     %.8g\n", r.initial_chi2);
  std::printf("after      %.8g\n", r.final_chi2);
  if (r.final_cost != r.final_chi2) {
    std::printf("robust     %.8g before, %.8g after\n", r.initial_cost, r.final_cost);
  }
  const std::string reason(a.incremental ? outcome.steps : to_string(r.reason));
  std::printf("iterations %d (%s%s)\n", r.iterations, reason.c_str(),
              r.fell_back ? ", fell back to Levenberg-Marquardt" : "");
  const PhaseTimes& t = r.times;
  std::printf("time       %.1f ms", 1e3 * outcome.total_s);
  if (!a.rejects() && !a.incremental) {
    std::printf(" (check %.1f, analyse %.1f, linearise %.1f, factorise %.1f, solve %.1f)",
                1e3 * t.validate_s, 1e3 * t.analyse_s, 1e3 * t.linearise_s, 1e3 * t.factorise_s,
                1e3 * t.solve_s);
  }
  std::printf("\n");
}

Result<Doubt> finish(std::size_t vertices, std::size_t edges, const Outcome& outcome,
                     const Arguments& a) {
  const OptimiseReport& r = outcome.report;
  const auto number = [](double value) { return eval::significant(value, 9); };
  io::Report numbers("Pose graph " + a.input);
  numbers.facts({{"vertices", std::to_string(vertices)},
                 {"edges", std::to_string(edges)},
                 {"before", number(r.initial_chi2)},
                 {"after", number(r.final_chi2)},
                 {"robust before", number(r.initial_cost)},
                 {"robust after", number(r.final_cost)},
                 {"iterations", std::to_string(r.iterations)},
                 {"rounds", std::to_string(outcome.rounds)},
                 {"rejected", std::to_string(outcome.rejected.size())},
                 {"time", number(1e3 * outcome.total_s) + " ms"}});
  if (a.cycles) numbers.facts({{"undecided", std::to_string(outcome.undecided.size())}});
  if (auto done = a.write_json(numbers); !done) return done.error();
  const bool ended = r.reason == StopReason::max_iterations && !a.incremental;
  if (!outcome.undecided.empty())
    return Doubt{std::to_string(outcome.undecided.size()) +
                 " rejected loops agree with the others too vaguely to tell whether they are true"};
  return Doubt{ended ? "the optimisation ended after --max-iterations" : ""};
}

}  // namespace wayfare::examples
