// Readers on damaged input: truncated, flipped, inserted and repeated bytes of valid files. Checks
// that nothing crashes or hangs (also under the sanitizers) and that the results are valid.

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include <wayfare/io/carmen.hpp>
#include <wayfare/io/g2o.hpp>
#include <wayfare/io/landmark_graph.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/rinex.hpp>
#include <wayfare/io/tum.hpp>
#include "rinex_samples.hpp"
#include "support.hpp"

namespace wayfare::io {
namespace {

std::string mutated(std::string bytes, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
  static const std::vector<std::string> kNasty = {" nan ",
                                                  " -1 ",
                                                  "1e999",
                                                  "18446744073709551616",
                                                  std::string(3, '\0'),
                                                  "\n",
                                                  " ",
                                                  "\xff\xfe",
                                                  "#",
                                                  "FLASER 4000000000 ",
                                                  "-",
                                                  "1e-999",
                                                  "\x1f\x8b",
                                                  "[",
                                                  "255",
                                                  "9223372036854775807"};
  for (std::size_t k = 1 + below(4); k-- > 0 && !bytes.empty();) {
    const std::size_t at = below(bytes.size());
    switch (below(5)) {
      case 0:
        bytes.resize(at);
        break;
      case 1:
        bytes[at] = static_cast<char>(random());
        break;
      case 2:
        bytes.insert(at, kNasty[below(kNasty.size())]);
        break;
      case 3:
        bytes.erase(at, 1 + below(20));
        break;
      default:
        bytes.insert(at, bytes.substr(below(bytes.size()), below(80)));
    }
  }
  return bytes;
}

void mutate(const std::string& good, int times, const std::function<void(const std::string&)>& f) {
  std::mt19937 random(20260101);
  f(good);
  for (int i = 0; i < times; ++i) f(mutated(good, random));
}

TEST(Mutation, Carmen) {
  std::string good = "# log\nPARAM laser_frontlaser_resolution 1\n";
  for (int i = 0; i < 6; ++i) {
    const std::string t = std::to_string(i) + ".25 host " + std::to_string(i) + "\n";
    good += "ODOM 1 2 0.5 0 0 0 " + t;
    good += "FLASER 4 1 2 3 81.83 1 2 0.5 1 2 0.5 " + t;
    good += "RLASER 2 1 2 1 2 0.5 1 2 0.5 " + t;
    good += "ROBOTLASER1 0 -1.5 3.1 1.0 80 0.01 0 4 1 2 3 4 1 9 1 2 0 1 2 0 0 0 0 0 0 " + t;
    good += "RADAR 2 1 2 0 -0.5 13 2 1 0 0.1 20 " + t + "RADAR 0 " + t;
    good += "WHEELS 0.1 0.2 " + t + "GYRO 0.3 " + t + "TRUEPOS 1 2 0.5 1 2 0.5 " + t;
    good += "Odometry 1 2 0.5\nLaser 3 1 2 3\nNEFF 3\n";
  }
  int useful = 0;
  mutate(good, 3000, [&](const std::string& text) {
    const Result<CarmenLog> log = parse_carmen(text, "m", {.max_problems = 5});
    if (!log) return;
    ++useful;
    const auto& scans = log->recording.scans;
    ASSERT_FALSE(scans.empty());
    ASSERT_LE(log->problems.first().size(), 5U);
    for (std::size_t i = 0; i < scans.size(); ++i) {
      ASSERT_FALSE(scans[i].ranges_m.empty());
      ASSERT_TRUE(i == 0 || scans[i - 1].time <= scans[i].time);
      for (std::size_t b = 0; b < scans[i].ranges_m.size(); ++b) {
        if (scans[i].returned(b)) {
          ASSERT_TRUE(std::isfinite(scans[i].ranges_m[b]));
        }
      }
    }
    for (const OdometrySample& sample : log->recording.odometry)
      ASSERT_TRUE(sample.T_odom_base.raw().translation().allFinite());
    for (const RadarScan& scan : log->recording.radar)
      for (const RadarPoint& p : scan.points)
        ASSERT_TRUE(std::isfinite(p.x_m + p.y_m + p.z_m + p.doppler_m_s + p.snr_db));
    for (const WheelSample& sample : log->recording.wheels)
      ASSERT_TRUE(std::isfinite(sample.left_m + sample.right_m));
    for (const Error& error : log->problems.first()) ASSERT_FALSE(error.message.empty());
  });
  EXPECT_GT(useful, 2000);  // local damage must not invalidate the log
}

TEST(Mutation, G2o) {
  const std::string planar =
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nFIX 0\nEDGE_SE2 0 1 1 0 0 2 0.5 0 3 0 4\n";
  const std::string spatial =
      "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n"
      "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";
  const std::string landmarks =
      "VERTEX_SE2 0 0 0 0\nVERTEX_XY 1 1 0\nEDGE_SE2_XY 0 1 1 0 2 0.5 3\n"
      "EDGE_BEARING_SE2_XY 0 1 0 4\nEDGE_PRIOR_XY 1 2 0 2 0.5 3\n";
  const std::string in_space =
      "PARAMS_SE3OFFSET 5 0 0 1 0 0 0 1\nVERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_TRACKXYZ 1 1 0 0\n"
      "EDGE_SE3_TRACKXYZ 0 1 5 1 0 0 1 0 0 2 0 3\nEDGE_SE3_XYZ_PRIOR 0 5 0 0 0 1 0 0 2 0 3\n";
  const std::string log =
      "ODOMETRY 0 1 1 0 0.1 2 0.5 0 3 0 4\nLANDMARK 1 2 1 0.5 2 0.5 3\nBR 1 2 0.5 1 0.1 0.2\n";
  for (const std::string& good : {planar, spatial, landmarks, in_space, log}) {
    mutate(good, 3000, [](const std::string& text) {
      for (const auto how : {IndefiniteInformation::refuse, IndefiniteInformation::project}) {
        const Result<AnyGraphFile> file = parse_g2o(text, "m", {.indefinite = how});
        if (!file) {
          ASSERT_FALSE(file.error().message.empty());
          continue;
        }
        std::visit(
            [](const auto& graph) {
              ASSERT_FALSE(graph.vertices.empty());
              for (const auto& edge : graph.edges) ASSERT_TRUE(edge.information.allFinite());
              // Every id is known.
              const auto factors = to_factor_graph(graph);
              ASSERT_GE(factors.edge_count(), static_cast<int>(graph.edges.size()));
            },
            *file);
      }
    });
  }
}

TEST(Mutation, TumAndRelations) {
  const std::string tum = "# t\n1.5 1 2 3 0 0 0 1\n2.5 1 2 3 0 0 0.6 0.8\n";
  mutate(tum, 3000, [](const std::string& text) {
    const Result<TumFile> file = parse_tum(text, "m");
    if (!file) return;
    for (const StampedPose& sample : planar(file->trajectory))
      ASSERT_TRUE(sample.T_map_base.raw().translation().allFinite());
  });
  mutate("1.5 2.5 1 2 0 0 0 0.5\n2.5 3.5 1 2 0 0 0 0.5\n", 3000, [](const std::string& text) {
    const Result<RelationsFile> file = parse_relations(text, "m");
    ASSERT_TRUE(!file || !file->relations.empty());
  });
}

TEST(Mutation, MapsAndTheirYaml) {
  mutate(std::string("P5\n4 3\n255\n") + std::string(12, 'x'), 3000, [](const std::string& bytes) {
    const Result<Image> image = parse_pgm(bytes, "m");
    if (image) {
      ASSERT_EQ(image->pixels.size(), image->width * image->height);
    }
  });
  mutate("image: 'a.pgm'\nresolution: 0.05\norigin: [1, 2, 0]\nnegate: 0\nfree_thresh: 0.2\n", 3000,
         [](const std::string& text) {
           const Result<MapYaml> yaml = parse_map_yaml(text, "m");
           if (yaml) {
             ASSERT_GT(yaml->resolution_m, 0.0);
           }
         });
}

TEST(Mutation, RinexObservations) {
  for (const std::string& good :
       {::wayfare::testing::rinex_3_observations(), ::wayfare::testing::rinex_2_observations()}) {
    int useful = 0;
    mutate(good, 3000, [&](const std::string& text) {
      const Result<RinexObservations> file =
          parse_rinex_observations(text, "m", {.max_problems = 5});
      if (!file) return;
      ASSERT_FALSE(file->epochs.empty());
      ASSERT_LE(file->problems.first().size(), 5U);
      useful += file->epochs.size() >= 2 ? 1 : 0;
      for (const ObservationEpoch& epoch : file->epochs)
        for (const SatelliteObservation& o : epoch.satellites)
          ASSERT_TRUE(std::isfinite(o.pseudorange_m) && o.satellite.number > 0);
    });
    EXPECT_GT(useful, 1000);
  }
}

TEST(Mutation, RinexNavigation) {
  for (const std::string& good :
       {::wayfare::testing::rinex_3_navigation(), ::wayfare::testing::rinex_2_navigation()}) {
    mutate(good, 3000, [&](const std::string& text) {
      const Result<RinexNavigation> file = parse_rinex_navigation(text, "m", {.max_problems = 5});
      if (!file) return;
      // Accepted messages give a finite position at a plausible orbital radius.
      for (const SatelliteId satellite : file->ephemerides.satellites()) {
        for (const Ephemeris& e : file->ephemerides.of(satellite)) {
          const SatelliteState s = satellite_state(e, reference_time(e) + std::chrono::hours(1));
          ASSERT_TRUE(s.position_ecef_m.norm() > 6e6 && s.position_ecef_m.norm() < 1.1e8);
          ASSERT_TRUE(s.velocity_ecef_mps.allFinite() && std::isfinite(s.clock_s));
        }
      }
    });
  }
}

TEST(Mutation, NavigationColumns) {
  std::string imu = "t_s gx_radps gy_radps gz_radps ax_mps2 ay_mps2 az_mps2\n";
  std::string ranges = "t_s sat x_m y_m z_m vx_mps vy_mps vz_mps range_m rate_mps\n";
  std::string fixes = "date clock lat_deg lon_deg h_m vn_mps ve_mps vu_mps\n";
  for (int i = 0; i < 8; ++i) {
    const std::string n = std::to_string(i);
    imu += "1435606458.0" + n + " 0.1 0 -0.2 0.1 0 -9.8\n";
    ranges += "1435606458 G0" + n + " 2e7 1e7 -3e6 1 2 3 2.2e7 nan\n";
    fixes += "2025/07/08 19:34:0" + n + ".5 40.1 -105.1 1600 1 2 0\n";
  }
  int useful = 0;
  mutate(imu, 3000, [&](const std::string& text) {
    const auto file = parse_imu(text, "m");
    if (!file) return;
    ++useful;
    ASSERT_EQ(file->samples.size(), file->ends.size());
    for (const ImuSample& sample : file->samples)
      ASSERT_TRUE(sample.angular_rate_radps.allFinite() && sample.specific_force_mps2.allFinite());
  });
  EXPECT_GT(useful, 1500);  // a sixth of this short file is the line that names its columns
  mutate(ranges, 3000, [](const std::string& text) {
    const auto file = parse_ranges(text, "m");
    if (!file) return;
    for (const RangeEpoch& epoch : file->epochs)
      for (const CorrectedRange& range : epoch.satellites)
        ASSERT_TRUE(range.position_ecef_m.allFinite() && range.range_sigma_m > 0.0);
  });
  mutate(fixes, 3000, [](const std::string& text) {
    const auto file = parse_fixes(text, "m");
    const auto nav = parse_nav(text, "m");
    if (!file) return;
    for (const GnssFix& fix : file->fixes)
      ASSERT_TRUE(fix.position_covariance_ned_m2.allFinite() &&
                  std::isfinite(fix.position.height_m));
  });
}

TEST(Mutation, TimeTags) {
  std::string tags = "TIMETAG RTKLIB demo5";
  tags.resize(76, '\0');
  for (char i = 1; i < 20; ++i) tags += std::string({i, 0, 0, 0, char(3 * i), 0, 0, 0});
  mutate(tags, 3000, [](const std::string& bytes) {
    const auto file = parse_time_tags(bytes, "m");
    if (!file) return;
    for (std::size_t i = 1; i < file->tags.size(); ++i) {
      ASSERT_LE(file->tags[i - 1].bytes, file->tags[i].bytes);
      ASSERT_LE(file->tags[i - 1].time, file->tags[i].time);
    }
  });
}

TEST(Mutation, Gzip) {
  const unsigned char bytes[] = {0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x03};
  std::string good(bytes, bytes + sizeof bytes);
  // One stored block: 01, length 8, its complement, eight bytes, then no checksum.
  good += std::string("\x01\x08\x00\xf7\xff", 5) + "wayfare ";
  mutate(good, 5000, [](const std::string& text) {
    const Result<FileContent> content = decompress(text, "m", {.max_bytes = 10000});
    ASSERT_TRUE(!content || content->bytes.size() <= 10000U);
  });
  const Result<FileContent> content = decompress(good, "m");
  ASSERT_TRUE(content && content->damage);
  EXPECT_EQ(content->bytes, "wayfare ");
}

}  // namespace
}  // namespace wayfare::io
