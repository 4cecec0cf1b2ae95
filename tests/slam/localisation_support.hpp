#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <Eigen/Core>

#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/localisation.hpp>

namespace wayfare {

// Looks the same after half a turn: nothing can tell the two ends apart.
inline constexpr const char* kSymmetric = R"(metres_per_character 0.5
route a b a
picture
########################
#                      #
#  a                b  #
#                      #
########################
)";

/// A run through a place, with truth, and its map.
struct Place {
  Recording recording;
  OccupancyGrid grid;
  std::shared_ptr<const LocalisationMap> map;
};
/// With 90 beams of 6 m all round, and wheels a little unlike.
Place make_place(const char* text, std::uint64_t seed);

/// The defaults with few particles.
LocalisationOptions quick();

Gaussian<SE2d> known_start(const Recording& recording);

LocalisationRun run(const Recording& recording, const Place& place,
                    const LocalisationOptions& options = quick(),
                    const std::optional<Gaussian<SE2d>>& start = {}, std::uint64_t seed = 1);

Eigen::Vector3d error_of(const LocalisationOutcome& o, const Recording& recording);

/// Believed at the end, and within 15 cm.
void expect_found(const LocalisationRun& result, const Recording& recording);
void expect_same(const LocalisationRun& a, const LocalisationRun& b);

}  // namespace wayfare
