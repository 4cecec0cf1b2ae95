// The options of Monte-Carlo localisation and of its map at their limits and beyond.

#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "abuse/slam_localisation_support.hpp"

namespace wayfare::tests {
namespace {

TEST(AbusedLocalisationMap, OptionsAtTheirLimits) {
  using Set = std::function<void(LocalisationMapOptions&, double)>;
  const std::vector<std::pair<const char*, Set>> settings = {
      {"occupied", [](LocalisationMapOptions& o, double v) { o.occupied_probability = v; }},
      {"free", [](LocalisationMapOptions& o, double v) { o.free_probability = v; }},
      {"clearance", [](LocalisationMapOptions& o, double v) { o.clearance_m = v; }},
      {"sigma", [](LocalisationMapOptions& o, double v) { o.lidar.sigma_m = v; }},
      {"search sigma", [](LocalisationMapOptions& o, double v) { o.radar.search_sigma_m = v; }},
      {"floor", [](LocalisationMapOptions& o, double v) { o.radar.floor_probability = v; }},
      {"seen", [](LocalisationMapOptions& o, double v) { o.seen_probability = v; }},
  };
  for (const auto& [what, set] : settings)
    for (const double v : {0.0, -1.0, 1.0, 2.0, 1e-12, 1e9, kNan, kInf, -kInf}) {
      SCOPED_TRACE(std::string(what) + " = " + std::to_string(v));
      LocalisationMapOptions options;
      set(options, v);
      const auto map = LocalisationMap::make(grid_of_room(), options, &grid_of_room());
      if (!map) {
        EXPECT_FALSE(map.error().message.empty());
        continue;
      }
      Localiser localiser(*map, quick_options(), 1);
      for (int k = 0; k < 3; ++k) {
        const auto outcome = localiser.add_scan(scan_of_drive(k), odometry_of_drive(k));
        EXPECT_TRUE(outcome);
        EXPECT_TRUE(localiser.add_radar(time_of_drive(k), points_of_drive(k), {}));
      }
      EXPECT_TRUE(all_finite(numbers_of(localiser)));
    }
}

TEST(AbusedLocaliser, OptionsAtTheirLimits) {
  using Set = std::function<void(LocalisationOptions&, double)>;
  const std::vector<std::pair<const char*, Set>> numbers = {
      {"mounting",
       [](LocalisationOptions& o, double v) {
         o.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(v, v, Angle::radians(v)));
       }},
      {"independent",
       [](LocalisationOptions& o, double v) {
         o.independent_beams = o.independent_unconverged = o.radar.independent_points = v;
       }},
      {"max_range_m", [](LocalisationOptions& o, double v) { o.max_range_m = v; }},
      {"beam model",
       [](LocalisationOptions& o, double v) {
         o.beam = {v, v, v};
       }},
      {"update_travel_m", [](LocalisationOptions& o, double v) { o.update_travel_m = v; }},
      {"update_turn", [](LocalisationOptions& o, double v) { o.update_turn = Angle::radians(v); }},
      {"update_time_s", [](LocalisationOptions& o, double v) { o.update_time_s = v; }},
      {"noise",
       [](LocalisationOptions& o, double v) {
         o.odometry = o.constant_velocity = {v, v, v, Angle::radians(v), v, v};
       }},
      {"max_speed_m_s", [](LocalisationOptions& o, double v) { o.max_speed_m_s = v; }},
      {"max_turn_rate",
       [](LocalisationOptions& o, double v) { o.max_turn_rate = Angle::radians(v); }},
      {"kld_error", [](LocalisationOptions& o, double v) { o.kld_error = v; }},
      {"kld_quantile", [](LocalisationOptions& o, double v) { o.kld_quantile = v; }},
      {"bin_m", [](LocalisationOptions& o, double v) { o.bin_m = v; }},
      {"bin_turn", [](LocalisationOptions& o, double v) { o.bin_turn = Angle::radians(v); }},
      {"candidates_per_m2", [](LocalisationOptions& o, double v) { o.candidates_per_m2 = v; }},
      {"search_ratio", [](LocalisationOptions& o, double v) { o.search_ratio = v; }},
      {"kidnap_probability", [](LocalisationOptions& o, double v) { o.kidnap_probability = v; }},
      {"converged_mass", [](LocalisationOptions& o, double v) { o.converged_mass = v; }},
      {"converged_sigma_m", [](LocalisationOptions& o, double v) { o.converged_sigma_m = v; }},
      {"rejection_ratio", [](LocalisationOptions& o, double v) { o.rejection_ratio = v; }},
  };
  const auto drive = [](const LocalisationOptions& options) {
    for (const ScanLikelihood model : {ScanLikelihood::likelihood_field, ScanLikelihood::beam}) {
      LocalisationOptions with_model = options;
      with_model.model = model;
      Localiser localiser(map_of_room(), with_model, 1);
      for (int k = 0; k < 8; ++k) {
        EXPECT_TRUE(
            localiser.add_scan(scan_of_drive(k), k % 4 == 3 ? std::nullopt : odometry_of_drive(k)));
        EXPECT_TRUE(localiser.add_radar(time_of_drive(k), points_of_drive(k), {}));
      }
      EXPECT_TRUE(all_finite(numbers_of(localiser)));
      EXPECT_LE(localiser.particles().size(), 1000U);
    }
  };
  for (const auto& [what, set] : numbers)
    for (const double v : {0.0, -1.0, 1e-12, 1e9, kNan, kInf, -kInf}) {
      SCOPED_TRACE(std::string(what) + " = " + std::to_string(v));
      LocalisationOptions options = quick_options();
      set(options, v);
      drive(options);
    }
  using Choose = std::function<void(LocalisationOptions&)>;
  constexpr int kMost = std::numeric_limits<int>::max(), kLeast = std::numeric_limits<int>::min();
  const std::vector<std::pair<const char*, Choose>> counts = {
      {"no particles",
       [](LocalisationOptions& o) { o.min_particles = o.min_unconverged = o.max_particles = 0; }},
      {"one particle",
       [](LocalisationOptions& o) { o.min_particles = o.min_unconverged = o.max_particles = 1; }},
      {"fewer than the least", [](LocalisationOptions& o) { o.max_particles = 10; }},
      {"1e9 wanted", [](LocalisationOptions& o) { o.min_unconverged = 1'000'000'000; }},
      {"no candidates", [](LocalisationOptions& o) { o.min_candidates = o.max_candidates = 0; }},
      {"1e9 candidates at least", [](LocalisationOptions& o) { o.min_candidates = 1'000'000'000; }},
      {"1e9 candidates at most", [](LocalisationOptions& o) { o.max_candidates = 1'000'000'000; }},
      {"no beams", [](LocalisationOptions& o) { o.beams = o.min_beams = o.radar.points = 0; }},
      {"beams < 0",
       [](LocalisationOptions& o) {
         o.beams = o.min_beams = o.radar.points = o.radar.min_points = kLeast;
       }},
      {"all beams", [](LocalisationOptions& o) { o.beams = o.radar.points = kMost; }},
      {"too many beams needed",
       [](LocalisationOptions& o) { o.min_beams = o.radar.min_points = kMost; }},
      {"threads", [](LocalisationOptions& o) { o.threads = kMost; }},
      {"threads < 0", [](LocalisationOptions& o) { o.threads = kLeast; }},
      {"search always", [](LocalisationOptions& o) { o.scans_between_searches = kLeast; }},
      {"search never", [](LocalisationOptions& o) { o.scans_between_searches = kMost; }},
  };
  for (const auto& [what, set] : counts) {
    SCOPED_TRACE(what);
    LocalisationOptions options = quick_options();
    set(options);
    drive(options);
  }
}

}  // namespace
}  // namespace wayfare::tests
