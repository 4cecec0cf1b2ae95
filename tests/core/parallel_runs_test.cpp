#include <wayfare/core/parallel.hpp>

#include <algorithm>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

namespace wayfare::eval {
namespace {

TEST(ForEachRun, MakesEveryRunOnceOnAnyNumberOfThreads) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{100}}) {
    for (const int threads : {0, 1, 3, 200}) {
      std::vector<int> made(count, 0);
      parallel_for(count, threads, [&](std::size_t i) { ++made[i]; });
      EXPECT_EQ(made, std::vector<int>(count, 1)) << count << " runs, " << threads << " threads";
    }
  }
}

// One call per run, in order, even where runs overlap.
TEST(ForEachRun, ReportsItsProgressInOrder) {
  for (const int threads : {1, 4}) {
    std::vector<double> told, want;
    for (int i = 1; i <= 50; ++i) want.push_back(i / 50.0);
    parallel_for(
        50, threads, [](std::size_t) {}, [&](double done) { told.push_back(done); });
    EXPECT_EQ(told, want);
  }
}

TEST(ForEachRun, WorkersAreFewerThan256) {
  std::vector<std::size_t> worker(1000);
  parallel_for_workers(1000, 1000, [&](std::size_t i, std::size_t w) { worker[i] = w; });
  EXPECT_LT(*std::max_element(worker.begin(), worker.end()), 256U);
}

}  // namespace
}  // namespace wayfare::eval
