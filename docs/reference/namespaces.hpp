#pragma once

// The namespaces of the library, for its reference.

/// Values, estimators and systems of all families that have no namespace of their own.
namespace wayfare {
/// Names of coordinate frames, as types of poses and points.
namespace frame {}
/// Angles in code, such as `90_deg`.
inline namespace literals {}
/// Carrier frequencies of satellites, Hz; blocks of the state of a carrier of a laser.
namespace carrier {}
/// Blocks of the state of dead reckoning in corridors.
namespace corridor {}
/// Blocks of the state of inertial navigation.
namespace ins {}
/// Places of the errors in the state of inertial navigation.
namespace ins_state {}
/// The Earth's ellipsoid and gravity.
namespace wgs84 {}
/// Device bytes to messages.
namespace decode {
/// Keys of an RPLIDAR's settings, with the values' types.
namespace rplidar_key {}
}  // namespace decode
/// Errors, consistency and tables.
namespace eval {}
/// Files.
namespace io {}
/// Several devices in one recording.
namespace logger {}
/// Messages, recordings and nodes.
namespace ros {}
/// Worlds, vehicles and walkers with their sensors.
namespace sim {}
/// Laws for types of one's own.
namespace testing {}
}  // namespace wayfare
