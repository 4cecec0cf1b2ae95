#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <Eigen/Core>

#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/localisation.hpp>

namespace wayfare {

// Symmetric under rotation by 180°: the two ends cannot be distinguished.
inline constexpr const char* kSymmetric = R"(metres_per_character 0.5
route a b a
picture
########################
#                      #
#  a                b  #
#                      #
########################
)";

/// A recording in a place with its truth and map.
struct Place {
  Recording recording;
  OccupancyGrid grid;
  std::shared_ptr<const LocalisationMap> map;
};
/// With 90 beams of 6 m all round, and slightly different wheels.
Place make_place(const char* text, std::uint64_t seed);

/// The defaults with few particles.
LocalisationOptions quick();

Gaussian<SE2d> known_start(const Recording& recording);

LocalisationRun run(const Recording& recording, const Place& place,
                    const LocalisationOptions& options = quick(),
                    const std::optional<Gaussian<SE2d>>& start = {}, std::uint64_t seed = 1);

Eigen::Vector3d error_of(const LocalisationOutcome& o, const Recording& recording);

/// Converged at the end, within 15 cm.
void expect_found(const LocalisationRun& result, const Recording& recording);
void expect_same(const LocalisationRun& a, const LocalisationRun& b);

}  // namespace wayfare
