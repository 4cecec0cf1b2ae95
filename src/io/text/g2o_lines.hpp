#pragma once

// Private: how poses and measurements are written in g2o text.

#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include <wayfare/io/g2o.hpp>

#include "io/text/lines.hpp"

namespace wayfare::io {

/// The tags and pose format of planar and spatial lines.
template <class G>
struct Dialect;

template <>
struct Dialect<SE2d> {
  static constexpr std::string_view kVertex = "VERTEX_SE2";
  static constexpr std::string_view kLandmark = "VERTEX_XY";
  static constexpr std::string_view kEdge = "EDGE_SE2";
  static constexpr std::string_view kSensor = {};
  static constexpr std::size_t kNumbers = 3;

  static std::optional<SE2d> pose(const double* v) {
    return SE2d(v[0], v[1], Angle::radians(v[2]));
  }
  static void append(std::string& out, const SE2d& pose) {
    text::append_numbers(out, {pose.x(), pose.y(), pose.heading().radians()});
  }
};

template <>
struct Dialect<SE3d> {
  static constexpr std::string_view kVertex = "VERTEX_SE3:QUAT";
  static constexpr std::string_view kLandmark = "VERTEX_TRACKXYZ";
  static constexpr std::string_view kEdge = "EDGE_SE3:QUAT";
  static constexpr std::string_view kSensor = "PARAMS_SE3OFFSET";
  static constexpr std::size_t kNumbers = 7;

  static std::optional<SE3d> pose(const double* v) { return pose_of(v); }
  static void append(std::string& out, const SE3d& pose) {
    append_pose(out, pose.translation(), pose.rotation().quaternion());
  }
};

/// The lines of measurements: kTag; kNumbers of the measurement, and kFault, what is wrong with
/// those that `take` refuses; kDim of the information, which is the leading block of the edge's;
/// kSensor, whether the id of a sensor follows those of the vertices.
template <class E>
struct LineOf;

template <class E, int kSize>
struct VectorLine {
  static constexpr std::size_t kNumbers = kSize;
  static constexpr int kDim = kSize;
  static constexpr bool kSensor = kSize == 3;
  static constexpr const char* kFault = "";
  static bool take(E& edge, const double* v) {
    edge.measurement = Eigen::Map<const Eigen::Matrix<double, kSize, 1>>(v);
    return true;
  }
  static void append(std::string& out, const E& edge) {
    text::append_numbers(out, edge.measurement);
  }
};
template <class E, class G>
struct PoseLine {
  static constexpr std::size_t kNumbers = Dialect<G>::kNumbers;
  static constexpr int kDim = G::kDof;
  static constexpr bool kSensor = G::kDof == 6;
  static constexpr const char* kFault = "the quaternion does not have unit length";
  static bool take(E& edge, const double* v) {
    const std::optional<G> pose = Dialect<G>::pose(v);
    if (pose) edge.measurement = *pose;
    return pose.has_value();
  }
  static void append(std::string& out, const E& edge) { Dialect<G>::append(out, edge.measurement); }
};

template <>
struct LineOf<LandmarkPosition<SE2d>> : VectorLine<LandmarkPosition<SE2d>, 2> {
  static constexpr std::string_view kTag = "EDGE_SE2_XY";
};
template <>
struct LineOf<LandmarkPosition<SE3d>> : VectorLine<LandmarkPosition<SE3d>, 3> {
  static constexpr std::string_view kTag = "EDGE_SE3_TRACKXYZ";
};
template <>
struct LineOf<PositionOf<SE2d>> : VectorLine<PositionOf<SE2d>, 2> {
  static constexpr std::string_view kTag = "EDGE_PRIOR_SE2_XY";
};
template <>
struct LineOf<PositionOf<SE3d>> : VectorLine<PositionOf<SE3d>, 3> {
  static constexpr std::string_view kTag = "EDGE_SE3_XYZ_PRIOR";
};
template <>
struct LineOf<Prior<Eigen::Vector2d>> : VectorLine<Prior<Eigen::Vector2d>, 2> {
  static constexpr std::string_view kTag = "EDGE_PRIOR_XY";
};
template <>
struct LineOf<Prior<Eigen::Vector3d>> : VectorLine<Prior<Eigen::Vector3d>, 3> {
  static constexpr std::string_view kTag = "EDGE_POINTXYZ_PRIOR";
  static constexpr bool kSensor = false;
};
template <>
struct LineOf<PoseOf<SE2d>> : PoseLine<PoseOf<SE2d>, SE2d> {
  static constexpr std::string_view kTag = "EDGE_PRIOR_SE2";
};
template <>
struct LineOf<PoseOf<SE3d>> : PoseLine<PoseOf<SE3d>, SE3d> {
  static constexpr std::string_view kTag = "EDGE_SE3_PRIOR";
};
template <>
struct LineOf<BearingRange> {
  static constexpr std::string_view kTag = "EDGE_BEARING_SE2_XY";
  static constexpr std::size_t kNumbers = 1;
  static constexpr int kDim = 1;
  static constexpr bool kSensor = false;
  static constexpr const char* kFault = "";
  static bool take(BearingRange& edge, const double* v) {
    edge.bearing = Angle::radians(v[0]);
    edge.information.setZero();  // of the range, which the line does not have
    return true;
  }
  static void append(std::string& out, const BearingRange& edge) {
    text::append_numbers(out, {edge.bearing.radians()});
  }
};
template <>
struct LineOf<RangeTo<SE2d>> {
  static constexpr std::string_view kTag = "EDGE_RANGE_SE2_XY";
  static constexpr std::size_t kNumbers = 1;
  static constexpr int kDim = 1;
  static constexpr bool kSensor = false;
  static constexpr const char* kFault = "the distance is negative";
  static bool take(RangeTo<SE2d>& edge, const double* v) {
    edge.range_m = v[0];
    return v[0] >= 0.0;
  }
  static void append(std::string& out, const RangeTo<SE2d>& edge) {
    text::append_numbers(out, {edge.range_m});
  }
};

/// Whether planar (spatial) files have lines with this tag, FIX apart.
template <class G>
bool has_lines(std::string_view tag) {
  const auto is_one = []<class... E>(std::string_view t, const MeasurementLists<E...>&) {
    return ((t == LineOf<E>::kTag) || ...);
  };
  using D = Dialect<G>;
  const bool in_log =
      tag == "ODOMETRY" || tag == "LANDMARK" || tag == "BR" || tag == "VERTEX2" || tag == "EDGE2";
  return tag == D::kVertex || tag == D::kLandmark || tag == D::kEdge ||
         (!tag.empty() && tag == D::kSensor) || (in_log && G::kDof == 3) ||
         is_one(tag, typename GraphMeasurements<G>::Lists{});
}

}  // namespace wayfare::io
