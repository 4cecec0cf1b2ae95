// The options of graph, Hector, submap and pedestrian SLAM at their limits and beyond: every pose
// stays finite, nothing is lost, no memory or time without bound.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "abuse/slam_support.hpp"

namespace wayfare::tests {
namespace {

template <class Options>
using Setting = std::pair<const char*, std::function<void(Options&, double)>>;
template <class Options>
using Choice = std::pair<const char*, std::function<void(Options&, int)>>;

/// What the four have in common, of the options themselves or of a part of them.
template <class Options, class Part>
void add_common(std::vector<Setting<Options>>& all, Part part) {
  using O = Options;
  all.push_back({"mounting", [=](O& o, double v) {
                   part(o).T_base_laser =
                       Transform2<frame::Base, frame::Laser>(SE2d(v, v, Angle::radians(v)));
                 }});
  all.push_back({"max_range_m", [=](O& o, double v) { part(o).max_range_m = v; }});
  all.push_back({"odometry floors", [=](O& o, double v) {
                   part(o).odometry.translation_floor_m = v;
                   part(o).odometry.heading_floor = Angle::radians(v);
                 }});
  all.push_back({"odometry rates", [=](O& o, double v) {
                   part(o).odometry.translation_per_m = v;
                   part(o).odometry.heading_per_rad = v;
                 }});
  all.push_back({"constant velocity", [=](O& o, double v) {
                   part(o).constant_velocity = {v, v, v, Angle::radians(v), v, v};
                 }});
  all.push_back({"tracked_score", [=](O& o, double v) { part(o).tracked_score = v; }});
  all.push_back({"lost_score", [=](O& o, double v) { part(o).lost_score = v; }});
}

template <class Options, class Part>
void add_submap(std::vector<Setting<Options>>& all, Part part) {
  using O = Options;
  all.push_back({"voxel_m", [=](O& o, double v) { part(o).voxel_m = v; }});
  all.push_back({"gyro", [=](O& o, double v) {
                   part(o).gyro_floor = Angle::radians(v);
                   part(o).gyro_per_rad = v;
                 }});
  all.push_back({"search_sigmas", [=](O& o, double v) { part(o).search_sigmas = v; }});
  all.push_back({"node_distance_m", [=](O& o, double v) { part(o).node_distance_m = v; }});
  all.push_back({"node_turn", [=](O& o, double v) { part(o).node_turn = Angle::radians(v); }});
  all.push_back({"independent_points", [=](O& o, double v) { part(o).independent_points = v; }});
  all.push_back({"min_score", [=](O& o, double v) { part(o).min_score = v; }});
  all.push_back({"loop gap", [=](O& o, double v) { part(o).loop_gap_travel_m = v; }});
  all.push_back({"loop overlap", [=](O& o, double v) { part(o).loop_overlap_m = v; }});
  all.push_back({"loop reach", [=](O& o, double v) { part(o).loop_reach_m = v; }});
  all.push_back({"loop cell", [=](O& o, double v) { part(o).loop_cell_m = v; }});
  all.push_back({"loop sigma", [=](O& o, double v) { part(o).loop_sigma_m = v; }});
  all.push_back(
      {"loop scores", [=](O& o, double v) { part(o).loop_score = part(o).wide_loop_score = v; }});
  all.push_back({"loop kernel", [=](O& o, double v) { part(o).loop_kernel_sigmas = v; }});
}

template <class Options, class Part>
void add_submap_counts(std::vector<Choice<Options>>& all, Part part) {
  using O = Options;
  all.push_back({"submap_nodes", [=](O& o, int n) { part(o).submap_nodes = n; }});
  all.push_back({"lost_scans", [=](O& o, int n) { part(o).lost_scans = n; }});
  all.push_back({"nodes_between_loops", [=](O& o, int n) { part(o).nodes_between_loops = n; }});
  all.push_back({"loop_latency_scans", [=](O& o, int n) { part(o).loop_latency_scans = n; }});
  all.push_back({"loop_context_nodes", [=](O& o, int n) { part(o).loop_context_nodes = n; }});
  all.push_back({"loops_per_search", [=](O& o, int n) { part(o).loops_per_search = n; }});
  all.push_back({"tables_kept", [=](O& o, int n) { part(o).tables_kept = n; }});
  all.push_back({"max_submaps", [=](O& o, int n) { part(o).max_submaps = n; }});
  all.push_back({"forgotten poses", [=](O& o, int n) { part(o).max_forgotten_poses = n; }});
  all.push_back({"threads", [=](O& o, int n) { part(o).threads = n; }});
  all.push_back({"match iterations", [=](O& o, int n) { part(o).match.max_iterations = n; }});
}

template <class Driver>
struct Settings;

template <>
struct Settings<GraphDriver> {
  using O = GraphSlamOptions;
  static O base() {
    O o;
    o.loop_gap_nodes = 5;
    o.loop_gap_travel_m = 1.5;
    return o;
  }
  static std::vector<Setting<O>> numbers() {
    std::vector<Setting<O>> all;
    add_common<O>(all, [](O& o) -> O& { return o; });
    all.push_back({"point_spacing_m", [](O& o, double v) { o.point_spacing_m = v; }});
    all.push_back({"node_distance_m", [](O& o, double v) { o.node_distance_m = v; }});
    all.push_back({"node_turn", [](O& o, double v) { o.node_turn = Angle::radians(v); }});
    all.push_back({"cell_m", [](O& o, double v) { o.cell_m = v; }});
    all.push_back({"local_radius_m", [](O& o, double v) { o.local_radius_m = v; }});
    all.push_back({"search_sigma_m", [](O& o, double v) { o.search_sigma_m = v; }});
    all.push_back({"sharp_sigma_m", [](O& o, double v) { o.sharp_sigma_m = v; }});
    all.push_back({"loop gap", [](O& o, double v) { o.loop_gap_travel_m = v; }});
    all.push_back({"loop overlap", [](O& o, double v) { o.loop_overlap_m = v; }});
    all.push_back({"loop reach", [](O& o, double v) { o.loop_reach_m = v; }});
    all.push_back({"loop scores", [](O& o, double v) { o.loop_score = o.wide_loop_score = v; }});
    all.push_back({"loop kernel", [](O& o, double v) { o.loop_kernel_sigmas = v; }});
    return all;
  }
  static std::vector<Choice<O>> counts() {
    return {{"local_nodes", [](O& o, int n) { o.local_nodes = n; }},
            {"sharp_nodes", [](O& o, int n) { o.sharp_nodes = n; }},
            {"nodes_between_loops", [](O& o, int n) { o.nodes_between_loops = n; }},
            {"loop_gap_nodes", [](O& o, int n) { o.loop_gap_nodes = n; }},
            {"loop_context_nodes", [](O& o, int n) { o.loop_context_nodes = n; }},
            {"loop_map_nodes", [](O& o, int n) { o.loop_map_nodes = n; }},
            {"loops_per_search", [](O& o, int n) { o.loops_per_search = n; }},
            {"threads", [](O& o, int n) { o.threads = n; }}};
  }
};

template <>
struct Settings<HectorDriver> {
  using O = HectorSlamOptions;
  static O base() { return {}; }
  static std::vector<Setting<O>> numbers() {
    std::vector<Setting<O>> all;
    add_common<O>(all, [](O& o) -> O& { return o; });
    all.push_back({"point_spacing_m", [](O& o, double v) { o.point_spacing_m = v; }});
    all.push_back({"map_travel_m", [](O& o, double v) { o.map_travel_m = v; }});
    all.push_back({"map_turn", [](O& o, double v) { o.map_turn = Angle::radians(v); }});
    all.push_back({"search_sigmas", [](O& o, double v) { o.search_sigmas = v; }});
    all.push_back({"independent_points", [](O& o, double v) { o.independent_points = v; }});
    all.push_back({"min_score", [](O& o, double v) { o.min_score = v; }});
    all.push_back({"start_step", [](O& o, double v) { o.match.start_step = Angle::radians(v); }});
    return all;
  }
  static std::vector<Choice<O>> counts() {
    return {{"iterations", [](O& o, int n) { o.match.max_iterations = n; }}};
  }
};

template <>
struct Settings<SubmapDriver> {
  using O = SubmapSlamOptions;
  static O base() {
    O o;
    o.submap_nodes = 6;
    o.loop_gap_travel_m = 1.0;
    o.loop_latency_scans = 2;
    return o;
  }
  static std::vector<Setting<O>> numbers() {
    std::vector<Setting<O>> all;
    const auto itself = [](O& o) -> O& { return o; };
    add_common<O>(all, itself);
    add_submap<O>(all, itself);
    return all;
  }
  static std::vector<Choice<O>> counts() {
    std::vector<Choice<O>> all;
    add_submap_counts<O>(all, [](O& o) -> O& { return o; });
    return all;
  }
};

template <>
struct Settings<PedestrianDriver> {
  using O = PedestrianSlamOptions;
  static O base() { return {}; }
  static std::vector<Setting<O>> numbers() {
    return {{"lowest", [](O& o, double v) { o.level.lowest_m = v; }},
            {"highest", [](O& o, double v) { o.level.highest_m = v; }},
            {"forward", [](O& o, double v) {
               o.pedestrian.forward = {v, v, v};
             }}};
  }
  static std::vector<Choice<O>> counts() {
    return {{"beams", [](O& o, int n) {
               o.level.beams = static_cast<std::size_t>(std::clamp(n, 1, 20'000));
             }}};
  }
};

template <class Driver>
class AbusedOptions : public ::testing::Test {};
using Drivers = ::testing::Types<GraphDriver, HectorDriver, SubmapDriver, PedestrianDriver>;
TYPED_TEST_SUITE(AbusedOptions, Drivers);

/// Poses are finite, one for each scan; a setting may make every scan an Error.
template <class Driver>
void expect_sane(const typename Driver::Options& options) {
  Driver driver(options);
  std::size_t accepted = 0;
  for (int k = 0; k < 26; ++k) {
    LaserScan scan = scan_of_drive(k);
    if (k == 9) scan.ranges_m.assign(kBeams, NAN);
    const auto outcome = driver.add(scan, k % 5 == 4 ? std::nullopt : odometry_of_drive(k));
    accepted += outcome ? 1 : 0;
  }
  (void)driver.finish();
  const std::vector<double> numbers = numbers_of(driver.trajectory());
  EXPECT_EQ(numbers.size(), 5 * accepted);
  EXPECT_TRUE(all_finite(numbers));
  EXPECT_LT(driver.map().tiles().tile_count(), 20'000U);
}

TYPED_TEST(AbusedOptions, Numbers) {
  for (const auto& [what, set] : Settings<TypeParam>::numbers())
    for (const double v : {0.0, -1.0, 1e-6, 1e9, kNan, kInf, -kInf}) {
      SCOPED_TRACE(std::string(what) + " = " + std::to_string(v));
      auto options = Settings<TypeParam>::base();
      set(options, v);
      expect_sane<TypeParam>(options);
    }
}

TYPED_TEST(AbusedOptions, Counts) {
  for (const auto& [what, set] : Settings<TypeParam>::counts())
    for (const int n :
         {0, 1, -1, std::numeric_limits<int>::max(), std::numeric_limits<int>::min()}) {
      SCOPED_TRACE(std::string(what) + " = " + std::to_string(n));
      auto options = Settings<TypeParam>::base();
      set(options, n);
      expect_sane<TypeParam>(options);
    }
}

}  // namespace
}  // namespace wayfare::tests
