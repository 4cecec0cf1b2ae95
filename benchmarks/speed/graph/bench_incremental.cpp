// A pose graph replayed edge by edge: time per step and final cost of the incremental optimiser,
// compared with the batch optimiser started from its last estimate.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include <wayfare/graph/incremental.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/g2o.hpp>
#include <wayfare/io/report.hpp>

#include "growing.hpp"

namespace {

using namespace wayfare;
using bench::milliseconds;

struct Arguments {
  std::string input, csv, report;
  bool force = false;
  int batch_every = 1;
  IncrementalOptions options;
};

struct Row {
  double step = 0.0, poses = 0.0;
  double incremental_ms = 0.0, batch_ms = 0.0;
  double incremental_cost = 0.0, batch_cost = 0.0;
  IncrementalReport report;
};

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// The batch optimiser on the same graph, started from its last estimate.
template <LieGroup G>
struct Batch {
  PoseGraph<G> graph;
  PoseGraphOptimiser<G> optimiser;

  Result<double> add(const ReplayStep<G>& step, bool solve, double& ms) {
    if (step.new_pose >= 0) graph.add_pose(step.placed(graph.poses));
    graph.edges.push_back(step.edge);
    if (!solve) return kNone;
    Result<OptimiseReport> report = OptimiseReport{};
    ms = milliseconds([&] { report = optimiser.optimise(graph); });
    if (!report) return report.error();
    return report->final_cost;
  }
};

template <LieGroup G>
Result<std::vector<Row>> replay(const PoseGraph<G>& whole, const Arguments& a) {
  const auto steps = replay_steps(whole);
  IncrementalOptimiser<G> growing;
  if (auto first = growing.add_pose(whole.poses.front()); !first) return first.error();
  Batch<G> batch;
  batch.graph.add_pose(whole.poses.front());
  std::vector<Row> rows;
  for (const auto& step : steps) {
    Row row;
    row.step = static_cast<double>(rows.size() + 1);
    Result<IncrementalReport> report = IncrementalReport{};
    Result<void> added;
    row.incremental_ms = milliseconds([&] {
      if (step.new_pose >= 0) (void)growing.add_pose(step.placed(growing.poses()));
      added = growing.add_edge(step.edge);
      report = growing.update(a.options);
    });
    if (!added) return added.error();
    if (!report) return report.error();
    row.report = *report;
    row.poses = static_cast<double>(growing.poses().size());
    row.incremental_cost = report->cost;
    row.batch_ms = kNone;
    const bool last = rows.size() + 1 == steps.size();
    const bool solve = static_cast<int>(rows.size() + 1) % a.batch_every == 0 || last;
    const auto cost = batch.add(step, solve, row.batch_ms);
    if (!cost) return cost.error();
    row.batch_cost = *cost;
    rows.push_back(row);
  }
  return rows;
}

/// NaN without a batch solution; relative to at least 1, against noise of costs near zero.
double excess_percent(const Row& r) {
  return 100.0 * (r.incremental_cost - r.batch_cost) / std::max(1.0, r.batch_cost);
}

void print(const std::vector<Row>& rows) {
  double incremental = 0.0, batch = 0.0, worst = 0.0, slowest = 0.0, flops = 0.0, refactored = 0.0,
         relinearised = 0.0;
  int solved = 0, over = 0, reordered = 0, fell_back = 0;
  for (const Row& r : rows) {
    incremental += r.incremental_ms;
    slowest = std::max(slowest, r.incremental_ms);
    flops += r.report.flops;
    refactored += r.report.refactored;
    relinearised += r.report.relinearised;
    reordered += r.report.reordered ? 1 : 0;
    fell_back += r.report.fell_back ? 1 : 0;
    if (!(r.batch_ms >= 0.0)) continue;
    ++solved;
    batch += r.batch_ms;
    worst = std::max(worst, excess_percent(r));
    over += excess_percent(r) > 1.0 ? 1 : 0;
  }
  std::printf("steps          %zu (%d of them solved in batch)\n", rows.size(), solved);
  std::printf("incremental    %.1f ms in total, %.3f per step, %.1f at most\n", incremental,
              incremental / static_cast<double>(rows.size()), slowest);
  std::printf("batch          %.1f ms in total\n", batch);
  std::printf("cost           %.6g, batch %.6g\n", rows.back().incremental_cost,
              rows.back().batch_cost);
  std::printf("excess of cost %.4g %% at most, above 1 %% in %d steps\n", worst, over);
  std::printf(
      "work           %.4g Gflop, %.0f columns factorised again, %.0f poses linearised "
      "again, %d reorderings, %d fallbacks\n",
      1e-9 * flops, refactored, relinearised, reordered, fell_back);
}

Result<void> write_csv(const std::vector<Row>& rows, const Arguments& a) {
  std::string text =
      "step,poses,incremental_ms,batch_ms,incremental_cost,batch_cost,refactored,relinearised\n";
  for (const Row& r : rows) {
    char line[240];
    std::snprintf(line, sizeof line, "%.0f,%.0f,%.5f,%.5f,%.8g,%.8g,%d,%d\n", r.step, r.poses,
                  r.incremental_ms, r.batch_ms, r.incremental_cost, r.batch_cost,
                  r.report.refactored, r.report.relinearised);
    text += line;
  }
  return io::write_file(a.csv, text, {a.force ? io::Existing::replace : io::Existing::refuse});
}

io::Plot plot_over_steps(const char* title, const char* y_label) {
  return {title, "edges added", y_label, {}};
}

/// A value of each row, where it is finite.
template <class Value>
io::Series series(const char* name, const std::vector<Row>& rows, io::Mark mark,
                  const Value& value) {
  io::Series s{name, {}, {}, mark};
  for (const Row& r : rows) {
    const double y = value(r);
    if (std::isfinite(y)) s.add(r.step, y);
  }
  return s;
}

Result<void> write_report(const std::vector<Row>& rows, const Arguments& a) {
  io::Report report("A pose graph replayed edge by edge", a.input);
  auto each = plot_over_steps("Time per step", "ms");
  each.series = {
      series("batch, from the last estimate", rows, io::Mark::points,
             [](const Row& r) { return r.batch_ms; }),
      series("incremental", rows, io::Mark::points, [](const Row& r) { return r.incremental_ms; })};
  auto all = plot_over_steps("Cumulative time", "s");
  double batch = 0.0, incremental = 0.0;
  all.series = {series("batch (of the steps it solved)", rows, io::Mark::line,
                       [&](const Row& r) {
                         if (std::isfinite(r.batch_ms)) batch += 1e-3 * r.batch_ms;
                         return batch;
                       }),
                series("incremental", rows, io::Mark::line,
                       [&](const Row& r) { return 1e-3 * (incremental += r.incremental_ms); })};
  auto excess = plot_over_steps("Excess of the cost over the batch optimum", "%");
  excess.series = {series("excess", rows, io::Mark::line, excess_percent)};
  report.plot(each).plot(all).plot(excess);
  return report.write(a.report, {a.force ? io::Existing::replace : io::Existing::refuse});
}

Result<void> run(const Arguments& a) {
  const auto file = io::read_g2o(a.input);
  if (!file) return file.error();
  const auto rows =
      std::visit([&](const auto& any) { return replay(io::to_pose_graph(any), a); }, *file);
  if (!rows) return rows.error();
  print(*rows);
  if (!a.csv.empty())
    if (auto written = write_csv(*rows, a); !written) return written;
  return a.report.empty() ? Result<void>{} : write_report(*rows, a);
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine line(
      "Replay the pose graph of a g2o file edge by edge with the incremental optimiser and with "
      "the batch optimiser, started from its last estimate.");
  Arguments a;
  line.add_option("file", a.input, "g2o file, 2D or 3D, plain or gzip").required();
  line.add_option("--csv", a.csv, "file for a table of the steps");
  line.add_option("--report", a.report, "HTML file for the curves");
  line.add_flag("--force", a.force, "replace existing files");
  bench::add_growing_options(line, a.batch_every, a.options);
  line.example("graph.g2o", "a graph replayed edge by edge");
  if (const auto code = line.parse(argc, argv)) return *code;
  return examples::exit_code("bench_incremental", run(a));
}
