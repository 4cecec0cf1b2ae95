#pragma once

// Satellites to measure ranges to.

#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/sensors/gnss.hpp>

namespace wayfare::sim {

/// A satellite at one instant, in the Earth-fixed axes of that instant.
struct SatelliteMotion {
  Eigen::Vector3d position_ecef_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_ecef_mps = Eigen::Vector3d::Zero();
  double clock_bias_s = 0.0;  ///< how far its clock is ahead
  double clock_drift = 0.0;   ///< s/s
};

/// Which satellites there are and where: nothing for one that is unknown at that time.
struct Constellation {
  std::vector<SatelliteId> satellites;
  std::function<std::optional<SatelliteMotion>(SatelliteId, Time<GpsClock>)> motion;
};

/// Circular orbits spread evenly: `planes` of equal inclination, equally spaced nodes (Walker
/// 1984).
struct WalkerParams {
  GnssSystem system = GnssSystem::gps;
  int satellites = 24;
  int planes = 6;
  int phasing = 1;  ///< between neighbouring planes, in 360°/satellites
  double radius_m = 26'559'710.0;
  Angle inclination = Angle::degrees(55.0);
  Angle first_node = Angle::degrees(17.0);  ///< east of Greenwich at GPS time zero
};

[[nodiscard]] Constellation walker_constellation(const WalkerParams& params = {});
/// The satellites of both, which must not name one twice.
[[nodiscard]] Constellation combined(Constellation a, Constellation b);
/// GPS (24 satellites in 6 planes) and Galileo (24 in 3): about 8 and 8 above 10°.
[[nodiscard]] Constellation gps_and_galileo();

/// The satellite as a range measured at `reception` sees it: where it was at transmission, in the
/// Earth-fixed axes of reception.
[[nodiscard]] std::optional<SatelliteMotion> seen_from(const Constellation& constellation,
                                                       SatelliteId satellite,
                                                       Time<GpsClock> reception,
                                                       const Eigen::Vector3d& receiver_ecef_m);

/// Above the horizon of a receiver.
[[nodiscard]] Angle elevation(const Geodetic& receiver, const Eigen::Vector3d& satellite_ecef_m);

}  // namespace wayfare::sim
