// Poses, frames and differences: where in the map a laser sees a point, how a pose moves along a
// tangent vector, and how an uncertain heading becomes an uncertain position.
#include <cmath>
#include <cstdio>

#include <wayfare/core/frame.hpp>
#include <wayfare/core/gaussian.hpp>

using namespace wayfare;

int main() {
  // T_map_base takes coordinates of the robot to the map. The types name both frames:
  // T_base_laser * T_map_base does not compile.
  const Transform2<frame::Map, frame::Base> T_map_base(SE2d(2.0, 1.0, 90_deg));
  const Transform2<frame::Base, frame::Laser> T_base_laser(SE2d(0.3, 0.0, 0_deg));
  const Point2<frame::Laser> seen{{4.0, 0.5}};
  const Point2<frame::Map> place = T_map_base * T_base_laser * seen;
  std::printf("seen at (%.1f, %.1f)\n", place.coordinates_m.x(), place.coordinates_m.y());

  // plus() moves a pose along an arc in its own axes: forward, left, turn. minus() is the inverse.
  const SE2d start(0.0, 0.0, 0_deg);
  const double quarter = (90_deg).radians();
  const SE2d end = start.plus({quarter, 0.0, quarter});  // of a circle with a radius of 1 m
  const SE2d half_way = interpolate(start, end, 0.5);
  std::printf("end (%.2f, %.2f) at %.0f degrees, half way (%.2f, %.2f)\n", end.x(), end.y(),
              end.heading().degrees(), half_way.x(), half_way.y());
  std::printf("length of the arc %.3f m\n", end.minus(start).x());

  // Differences of headings wrap.
  const SO2d before(179_deg), after(-179_deg);
  std::printf("turned by %.0f degrees\n", Angle::radians(after.minus(before)[0]).degrees());

  // A heading known to 1 degree, then 10 m straight ahead.
  const Eigen::Vector3d sigma(0.0, 0.0, (1_deg).radians());
  const Gaussian<SE2d> uncertain{SE2d(), sigma.cwiseAbs2().asDiagonal()};
  const Gaussian<SE2d> straight{SE2d(10.0, 0.0, 0_deg), Eigen::Matrix3d::Zero()};
  const Gaussian<SE2d> there = compose(uncertain, straight);
  std::printf("sigma ahead %.3f m, aside %.3f m\n", std::sqrt(there.covariance(0, 0)),
              std::sqrt(there.covariance(1, 1)));
}
