#include <type_traits>

#include <gtest/gtest.h>

#include <wayfare/core/frame.hpp>

namespace wayfare {
namespace {

using frame::Base, frame::Laser, frame::Map, frame::Odom;

static_assert(std::is_same_v<decltype(Transform2<Map, Odom>() * Transform2<Odom, Base>()),
                             Transform2<Map, Base>>);
static_assert(std::is_same_v<decltype(Transform3<Map, Base>().inverse()), Transform3<Base, Map>>);
static_assert(std::is_same_v<decltype(Transform2<Map, Base>() * Point2<Base>()), Point2<Map>>);
static_assert(!std::is_convertible_v<SE2d, Transform2<Map, Base>>, "a bare pose has no frames");
static_assert(!std::is_convertible_v<Transform2<Map, Base>, Transform2<Odom, Base>>);
static_assert(sizeof(Transform2<Map, Base>) == sizeof(SE2d));

TEST(Frame, AChainIsTheProductOfItsGroups) {
  const Transform2<Map, Odom> T_map_odom(SE2d(5.0, 0.0, 90_deg));
  const Transform2<Odom, Base> T_odom_base(SE2d(1.0, 2.0, 0_deg));
  const Transform2<Base, Laser> T_base_laser(SE2d(0.5, 0.0, 0_deg));
  // A metre ahead of the laser is (2.5, 2) in odom; rotated by 90° and moved by 5 along x: (3,
  // 2.5).
  const Point2<Laser> p_laser{{1.0, 0.0}};
  const Point2<Map> p_map = T_map_odom * T_odom_base * T_base_laser * p_laser;
  EXPECT_LE((p_map.coordinates_m - Eigen::Vector2d(3.0, 2.5)).norm(), 1e-15);
}

TEST(Frame, InverseUndoes) {
  const Transform3<Map, Base> T_map_base(
      SE3d::exp((SE3d::Tangent() << 1, 2, 3, 0.4, 0.5, 0.6).finished()));
  const Point3<Base> p{{0.1, 0.2, 0.3}};
  const Point3<Base> back = T_map_base.inverse() * (T_map_base * p);
  EXPECT_LE((back.coordinates_m - p.coordinates_m).norm(), 1e-15);
  EXPECT_LE((T_map_base * T_map_base.inverse()).raw().log().norm(), 1e-15);
}

}  // namespace
}  // namespace wayfare
