// Random messages, valid and not, in random order and on random clocks, to the nodes. Beside them a
// list of the scans that were offered: every pose published is of one of them, in their order, all
// numbers are finite, and the same messages give the same.

#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/ros/nodes.hpp>
#include <wayfare/ros/serialise.hpp>

#include "abuse/abuse.hpp"
#include "ros_random_messages.hpp"

namespace wayfare::ros {
namespace {

wayfare::RadarScan radar_scan(LogTime time, Rng& rng) {
  wayfare::RadarScan scan{time, {}};
  for (std::uint64_t n = rng.below(12); n > 0; --n)
    scan.points.push_back({static_cast<float>(rng.uniform(1.0, 4.0)),
                           static_cast<float>(rng.uniform(-2.0, 2.0)), 0.0F, 0.0F, 15.0F});
  return scan;
}

/// Everything the node published, as text.
struct Published {
  std::string bytes;
  std::vector<LogTime> poses;
  std::size_t restarts = 0;
};

void expect_sane(const SlamNodeOutput& out) {
  for (const auto& p : out.poses) ASSERT_TRUE(gaussian_of(p.pose)) << "a pose";
  if (out.particles) {
    for (const Pose& p : out.particles->poses) ASSERT_TRUE(plane_pose_of(p)) << "a particle";
  }
  for (const TransformStamped& t : out.transforms)
    ASSERT_TRUE(std::isfinite(t.transform.translation.x) &&
                std::isfinite(t.transform.translation.y) && yaw_of(t.transform.rotation))
        << "a transform";
  if (out.path) {
    for (const PoseStamped& p : out.path->poses) ASSERT_TRUE(plane_pose_of(p.pose));
  }
  if (out.map) {
    ASSERT_EQ(out.map->data.size(), std::size_t{out.map->info.width} * out.map->info.height);
    ASSERT_LT(out.map->data.size(), std::size_t{1} << 26);
  }
}

class Drive {
 public:
  Drive(std::uint64_t seed, SlamNodeOptions options)
      : rng_(seed), samples_(options.system != LaserSystem::submap), node_(std::move(options)) {}

  Published run(int calls) {
    for (int i = 0; i < calls && !::testing::Test::HasFailure(); ++i) call();
    take(node_.finish(now_s_));
    for (const LogTime time : published_.poses) EXPECT_TRUE(offered_.contains(time));
    // In order of time within a map; the notice of a new one is not repeated at once.
    std::size_t back = 0;
    for (std::size_t i = 1; i < published_.poses.size(); ++i)
      back += published_.poses[i] <= published_.poses[i - 1] ? 1 : 0;
    EXPECT_TRUE(back == 0 || published_.restarts > 0);
    EXPECT_LE(published_.poses.size(), offers_);
    return published_;
  }

 private:
  void take(const SlamNodeOutput& out) {
    expect_sane(out);
    for (const auto& p : out.poses) {
      published_.poses.push_back(*time_of(p.header.stamp));
      published_.bytes += to_cdr(p);
    }
    for (const TransformStamped& t : out.transforms) published_.bytes += to_cdr(TfMessage{{t}});
    if (out.map) published_.bytes += to_cdr(*out.map);
    for (const Notice& n : out.notices) {
      published_.bytes += n.text + '\n';
      published_.restarts += n.text.find("begins a new map") != std::string::npos ? 1 : 0;
    }
  }

  void call() {
    now_s_ += rng_.uniform(0.0, 0.2);
    const LogTime time = next_time(rng_, time_);
    switch (rng_.below(8)) {
      case 0:
      case 1:
        offer(time);
        node_.add(scan_message(time, rng_), now_s_);
        break;
      case 2:
        offer(time);
        if (rng_.below(10) == 0) {
          node_.add(cloud_of(radar_scan(time, rng_), "radar"), now_s_);
        } else {
          node_.add(message_of(radar_scan(time, rng_), "radar"), now_s_);
        }
        break;
      case 3:
      case 4:
        add_odometry(time);
        break;
      case 5:
        add_turn_rate(time);
        break;
      case 6:
        if (rng_.below(3) == 0) add_transforms(time);
        break;
      default:
        break;
    }
    do take(node_.work(now_s_));
    while (node_.busy() && !::testing::Test::HasFailure());
  }

  void offer(LogTime time) {
    offered_.insert(time);
    ++offers_;
  }
  void add_odometry(LogTime time) {
    Odometry m = odometry_message(time, rng_);
    if (rng_.below(10) == 0) m.pose.pose.position.x = any_number(rng_);
    if (rng_.below(10) == 0) m.pose.pose.position.y = any_number(rng_);
    if (rng_.below(30) == 0) m.pose.pose.orientation.z = any_number(rng_);
    node_.add(m, now_s_);
  }
  void add_turn_rate(LogTime time) {
    if (samples_) return add_sample(time);
    Imu m = message_of(GyroSample{time, 0.01 * rng_.uniform()}, "imu");
    if (rng_.below(10) == 0) m.angular_velocity.x = any_number(rng_);
    node_.add(m, now_s_);
  }
  void add_sample(LogTime time) {
    const Eigen::Vector3d rate(0.01 * rng_.uniform(), 0.0, 0.1), force(0.0, 0.2, 9.8);
    Imu m = message_of(ImuSample{time, rate, force}, rng_.below(30) == 0 ? "other" : "imu");
    if (rng_.below(10) == 0) m.linear_acceleration.x = any_number(rng_);
    if (rng_.below(10) == 0) m.angular_velocity.z = any_number(rng_);
    node_.add(m, now_s_);
    MagneticField field = magnetic_message_of({20.0, 0.0, -40.0}, time, "imu");
    if (rng_.below(10) == 0) field.magnetic_field.y = any_number(rng_);
    if (rng_.below(2) == 0) node_.add(field, now_s_);
  }
  void add_transforms(LogTime time) {
    TfMessage tf;
    for (const char* frame : {"laser", "radar", "imu"})
      tf.transforms.push_back(transform_of(SE2d(0.2, 0.0, Angle()), time, "base_link", frame));
    if (rng_.below(6) == 0) tf.transforms[0].transform.translation.x = any_number(rng_);
    if (rng_.below(6) == 0) tf.transforms[1].transform.rotation.w = any_number(rng_);
    node_.add(tf);
  }

  Rng rng_;
  bool samples_;
  SlamNode node_;
  LogTime time_ = kStart;
  double now_s_ = 50.0;
  std::set<LogTime> offered_;
  std::size_t offers_ = 0;
  Published published_;
};

SlamNodeOptions any_options(std::uint64_t seed) {
  Rng rng = Rng(seed).stream(1);
  SlamNodeOptions o;
  o.odometry = rng.below(2) == 0;
  o.imu = rng.below(2) == 0;
  o.scans_waiting = rng.below(4) == 0 ? rng.below(3) : 50;
  o.map_period_s = rng.below(3) == 0 ? 0.5 : 5.0;
  if (rng.below(4) == 0) o.jump_back_s = rng.below(2) == 0 ? tests::kInf : 1e300;
  if (rng.below(4) == 0) o.odometry_gap_s = rng.below(2) == 0 ? tests::kInf : 0.0;
  if (rng.below(3) == 0) o.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d());
  return o;
}

TEST(SlamNodeSequences, OfScansOdometryAndNonsense) {
  std::size_t poses = 0;
  for (std::uint64_t seed = 0; seed < 120; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    poses += Drive(seed, any_options(seed)).run(60).poses.size();
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(poses, 500U);
}

TEST(SlamNodeSequences, WithRadar) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SlamNodeOptions options = any_options(seed);
    options.sensors = seed % 2 == 0 ? SlamSensors::radar : SlamSensors::both;
    static_cast<void>(Drive(seed, options).run(60));
    ASSERT_FALSE(HasFailure());
  }
}

TEST(SlamNodeSequences, OfAWalkerAndByHector) {
  std::size_t poses = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SlamNodeOptions options = any_options(seed);
    options.system = seed % 2 == 0 ? LaserSystem::hector : LaserSystem::pedestrian;
    options.magnetometer = seed % 3 == 0;
    if (seed % 4 < 2) options.unit_forward = Eigen::Vector3d::UnitX();
    poses += Drive(seed, options).run(60).poses.size();
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(poses, 200U);
}

TEST(SlamNodeSequences, TwoThreadsPublishTheSame) {
  const auto both = tests::in_two_threads([](int) { return Drive(5, {}).run(100).bytes; });
  EXPECT_EQ(both[0], both[1]);
  EXPECT_FALSE(both[0].empty());
}

// Without anything, of nothing, and left in the middle of work.
TEST(SlamNode, WithoutMessages) {
  SlamNode node;
  EXPECT_FALSE(node.busy());
  EXPECT_TRUE(node.finish(0.0).poses.empty());
  EXPECT_TRUE(node.work(0.0).poses.empty());
  EXPECT_FALSE(node.waits_for().empty());
  node.add(LaserScan{}, 1.0);
  node.add(Odometry{}, 1.0);
  node.add(TfMessage{}), node.add(TfMessage{{TransformStamped{}}});
  EXPECT_TRUE(node.work(1.0).poses.empty());
  Rng rng(1);
  node.add(scan_message(kStart, rng), 2.0);
  SlamNode elsewhere(std::move(node));
  EXPECT_TRUE(elsewhere.work(2.0).poses.empty());
}

TEST(PedestrianNodeSequences, OfReadingsAndNonsense) {
  std::size_t steps = 0;
  const auto run = [](std::uint64_t seed) {
    Rng rng(seed);
    PedestrianNodeOptions options;
    if (rng.below(3) == 0) options.jump_back_s = tests::kInf;
    PedestrianNode node(options);
    std::string bytes;
    std::size_t count = 0;
    const auto take = [&](const PedestrianNodeOutput& out) {
      for (const Odometry& m : out.odometry) {
        EXPECT_TRUE(plane_pose_of(m.pose.pose));
        for (const double c : m.pose.covariance) EXPECT_TRUE(std::isfinite(c));
        EXPECT_TRUE(std::isfinite(m.twist.twist.linear.x));
        bytes += to_cdr(m);
        ++count;
      }
      for (const Notice& n : out.notices) bytes += n.text;
    };
    LogTime time = kStart;
    for (int i = 0; i < 1500 && !HasFailure(); ++i) {
      time += Duration(10'000'000);
      const double t = 0.01 * i, now_s = 5.0 + t;
      const LogTime stamp = rng.below(100) == 0   ? time - Duration(kSecond * 3)
                            : rng.below(100) == 0 ? LogTime()
                                                  : time;
      const double bob = t < 2.0 ? 0.0 : 3.0 * std::sin(4.0 * std::numbers::pi * t);
      Imu imu = message_of(ImuSample{stamp, {0, 0, 0.1}, {0, 0, 9.81 + bob}}, "imu");
      if (rng.below(50) == 0) imu.angular_velocity.y = any_number(rng);
      if (rng.below(50) == 0) imu.linear_acceleration.x = any_number(rng);
      take(node.add(imu, now_s));
      if (i % 5 != 0) continue;
      Eigen::Vector3d field(20.0, 0.0, -40.0);
      if (rng.below(10) == 0) field.x() = any_number(rng);
      take(node.add(magnetic_message_of(field, stamp, "imu"), now_s));
      take(node.idle(now_s));
    }
    return std::pair(bytes, count);
  };
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    steps += run(seed).second;
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(steps, 100U);
  const auto both = tests::in_two_threads([&](int) { return run(7).first; });
  EXPECT_EQ(both[0], both[1]);
}

}  // namespace
}  // namespace wayfare::ros
