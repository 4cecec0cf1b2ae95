// Random maps, scans, odometry, transforms and initial poses, valid and not, in random order and on
// random clocks, to the node that localises: what it publishes is finite and of a scan that was
// offered, and the same messages give the same.

#include <wayfare/ros/localise_node.hpp>

#include <cmath>
#include <cstdint>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/ros/serialise.hpp>

#include "abuse/abuse.hpp"
#include "ros_random_messages.hpp"

namespace wayfare::ros {
namespace {

/// A room of 6 m x 4 m around the origin, in cells of a tenth of a metre.
OccupancyGrid room_map(Rng& rng) {
  OccupancyGrid map;
  map.header = {0, {1000, 0}, rng.below(8) == 0 ? "elsewhere" : "map"};
  map.info.resolution = 0.1F;
  map.info.width = 62, map.info.height = 42;
  map.info.origin = {{-3.1, -2.1, 0.0}, {0.0, 0.0, 0.0, 1.0}};
  for (std::uint32_t y = 0; y < 42; ++y)
    for (std::uint32_t x = 0; x < 62; ++x)
      map.data.push_back(x == 0 || x == 61 || y == 0 || y == 41 ? 100 : 0);
  switch (rng.below(12)) {
    case 0:
      map.info.width = static_cast<std::uint32_t>(rng.below(1ULL << 32U));
      break;
    case 1:
      map.info.resolution = static_cast<float>(any_number(rng));
      break;
    case 2:
      map.info.origin.position.x = any_number(rng);
      break;
    case 3:
      map.info.origin.orientation.z = any_number(rng);
      break;
    case 4:
      map.data[rng.below(map.data.size())] = static_cast<std::int8_t>(rng.below(256));
      break;
    default:
      break;
  }
  return map;
}

class LocaliseDrive {
 public:
  LocaliseDrive(std::uint64_t seed, LocaliseNodeOptions options)
      : rng_(seed), node_(std::move(options)) {}

  /// What the node published, as bytes.
  std::string run(int calls) {
    for (int i = 0; i < calls && !::testing::Test::HasFailure(); ++i) call();
    return published_;
  }
  [[nodiscard]] std::size_t poses() const { return poses_; }

 private:
  void call() {
    now_s_ += rng_.uniform(0.0, 0.2);
    const LogTime time = next_time(rng_, time_);
    switch (rng_.below(8)) {
      case 0:
        if (rng_.below(3) == 0) node_.add(room_map(rng_), now_s_);
        break;
      case 1:
      case 2:
      case 3:
        offered_.insert(time);
        node_.add(scan_message(time, rng_), now_s_);
        break;
      case 4:
      case 5:
        add_odometry(time);
        break;
      case 6:
        add_transforms(time);
        break;
      default:
        if (rng_.below(4) == 0) add_pose(time);
        if (rng_.below(20) == 0) node_.search_everywhere();
        break;
    }
    do take(node_.work(now_s_));
    while (node_.busy() && !::testing::Test::HasFailure());
  }

  void take(const LocaliseNodeOutput& out) {
    for (const PoseWithCovarianceStamped& p : out.poses) {
      ASSERT_TRUE(gaussian_of(p.pose)) << "a pose";
      ASSERT_TRUE(offered_.contains(*time_of(p.header.stamp)));
      published_ += to_cdr(p);
      ++poses_;
    }
    for (const TransformStamped& t : out.transforms) {
      ASSERT_TRUE(std::isfinite(t.transform.translation.x) && yaw_of(t.transform.rotation));
      published_ += to_cdr(TfMessage{{t}});
    }
    if (out.particles) {
      double weight = 0.0;
      for (const Particle& p : out.particles->particles) {
        ASSERT_TRUE(plane_pose_of(p.pose)) << "a particle";
        weight += p.weight;
      }
      ASSERT_NEAR(weight, 1.0, 1e-6);
      published_ += to_cdr(*out.particles);
    }
    for (const Notice& n : out.notices) published_ += n.text + '\n';
  }

  void add_odometry(LogTime time) {
    Odometry m = odometry_message(time, rng_);
    if (rng_.below(10) == 0) m.pose.pose.position.x = any_number(rng_);
    if (rng_.below(30) == 0) m.pose.pose.orientation.z = any_number(rng_);
    node_.add(m, now_s_);
  }
  void add_transforms(LogTime time) {
    TfMessage tf{
        {transform_of(SE2d(), time, "base_link", "laser"),
         transform_of(SE2d(0.01 * rng_.uniform(), 0.0, Angle()), time, "odom", "base_link")}};
    if (rng_.below(6) == 0) tf.transforms[0].transform.translation.x = any_number(rng_);
    if (rng_.below(6) == 0) tf.transforms[1].transform.rotation.w = any_number(rng_);
    node_.add(tf, now_s_);
  }
  void add_pose(LogTime time) {
    Gaussian<SE2d> pose{SE2d(0.1 * rng_.uniform(), 0.0, Angle())};
    pose.covariance *= 0.1;
    PoseWithCovarianceStamped m = message_of(pose, time, rng_.below(8) == 0 ? "odom" : "map");
    if (rng_.below(6) == 0) m.pose.pose.position.y = any_number(rng_);
    if (rng_.below(6) == 0) m.pose.covariance[rng_.below(36)] = any_number(rng_);
    node_.add(m, now_s_);
  }

  Rng rng_;
  LocaliseNode node_;
  LogTime time_ = kStart;
  double now_s_ = 50.0;
  std::set<LogTime> offered_;
  std::string published_;
  std::size_t poses_ = 0;
};

LocaliseNodeOptions some_options(std::uint64_t seed) {
  Rng rng = Rng(seed).stream(1);
  LocaliseNodeOptions o;
  o.localisation.max_particles = 300, o.localisation.min_unconverged = 200;
  o.localisation.min_particles = 50;
  o.localisation.min_candidates = 500, o.localisation.max_candidates = 1000;
  o.global = rng.below(2) == 0;
  if (rng.below(3) == 0) o.initial = Gaussian<SE2d>{};
  if (rng.below(2) == 0) o.source = OdometrySource::transforms;
  o.scans_waiting = rng.below(4) == 0 ? rng.below(3) : 50;
  if (rng.below(4) == 0) o.jump_back_s = rng.below(2) == 0 ? tests::kInf : 1e300;
  if (rng.below(4) == 0) o.odometry_gap_s = rng.below(2) == 0 ? tests::kInf : 0.0;
  if (rng.below(3) == 0) o.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d());
  return o;
}

TEST(LocaliseNodeSequences, OfMessagesAndNonsense) {
  std::size_t poses = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    LocaliseDrive drive(seed, some_options(seed));
    static_cast<void>(drive.run(150));
    poses += drive.poses();
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(poses, 200U);
}

TEST(LocaliseNodeSequences, TwoThreadsPublishTheSame) {
  const auto both =
      tests::in_two_threads([](int) { return LocaliseDrive(5, some_options(5)).run(150); });
  EXPECT_EQ(both[0], both[1]);
  EXPECT_FALSE(both[0].empty());
}

TEST(LocaliseNode, WithoutMessages) {
  LocaliseNode node;
  EXPECT_FALSE(node.busy());
  node.search_everywhere();
  EXPECT_TRUE(node.work(0.0).poses.empty());
  EXPECT_EQ(node.waits_for(), "a map");
  EXPECT_FALSE(node.outcome());
}

}  // namespace
}  // namespace wayfare::ros
