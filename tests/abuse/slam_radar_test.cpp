// The particle filter on radar and LiDAR: motion and scans that are none, detections far away,
// times near the limits, options at their limits.

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

#include "abuse/slam_radar_support.hpp"

namespace wayfare::tests {
namespace {

Gaussian<SE2d> motion(const SE2d& mean, const Eigen::Matrix3d& covariance) {
  return {mean, covariance};
}

TEST(AbusedRadarSlam, WithoutScansIsEmpty) {
  RadarSlam slam(few_particles());
  EXPECT_TRUE(slam.trajectory().empty());
  EXPECT_FALSE(slam.pose());
  EXPECT_FALSE(slam.lidar_map().bounds() || slam.radar_map().bounds());
  EXPECT_TRUE(slam.particles().empty() && slam.log_weights().empty());
  EXPECT_TRUE(slam.move(motion_of_drive(0)));
  EXPECT_FALSE(slam.pose());
}

// "Returns an Error for non-finite values or a covariance that is not positive semi-definite": of
// every position in the matrix, not only of its diagonal.
TEST(AbusedRadarSlam, RefusesMotionThatIsNone) {
  RadarSlam slam(few_particles()), spared(few_particles());
  const SE2d ahead(0.1, 0.0, 0.01_rad);
  const Eigen::Matrix3d good = motion_of_drive(0).covariance;
  const auto refuse = [&](const Gaussian<SE2d>& g, const std::string& what) {
    const auto moved = slam.move(g);
    ASSERT_FALSE(moved) << what;
    EXPECT_FALSE(moved.error().message.empty());
  };
  for (int k = 0; k < 6; ++k) {
    for (const double bad : kNotFinite) {
      refuse(motion(SE2d(bad, 0.0, Angle{}), good), "x");
      refuse(motion(SE2d(0.0, bad, Angle{}), good), "y");
      refuse(motion(SE2d(0.0, 0.0, Angle::radians(bad)), good), "heading");
      for (int i = 0; i < 9; ++i) {
        Eigen::Matrix3d c = good;
        c(i / 3, i % 3) = bad;
        refuse(motion(ahead, c), "element " + std::to_string(i));
      }
    }
    for (int i = 0; i < 3; ++i) {
      Eigen::Matrix3d c = good;
      c(i, i) = -c(i, i);
      refuse(motion(ahead, c), "a negative variance");
      c = good;
      const int a = i, b = (i + 1) % 3;
      c(a, b) = c(b, a) = 1.01 * std::sqrt(c(a, a) * c(b, b));
      refuse(motion(ahead, c), "a correlation above one");
      c = good;
      c(a, b) = 0.5 * std::sqrt(c(a, a) * c(b, b));
      refuse(motion(ahead, c), "not symmetric");
      c = Eigen::Matrix3d::Zero();
      c(a, b) = c(b, a) = 1e-6;
      refuse(motion(ahead, c), "covariances without variances");
    }
    EXPECT_TRUE(slam.move(motion_of_drive(k)) && spared.move(motion_of_drive(k)));
    EXPECT_TRUE(slam.add_lidar(scan_of_drive(k)) && spared.add_lidar(scan_of_drive(k)));
  }
  EXPECT_EQ(numbers_of(slam), numbers_of(spared));
}

// No variance at all, one direction without any, and correlated to the limit.
TEST(AbusedRadarSlam, AcceptsSingularMotion) {
  Eigen::Matrix3d along = Eigen::Matrix3d::Zero();
  along(0, 0) = 1e-4;
  const Eigen::Vector3d v(0.1, -0.02, 0.03);
  for (const Eigen::Matrix3d& c :
       {Eigen::Matrix3d(Eigen::Matrix3d::Zero()), along, Eigen::Matrix3d(v * v.transpose()),
        Eigen::Matrix3d(1e-300 * Eigen::Matrix3d::Identity())}) {
    RadarSlam slam(few_particles());
    for (int k = 0; k < 12; ++k) {
      EXPECT_TRUE(slam.move(motion(motion_of_drive(k).mean, c)));
      EXPECT_TRUE(slam.add_lidar(scan_of_drive(k)));
      EXPECT_TRUE(slam.add_radar(time_of_drive(k), detections_of_drive(k)));
    }
    EXPECT_TRUE(all_finite(numbers_of(slam.trajectory())));
  }
}

TEST(AbusedRadarSlam, MotionBeyondUse) {
  for (const double size : {1e3, 1e6, 1e9, 1e20, 1e100, 1e300}) {
    SCOPED_TRACE(size);
    RadarSlam slam(few_particles());
    for (int k = 0; k < 12; ++k) {
      (void)slam.move(k % 4 == 3 ? motion(SE2d(size, -size, Angle::radians(size)),
                                          size * Eigen::Matrix3d::Identity())
                                 : motion_of_drive(k));
      (void)slam.add_lidar(scan_of_drive(k));
      (void)slam.add_radar(time_of_drive(k), detections_of_drive(k));
    }
    EXPECT_TRUE(all_finite(numbers_of(slam.trajectory())));
    EXPECT_LT(slam.lidar_map().tiles().tile_count(), 5000U);
  }
}

TEST(AbusedRadarSlam, RefusesScansThatAreNone) {
  RadarSlam slam(few_particles()), spared(few_particles());
  const auto none = [](float x, float y) {
    PointSet points = detections_of_drive(0);
    points.push_back({x, y});
    return points;
  };
  for (int k = 0; k < 5; ++k) {
    const LogTime now = time_of_drive(k);
    EXPECT_TRUE(slam.move(motion_of_drive(k)) && spared.move(motion_of_drive(k)));
    for (const float bad : {NAN, INFINITY, -INFINITY}) {
      EXPECT_FALSE(slam.add_radar(now, none(bad, 0.0F)));
      EXPECT_FALSE(slam.add_radar(now, none(0.0F, bad)));
      LaserScan scan = scan_of_drive(k);
      scan.first_bearing = Angle::radians(static_cast<double>(bad));
      EXPECT_FALSE(slam.add_lidar(scan));
      scan = scan_of_drive(k);
      scan.bearing_step = Angle::radians(static_cast<double>(bad));
      EXPECT_FALSE(slam.add_lidar(scan));
    }
    LaserScan scan = scan_of_drive(k);
    scan.ranges_m.clear();
    EXPECT_FALSE(slam.add_lidar(scan));
    scan = scan_of_drive(k);
    scan.bearing_step = Angle::radians(1e307);
    EXPECT_FALSE(slam.add_lidar(scan));
    EXPECT_TRUE(slam.add_radar(now, detections_of_drive(k)));
    EXPECT_TRUE(spared.add_radar(now, detections_of_drive(k)));
    EXPECT_FALSE(slam.add_radar(now, detections_of_drive(k)));
    EXPECT_FALSE(slam.add_lidar(scan_of_drive(k - 1)));
    EXPECT_TRUE(slam.add_lidar(scan_of_drive(k)) && spared.add_lidar(scan_of_drive(k)));
    EXPECT_FALSE(slam.add_lidar(scan_of_drive(k)));
  }
  EXPECT_EQ(numbers_of(slam), numbers_of(spared));
}

// A finite detection beyond any radar's range must not grow the map: each would take a tile.
TEST(AbusedRadarSlam, DetectionsFarAway) {
  for (const float far : {1e3F, 1e6F, 1e9F, 1e38F}) {
    SCOPED_TRACE(far);
    RadarSlam slam(few_particles());
    Rng rng(1);
    for (int k = 0; k < 10; ++k) {
      PointSet points = detections_of_drive(k);
      for (int i = 0; i < 500; ++i) {
        const double turn = rng.uniform(-3.0, 3.0), share = rng.uniform(0.5, 1.0);
        points.push_back({static_cast<float>(share * std::cos(turn)) * far,
                          static_cast<float>(share * std::sin(turn)) * far});
      }
      EXPECT_TRUE(slam.move(motion_of_drive(k)));
      EXPECT_TRUE(slam.add_radar(time_of_drive(k), points));
    }
    EXPECT_TRUE(all_finite(numbers_of(slam.trajectory())));
    EXPECT_LT(slam.radar_map().tiles().tile_count(), 50U);
  }
}

TEST(AbusedRadarSlam, OddScans) {
  const std::vector<std::function<void(LaserScan&)>> changes = {
      [](LaserScan& s) { s.ranges_m.resize(1); },
      [](LaserScan& s) { s.ranges_m.assign(kBeams, NAN); },
      [](LaserScan& s) {
        s.max_range_m = INFINITY;
        s.ranges_m.assign(kBeams, 3e38F);
      },
      [](LaserScan& s) { s.ranges_m.assign(kBeams, s.min_range_m); },
      [](LaserScan& s) {
        s.min_range_m = -9.0F;
        for (float& r : s.ranges_m) r = -r;
      },
      [](LaserScan& s) { s.bearing_step = Angle{}; },
      [](LaserScan& s) { s.first_bearing = Angle::radians(1e9); },
      [](LaserScan& s) { s.ranges_m.assign(40'000, 3.0F); },
  };
  for (std::size_t i = 0; i < changes.size(); ++i)
    for (const int at : {0, 1, 5}) {
      SCOPED_TRACE("change " + std::to_string(i) + " at scan " + std::to_string(at));
      RadarSlam slam(few_particles());
      for (int k = 0; k < 8; ++k) {
        LaserScan scan = scan_of_drive(k);
        if (k == at) changes[i](scan);
        EXPECT_TRUE(slam.move(motion_of_drive(k)));
        (void)slam.add_lidar(scan);
        EXPECT_TRUE(
            slam.add_radar(time_of_drive(k), k == at ? PointSet() : detections_of_drive(k)));
      }
      EXPECT_EQ(slam.trajectory().size(), 16U);
      EXPECT_TRUE(all_finite(numbers_of(slam.trajectory())));
      EXPECT_LT(slam.lidar_map().tiles().tile_count(), 5000U);
    }
}

TEST(AbusedRadarSlam, TimesAtTheLimits) {
  using Limits = std::numeric_limits<std::int64_t>;
  RadarSlam slam(few_particles());
  int k = 0;
  for (const std::int64_t ns : {Limits::min(), Limits::min() + 1, std::int64_t{0},
                                std::int64_t{1'000'000'000'000'000'000}, Limits::max()}) {
    EXPECT_TRUE(slam.move(motion_of_drive(k)));
    const LogTime time = LogTime::from_nanoseconds(ns);
    EXPECT_TRUE(slam.add_lidar(scan_of_room(time, pose_of_drive(k))));
    EXPECT_TRUE(slam.add_radar(time, detections_of_drive(k)));
    ++k;
  }
  EXPECT_EQ(slam.trajectory().size(), 10U);
  EXPECT_TRUE(all_finite(numbers_of(slam.trajectory())));
}

TEST(AbusedRadarSlam, LivesAsAValue) {
  const auto drive = [](RadarSlam& slam, int from, int to) {
    for (int k = from; k < to; ++k) {
      EXPECT_TRUE(slam.move(motion_of_drive(k)));
      EXPECT_TRUE(slam.add_lidar(scan_of_drive(k)));
    }
  };
  const auto make = [&] {
    RadarSlam slam(few_particles());
    drive(slam, 0, 4);
    return slam;
  };
  expect_move_semantics(make, [&](RadarSlam& slam) {
    drive(slam, 4, 8);
    return numbers_of(slam);
  });
  const auto results = in_two_threads([&](int) {
    RadarSlamOptions options = few_particles();
    options.threads = 2;
    RadarSlam slam(options);
    drive(slam, 0, 8);
    return numbers_of(slam);
  });
  EXPECT_EQ(results[0], results[1]);
}

TEST(AbusedRadarSlam, OptionsAtTheirLimits) {
  using Set = std::function<void(RadarSlamOptions&, double)>;
  const std::vector<std::pair<const char*, Set>> numbers = {
      {"mounting",
       [](RadarSlamOptions& o, double v) {
         o.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(v, v, Angle::radians(v)));
       }},
      {"sigma", [](RadarSlamOptions& o, double v) { o.lidar.field.sigma_m = v; }},
      {"floor", [](RadarSlamOptions& o, double v) { o.lidar.field.floor_probability = v; }},
      {"independent",
       [](RadarSlamOptions& o, double v) {
         o.lidar.independent_points = o.radar.independent_points = v;
       }},
      {"min_score",
       [](RadarSlamOptions& o, double v) { o.lidar.min_score = o.radar.min_score = v; }},
      {"tracked_score", [](RadarSlamOptions& o, double v) { o.lidar.tracked_score = v; }},
      {"wide_m", [](RadarSlamOptions& o, double v) { o.lidar.wide_m = o.radar.wide_m = v; }},
      {"wide_turn", [](RadarSlamOptions& o, double v) { o.lidar.wide_turn = Angle::radians(v); }},
      {"wide_margin", [](RadarSlamOptions& o, double v) { o.lidar.wide_margin_nats = v; }},
      {"max_correction_m",
       [](RadarSlamOptions& o, double v) {
         o.lidar.max_correction_m = o.radar.max_correction_m = v;
       }},
      {"max_turn_correction",
       [](RadarSlamOptions& o, double v) { o.lidar.max_turn_correction = Angle::radians(v); }},
      {"search_sigmas",
       [](RadarSlamOptions& o, double v) { o.lidar.search_sigmas = o.radar.search_sigmas = v; }},
      {"max_range_m",
       [](RadarSlamOptions& o, double v) { o.lidar.max_range_m = o.radar.max_range_m = v; }},
      {"point_spacing_m", [](RadarSlamOptions& o, double v) { o.lidar.point_spacing_m = v; }},
      {"map_travel_m",
       [](RadarSlamOptions& o, double v) { o.lidar.map_travel_m = o.radar.map_travel_m = v; }},
      {"map_turn", [](RadarSlamOptions& o, double v) { o.lidar.map_turn = Angle::radians(v); }},
      {"max_detections",
       [](RadarSlamOptions& o, double v) { o.radar.density->max_detections = v; }},
      {"radar_hit_probability", [](RadarSlamOptions& o, double v) { o.radar_hit_probability = v; }},
      {"p_free", [](RadarSlamOptions& o, double v) { o.lidar_model.p_free = v; }},
      {"update_travel_m", [](RadarSlamOptions& o, double v) { o.update_travel_m = v; }},
      {"update_time_s", [](RadarSlamOptions& o, double v) { o.update_time_s = v; }},
      {"resample_below", [](RadarSlamOptions& o, double v) { o.resample_below = v; }},
  };
  for (const auto& [what, set] : numbers)
    for (const double v : {0.0, -1.0, 1e-9, 1e9, kNan, kInf, -kInf}) {
      SCOPED_TRACE(std::string(what) + " = " + std::to_string(v));
      RadarSlamOptions options = few_particles();
      set(options, v);
      RadarSlam slam(options);
      for (int k = 0; k < 4; ++k) {
        EXPECT_TRUE(slam.move(motion_of_drive(k)));
        (void)slam.add_lidar(scan_of_drive(k));
        (void)slam.add_radar(time_of_drive(k), detections_of_drive(k));
      }
      EXPECT_TRUE(all_finite(numbers_of(slam.trajectory())));
    }
  const std::vector<std::pair<const char*, std::function<void(RadarSlamOptions&)>>> counts = {
      {"one particle", [](RadarSlamOptions& o) { o.particles = 1; }},
      {"1e9 threads", [](RadarSlamOptions& o) { o.threads = 1'000'000'000; }},
      {"threads < 0", [](RadarSlamOptions& o) { o.threads = -3; }},
      {"no points needed",
       [](RadarSlamOptions& o) { o.lidar.min_points = o.radar.min_points = 0; }},
      {"one search point", [](RadarSlamOptions& o) { o.lidar.search_points = 1; }},
      {"no samples", [](RadarSlamOptions& o) { o.proposal.samples = o.proposal.headings = 0; }},
      {"samples < 0", [](RadarSlamOptions& o) { o.proposal.samples = o.proposal.headings = -1; }},
  };
  for (const auto& [what, set] : counts) {
    SCOPED_TRACE(what);
    RadarSlamOptions options = few_particles();
    set(options);
    RadarSlam slam(options);
    for (int k = 0; k < 4; ++k) {
      EXPECT_TRUE(slam.move(motion_of_drive(k)));
      (void)slam.add_lidar(scan_of_drive(k));
      (void)slam.add_radar(time_of_drive(k), k % 2 == 0 ? PointSet() : detections_of_drive(k));
    }
    EXPECT_TRUE(all_finite(numbers_of(slam.trajectory())));
  }
}

}  // namespace
}  // namespace wayfare::tests
