#pragma once

// Frames as types at the border of the API: the type of a transform names both frames, so a
// mismatched chain does not compile. Inside, plain groups and Eigen vectors.

#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>

namespace wayfare {

/// REP-105 indoors (x forward, y left, z up); add your own tag as an empty struct.
namespace frame {
struct Map {};    ///< fixed to the world, drift-free, may jump
struct Odom {};   ///< fixed to the world, continuous, drifts
struct Base {};   ///< the robot: x forward, y left
struct Laser {};  ///< the range finder: bearing 0 along x
struct Radar {};  ///< the radar: x along its boresight, y left, z up
struct Ned {};    ///< local level: north, east, down
struct Enu {};    ///< local level: east, north, up
struct Body {};   ///< vehicle: forward, right, down
}  // namespace frame

/// A point expressed in `Frame`, metres.
template <class Frame, int N>
struct Point {
  Eigen::Matrix<double, N, 1> coordinates_m =
      Eigen::Matrix<double, N, 1>::Zero();  ///< in the axes of `Frame`
};
/// A point in the plane, m.
template <class Frame>
using Point2 = Point<Frame, 2>;
/// A point in space, m.
template <class Frame>
using Point3 = Point<Frame, 3>;

/// `T_to_from`: takes coordinates in `From` to coordinates in `To`; equally the pose of `From` in
/// `To`.
template <class To, class From, class Group>
class Transform {
 public:
  Transform() = default;
  /// Adds the frames to a group element.
  explicit Transform(Group raw) : raw_(std::move(raw)) {}

  /// The group element without frames.
  [[nodiscard]] const Group& raw() const { return raw_; }

  /// T_from_to.
  [[nodiscard]] Transform<From, To, Group> inverse() const {
    return Transform<From, To, Group>(raw_.inverse());
  }

  /// T_to_from * T_from_other = T_to_other.
  template <class Mid, class Other>
  Transform<To, Other, Group> operator*(const Transform<Mid, Other, Group>& next) const {
    static_assert(std::is_same_v<From, Mid>,
                  "wayfare: inner frames differ; T_a_b * T_b_c needs the same b on both sides");
    return Transform<To, Other, Group>(raw_ * next.raw());
  }

  /// The same point in `To`.
  template <class Frame, int N>
  Point<To, N> operator*(const Point<Frame, N>& p) const {
    static_assert(std::is_same_v<From, Frame>,
                  "wayfare: the point is not in this transform's source frame");
    return {raw_ * p.coordinates_m};
  }

 private:
  Group raw_{};
};

/// A pose in the plane with its frames: p_to = T_to_from p_from.
template <class To, class From>
using Transform2 = Transform<To, From, SE2d>;
/// A pose in space with its frames: p_to = T_to_from p_from.
template <class To, class From>
using Transform3 = Transform<To, From, SE3d>;

}  // namespace wayfare
