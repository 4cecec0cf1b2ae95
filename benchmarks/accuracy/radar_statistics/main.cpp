// Statistics of radar frames, recorded by an AWR1843 and simulated: number, position and strength
// of points, and persistence from frame to frame.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/ti_frame.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sim/worlds.hpp>

#include "support/program_files.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options {
  std::string captures;
  std::uint64_t seed = 1;
  std::size_t views = 40;
  std::size_t frames = 25;
  double min_range_m = 0.5;
  double max_range_m = 6.0;
  double speed_m_s = 0.0;
  bool all_points = false;
};

// The grid of the captures' configuration.
constexpr double kRangeBin_m = 0.0436, kDopplerBin_m_s = 0.1217;

struct Named {
  std::string name;
  std::vector<std::vector<RadarScan>> views;  // of one pose each
};

using Cell = std::pair<long, long>;  // range bin, azimuth bin

double range_of(const RadarPoint& p) { return std::hypot(p.x_m, p.y_m); }

Cell cell_of(const RadarPoint& p) {
  const double range = range_of(p);
  return {std::lround(range / kRangeBin_m), std::lround(32.0 * static_cast<double>(p.y_m) / range)};
}

class Statistics {
 public:
  Statistics(const Named& source, const Options& o) {
    for (const auto& view : source.views) add_view(view, o);
  }

  [[nodiscard]] std::vector<std::string> row(const std::string& name) const {
    const auto per_frame = [&](double x) { return x / std::max(1.0, frames_); };
    const auto share = [&](double x) { return eval::fixed(100.0 * x / std::max(1.0, points_), 0); };
    std::vector<std::string> cells = {name,
                                      eval::fixed(per_frame(points_), 1),
                                      eval::fixed(spread(), 1),
                                      eval::fixed(per_frame(range_bins_), 1),
                                      eval::fixed(points_ / std::max(1.0, range_bins_), 1),
                                      eval::fixed(100.0 * persistence(), 0)};
    for (const double q : {0.05, 0.5, 0.95}) cells.push_back(eval::fixed(quantile(snr_db_, q), 1));
    for (const double count : doppler_) cells.push_back(share(count));
    for (const double count : range_) cells.push_back(eval::fixed(per_frame(count), 1));
    for (const double count : azimuth_) cells.push_back(share(count));
    return cells;
  }

  static std::vector<eval::Table::Column> columns() {
    return {{"frames"},     {"points"},     {"sd"},
            {"range bins"}, {"per bin"},    {"again", "%"},
            {"5 %", "dB"},  {"50 %", "dB"}, {"95 %", "dB"},
            {"v 0", "%"},   {"v 1", "%"},   {"v more", "%"},
            {"0.5-1", "m"}, {"1-2"},        {"2-3"},
            {"3-4"},        {"4-6"},        {"0-20", "deg, %"},
            {"20-40"},      {"40-60"},      {"60-90"}};
  }

 private:
  void add_view(const std::vector<RadarScan>& view, const Options& o) {
    std::set<Cell> before;
    std::vector<double> counts;
    for (const RadarScan& scan : view) {
      std::set<Cell> cells;
      double count = 0.0;
      for (const RadarPoint& p : scan.points) {
        if (range_of(p) < o.min_range_m || range_of(p) > o.max_range_m) continue;
        count += 1.0;
        add_point(p);
        cells.insert(cell_of(p));
      }
      add_cells(cells, before);
      before = std::move(cells);
      counts.push_back(count);
    }
    add_spread(counts);
  }

  void add_point(const RadarPoint& p) {
    points_ += 1.0;
    snr_db_.push_back(static_cast<double>(p.snr_db));
    const long v = std::labs(std::lround(static_cast<double>(p.doppler_m_s) / kDopplerBin_m_s));
    doppler_[std::min(v, 2L)] += 1.0;
    const double range = range_of(p);
    range_[range < 1.0 ? 0 : range < 2.0 ? 1 : range < 3.0 ? 2 : range < 4.0 ? 3 : 4] += 1.0;
    const double azimuth = Angle::radians(std::atan2(p.y_m, p.x_m)).degrees();
    azimuth_[std::min(3, static_cast<int>(std::abs(azimuth) / 20.0))] += 1.0;
  }

  void add_cells(const std::set<Cell>& cells, const std::set<Cell>& before) {
    frames_ += 1.0;
    std::set<long> bins;
    for (const Cell& cell : cells) bins.insert(cell.first);
    range_bins_ += static_cast<double>(bins.size());
    if (before.empty()) return;
    const auto persistent = std::count_if(before.begin(), before.end(),
                                          [&](const Cell& c) { return cells.contains(c); });
    persistent_ += static_cast<double>(persistent);
    possible_ += static_cast<double>(before.size());
  }

  // Of the number of points from frame to frame at one pose.
  void add_spread(const std::vector<double>& counts) {
    double mean = 0.0;
    for (const double n : counts) mean += n / static_cast<double>(counts.size());
    for (const double n : counts) square_ += (n - mean) * (n - mean);
  }

  [[nodiscard]] double spread() const { return std::sqrt(square_ / std::max(1.0, frames_)); }
  [[nodiscard]] double persistence() const { return persistent_ / std::max(1.0, possible_); }

  double frames_ = 0.0, points_ = 0.0, range_bins_ = 0.0, persistent_ = 0.0, possible_ = 0.0,
         square_ = 0.0;
  std::vector<double> snr_db_;
  double doppler_[3] = {}, range_[5] = {}, azimuth_[4] = {};
};

Result<std::vector<RadarScan>> read_capture(const std::string& path) {
  const auto content = io::read_file(path);
  if (!content) return content.error();
  std::vector<RadarScan> scans;
  const auto decoder = std::make_unique<decode::TiDecoder>();
  const auto sink = [&](const decode::TiFrame& frame) {
    scans.push_back(decode::to_radar_scan(frame, LogTime{}));
  };
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(content->bytes.data());
  decoder->feed({bytes, content->bytes.size()}, sink);
  decoder->finish(sink);
  return scans;
}

Result<std::vector<Named>> read_captures(const std::string& folder) {
  std::vector<std::filesystem::path> paths;
  std::error_code code;
  for (const auto& entry : std::filesystem::directory_iterator(folder, code))
    if (entry.path().string().find(".dat") != std::string::npos) paths.push_back(entry.path());
  if (code) return Error{ErrorCode::io, code.message(), folder};
  if (paths.empty())
    return Error{ErrorCode::not_found, "contains no captures (*.dat, *.dat.gz)", folder};
  std::sort(paths.begin(), paths.end());
  std::vector<Named> captures;
  for (const auto& path : paths) {
    auto scans = read_capture(path.string());
    if (!scans) return scans.error();
    captures.push_back({path.stem().stem().string(), {std::move(scans).value()}});
  }
  return captures;
}

// A position on the route with random heading.
SE2d view_of(const sim::World& world, Rng& rng) {
  const std::size_t leg = 1 + rng.below(world.route_m.size() - 1);
  const Eigen::Vector2d at =
      world.route_m[leg - 1] + rng.uniform() * (world.route_m[leg] - world.route_m[leg - 1]);
  return SE2d(at.x(), at.y(), Angle::radians(rng.uniform(-3.14159, 3.14159)));
}

Named simulate(const sim::World& world, const std::string& name, const Options& o) {
  Named result{name, {}};
  sim::RadarParams params;
  params.max_range_m = o.max_range_m;
  if (o.all_points) params.max_points = 100000;
  Rng poses = Rng(o.seed).stream(17);
  for (std::size_t v = 0; v < o.views; ++v) {
    const SE2d pose = view_of(world, poses);
    Rng noise = Rng(o.seed).stream(100 + v);
    std::vector<RadarScan> scans;
    for (std::size_t i = 0; i < o.frames; ++i) {
      const double distance_m = o.speed_m_s * static_cast<double>(i) / 30.0;
      scans.push_back(sim::simulate_radar(world.plan, world.reflectors,
                                          pose * SE2d(distance_m, 0.0, Angle{}), {o.speed_m_s, 0.0},
                                          LogTime{}, params, noise));
    }
    result.views.push_back(std::move(scans));
  }
  return result;
}

Result<void> run(const Options& o) {
  eval::Table table(Statistics::columns());
  if (!o.captures.empty()) {
    const auto captures = read_captures(o.captures);
    if (!captures) return captures.error();
    Named all{"all captures", {}};
    for (const Named& capture : *captures) {
      table.add_row(Statistics(capture, o).row(capture.name));
      all.views.push_back(capture.views[0]);
    }
    table.add_row(Statistics(all, o).row(all.name));
  }
  for (const sim::WorldName& name : sim::world_names()) {
    const auto world = sim::make_world(name.name, Rng(o.seed));
    if (!world) return world.error();
    const std::string title = "simulated " + std::string(name.name);
    table.add_row(Statistics(simulate(*world, title, o), o).row(title));
  }
  std::printf("%s", table.to_text().c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Compare recorded frames of an AWR1843 with simulated ones: points per frame and their "
      "standard deviation at one pose, range bins with points and points per bin, share of the "
      "range-azimuth cells that persist in the next frame, signal-to-noise ratio, Doppler bins "
      "relative to the robot's motion, points per frame by range, share of the points by azimuth.");
  Options o;
  app.add_option("--captures", o.captures, "folder of recorded data ports (*.dat, *.dat.gz)")
      .shown_as("DIR");
  app.add_option("--seed", o.seed, "of the random numbers, for worlds and noise").show_default();
  app.add_option("--views", o.views, "simulated poses").range(1, 10000).show_default();
  app.add_option("--frames", o.frames, "at each pose").range(2, 10000).show_default();
  app.add_option("--min-range", o.min_range_m, "smallest range, m")
      .range(0.1, 100.0)
      .show_default();
  app.add_option("--max-range", o.max_range_m, "largest range, m").range(0.5, 9.0).show_default();
  app.add_option("--speed", o.speed_m_s, "of the simulated radar, straight ahead, m/s")
      .range(0.0, 0.9);
  app.add_flag("--all-points", o.all_points, "no limit of 100 points per frame");
  app.example("--captures radar", "recorded frames beside simulated ones");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("radar_statistics", run(o));
}
