#pragma once

// What the benchmarks of growing graphs share.

#include <chrono>

#include <wayfare/graph/incremental.hpp>

#include "support/command_line.hpp"

namespace wayfare::bench {

template <class Call>
double milliseconds(const Call& call) {
  const auto start = std::chrono::steady_clock::now();
  call();
  return 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

inline void add_growing_options(examples::CommandLine& line, int& batch_every,
                                IncrementalOptions& options) {
  line.add_option("--batch-every", batch_every, "steps between batch solutions")
      .positive()
      .show_default();
  line.add_option("--relinearise", options.relinearise_step,
                  "step of a variable above which it is linearised again (m or rad)")
      .not_negative()
      .show_default();
  line.add_option("--solve-change", options.solve_change,
                  "change of a step that is not propagated further (m or rad)")
      .not_negative()
      .show_default();
  line.add_option("--solve-deviations", options.solve_deviations,
                  "instead, if positive, in standard deviations of a variable")
      .not_negative()
      .show_default();
  line.add_option("--rounds", options.max_rounds,
                  "largest number of linear systems solved per step")
      .positive()
      .show_default();
  line.add_option("--reorder-work", options.reorder_work,
                  "work on parts, in complete factorisations, before reordering")
      .not_negative()
      .show_default();
}

}  // namespace wayfare::bench
