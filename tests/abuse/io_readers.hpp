#pragma once

// All readers of text as one table: a good file, and what was read of any other, as text again.

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/io/carmen.hpp>
#include <wayfare/io/g2o.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/rinex.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/io/tum.hpp>

#include "io/rinex_samples.hpp"

namespace wayfare::tests {

/// What was read; `digest` contains every number of it.
struct ReadText {
  std::optional<Error> error;
  std::string digest;
  std::size_t items = 0;
  io::Problems problems;
};

struct TextReader {
  std::string name;
  std::string good;     ///< several items, one per line from the second on, each line valid
  bool strict = false;  ///< the first fault is an error
  bool lines = true;    ///< a line is an item: a bad one costs itself alone
  std::function<ReadText(const std::string&)> read;
};

template <class File, class Fill>
ReadText read_text(const Result<File>& file, const Fill& fill) {
  ReadText out;
  if (!file) {
    out.error = file.error();
    return out;
  }
  if constexpr (requires { file->problems; }) out.problems = file->problems;
  fill(*file, out);
  return out;
}

inline std::string numbers_of(const std::vector<double>& values) {
  std::string out;
  for (const double v : values) out += std::to_string(v) + ' ';
  return out + '\n';
}

inline ReadText read_carmen_text(const std::string& text) {
  return read_text(io::parse_carmen(text, "source", {.needs_laser = false}),
                   [](const io::CarmenLog& log, ReadText& out) {
                     const Recording& r = log.recording;
                     out.items = r.scans.size() + r.odometry.size() + r.radar.size() +
                                 r.wheels.size() + r.gyro.size() + r.truth.size();
                     out.digest = io::format_carmen(r);
                   });
}

inline ReadText read_g2o_text(const std::string& text) {
  return read_text(io::parse_g2o(text, "source"), [](const io::AnyGraphFile& file, ReadText& out) {
    std::visit(
        [&](const auto& graph) {
          out.items = graph.vertices.size() + graph.edges.size() + graph.landmarks.size();
          out.digest = io::format_g2o(graph);
        },
        file);
  });
}

inline ReadText read_observations_text(const std::string& text) {
  return read_text(io::parse_rinex_observations(text, "source"),
                   [](const io::RinexObservations& file, ReadText& out) {
                     out.items = file.epochs.size();
                     for (const ObservationEpoch& e : file.epochs) {
                       out.digest += io::format_nanoseconds(e.time.nanoseconds()) + '\n';
                       for (const SatelliteObservation& o : e.satellites)
                         out.digest += numbers_of({o.pseudorange_m});
                     }
                   });
}

inline ReadText read_navigation_text(const std::string& text) {
  return read_text(io::parse_rinex_navigation(text, "source"),
                   [](const io::RinexNavigation& file, ReadText& out) {
                     out.items = file.messages;
                     for (const SatelliteId satellite : file.ephemerides.satellites())
                       for (const Ephemeris& e : file.ephemerides.of(satellite)) {
                         const auto s = satellite_state(e, reference_time(e));
                         out.digest += numbers_of({s.position_ecef_m.x(), s.position_ecef_m.y(),
                                                   s.position_ecef_m.z(), s.clock_s});
                       }
                   });
}

inline const std::vector<TextReader>& text_readers() {
  using namespace io;
  const std::string se3 = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";
  static const std::vector<TextReader> readers = {
      {"carmen",
       "# log\nPARAM robot_wheelbase 0.4\n"
       "ODOM 1 2 0.5 0 0 0 1.25 host 1\nFLASER 3 1 2 3 1 2 0.5 1 2 0.5 1.5 host 1\n"
       "ROBOTLASER1 0 -1.5 3.1 1.0 80 0.01 0 3 1 2 3 0 1 2 0 1 2 0 0 0 0 0 0 1.75 host 1\n"
       "RADAR 1 1 2 0 -0.5 13 2 host 1\nWHEELS 0.1 0.2 2.25 host 1\nGYRO 0.3 2.5 host 1\n"
       "TRUEPOS 1 2 0.5 1 2 0.5 2.75 host 1\nODOM 2 2 0.5 0 0 0 3 host 1\n"
       "GYRO 0.5 3.25 host 1\n",
       false, true, read_carmen_text},
      {"tum", "# t\n1 1 2 3 0 0 0 1\n2 1 2 3 0 0 0.6 0.8\n3 1 2 3 0 0 0 1\n4 0 0 0 0 0 0 1\n",
       false, true,
       [](const std::string& text) {
         return read_text(parse_tum(text, "source"), [](const TumFile& file, ReadText& out) {
           out.items = file.trajectory.size();
           out.digest = format_tum(file.trajectory) + format_tum(planar(file.trajectory));
         });
       }},
      {"relations", "# r\n1 2 1 2 0 0 0 0.5\n2 3 1 2 0 0 0 0.5\n3 4 5 6 0 0 0 0.5\n", false, true,
       [](const std::string& text) {
         return read_text(parse_relations(text, "source"), [](const auto& file, ReadText& out) {
           out.items = file.relations.size();
           for (const eval::Relation& r : file.relations)
             out.digest += numbers_of({r.T_first_second.x(), r.T_first_second.y()});
         });
       }},
      {"points", "# p\n(1 2 3)\n4,5,6\n7 8 9\n", false, true,
       [](const std::string& text) {
         return read_text(parse_points(text, "source"), [](const PointText& file, ReadText& out) {
           out.items = file.points_m.size();
           for (const Eigen::Vector3d& p : file.points_m)
             out.digest += numbers_of({p.x(), p.y(), p.z()});
         });
       }},
      {"g2o plane",
       "# g\nVERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_SE2 2 2 0 0\n"
       "EDGE_SE2 0 1 1 0 0 2 0.5 0 3 0 4\nEDGE_SE2 1 2 1 0 0 2 0.5 0 3 0 4\n",
       true, true, read_g2o_text},
      {"g2o space",
       "# g\nVERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n"
       "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1" +
           se3,
       true, true, read_g2o_text},
      {"g2o landmarks",
       "# g\nVERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_XY 2 2 0\n"
       "EDGE_SE2 0 1 1 0 0 2 0.5 0 3 0 4\nEDGE_SE2_XY 0 2 2 0 2 0.5 3\n"
       "EDGE_BEARING_SE2_XY 1 2 0.1 4\nEDGE_RANGE_SE2_XY 1 2 1 4\n"
       "EDGE_PRIOR_SE2 0 0 0 0 2 0.5 0 3 0 4\nEDGE_PRIOR_SE2_XY 1 1 0 2 0.5 3\n"
       "EDGE_PRIOR_XY 2 2 0 2 0.5 3\nEDGE_PRIOR_XY 2 2 0 2 0.5 3\n",
       true, true, read_g2o_text},
      {"g2o landmarks in space",
       "# g\nPARAMS_SE3OFFSET 5 0 0 1 0 0 0 1\nVERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n"
       "VERTEX_TRACKXYZ 1 1 0 0\nEDGE_SE3_TRACKXYZ 0 1 5 1 0 0 1 0 0 2 0 3\n"
       "EDGE_POINTXYZ_PRIOR 1 1 0 0 1 0 0 2 0 3\nEDGE_SE3_XYZ_PRIOR 0 5 0 0 0 1 0 0 2 0 3\n"
       "EDGE_SE3_PRIOR 0 5 0 0 1 0 0 0 1" +
           se3,
       true, true, read_g2o_text},
      {"landmark log",
       "# l\nODOMETRY 0 1 1 0 0.1 2 0.5 0 3 0 4\nLANDMARK 1 2 1 0.5 2 0.5 3\n"
       "BR 1 2 0.5 1 0.1 0.2\nODOMETRY 1 3 1 0 0.1 2 0.5 0 3 0 4\nBR 3 4 0.5 1 0.1 0.2\n",
       true, true, read_g2o_text},
      {"imu",
       "t_s gx_radps gy_radps gz_radps ax_mps2 ay_mps2 az_mps2\n1 0.1 0 -0.2 0.1 0 -9.8\n"
       "2 0.1 0 -0.2 0.1 0 -9.8\n3 0.1 0 -0.2 0.1 0 -9.8\n4 0 0 0 0 0 1\n",
       false, true,
       [](const std::string& text) {
         return read_text(parse_imu(text, "source"), [](const ImuFile& file, ReadText& out) {
           out.items = file.samples.size();
           out.digest = format_imu(file.samples);
         });
       }},
      {"ranges",
       "t_s sat x_m y_m z_m vx_mps vy_mps vz_mps range_m rate_mps range_sigma_m\n"
       "1 G05 2e7 1e7 -3e6 1 2 3 2.2e7 1 2\n2 G05 2e7 1e7 -3e6 1 2 3 2.2e7 1 2\n"
       "3 E07 2e7 1e7 -3e6 1 2 3 2.2e7 1 2\n",
       false, true,
       [](const std::string& text) {
         return read_text(parse_ranges(text, "source"), [](const RangesFile& file, ReadText& out) {
           for (const RangeEpoch& e : file.epochs) out.items += e.satellites.size();
           out.digest = format_ranges(file.epochs);
           for (const RangeEpoch& e : file.epochs)
             for (const CorrectedRange& r : e.satellites)
               EXPECT_TRUE(std::isfinite(r.range_sigma_m * r.range_sigma_m));
         });
       }},
      {"fixes",
       "t_s lat_deg lon_deg h_m sn_m se_m sd_m vn_mps ve_mps vd_mps svn_mps sve_mps svd_mps q\n"
       "1 40 -105 1600 1 1 2 0.5 0 0 0.1 0.1 0.1 1\n2 40 -105 1600 1 1 2 0.5 0 0 0.1 0.1 0.1 1\n"
       "3 40 -105 1600 1 1 2 0.5 0 0 0.1 0.1 0.1 2\n",
       false, true,
       [](const std::string& text) {
         return read_text(parse_fixes(text, "source"), [](const FixFile& file, ReadText& out) {
           out.items = file.fixes.size();
           out.digest = format_fixes(file.fixes);
           for (const GnssFix& f : file.fixes) {
             EXPECT_TRUE(f.position_covariance_ned_m2.allFinite());
             EXPECT_GT(f.position_covariance_ned_m2.diagonal().minCoeff(), 0.0);
             EXPECT_TRUE(f.velocity_covariance_ned.allFinite());
             EXPECT_GT(f.velocity_covariance_ned.diagonal().minCoeff(), 0.0);
           }
         });
       }},
      {"nav",
       "t_s lat_deg lon_deg h_m vn_mps ve_mps vd_mps roll_deg pitch_deg yaw_deg\n"
       "1 40 -105 1600 1 2 0 1 2 3\n2 40 -105 1600 1 2 0 1 2 3\n3 40 -105 1600 1 2 0 1 2 3\n",
       false, true,
       [](const std::string& text) {
         return read_text(parse_nav(text, "source"), [](const NavFile& file, ReadText& out) {
           out.items = file.trajectory.size();
           out.digest = format_nav(file.trajectory);
         });
       }},
      {"clock", "t_s device_s\n1 5\n2 6\n3 7.5\n", false, true,
       [](const std::string& text) {
         return read_text(parse_clock(text, "source"), [](const ClockFile& file, ReadText& out) {
           out.items = file.pairs.size();
           for (const auto& pair : file.pairs)
             out.digest += numbers_of({pair.device.seconds(), pair.log.seconds()});
           // Differences of any two fit their type.
           const auto fit = fit_clock<DeviceClock>(file.pairs);
           EXPECT_TRUE(!fit || fit->used >= 2);
         });
       }},
      {"marg",
       "t_s gx_radps gy_radps gz_radps ax_mps2 ay_mps2 az_mps2 mx_uT my_uT mz_uT\n"
       "1 0.1 0 -0.2 0.1 0 -9.8 20 1 -40\n2 0.1 0 -0.2 0.1 0 -9.8 20 1 -40\n"
       "3 0.1 0 -0.2 0.1 0 -9.8 20 1 -40\n",
       false, true,
       [](const std::string& text) {
         return read_text(parse_marg(text, "source"), [](const MargFile& file, ReadText& out) {
           out.items = file.samples.size();
           out.digest = format_marg(file.samples);
         });
       }},
      {"rinex 3 observations", ::wayfare::testing::rinex_3_observations(), false, false,
       read_observations_text},
      {"rinex 2 observations", ::wayfare::testing::rinex_2_observations(), false, false,
       read_observations_text},
      {"rinex 3 navigation", ::wayfare::testing::rinex_3_navigation(), false, false,
       read_navigation_text},
      {"rinex 2 navigation", ::wayfare::testing::rinex_2_navigation(), false, false,
       read_navigation_text},
      {"map yaml",
       "# m\nimage: 'a.pgm'\nresolution: 0.05\norigin: [1, 2, 0]\nnegate: 0\nfree_thresh: 0.2\n",
       true, false,
       [](const std::string& text) {
         return read_text(parse_map_yaml(text, "source"), [](const MapYaml& yaml, ReadText& out) {
           out.items = 1;
           out.digest = numbers_of({yaml.resolution_m, yaml.origin.x(), yaml.origin.y(),
                                    yaml.occupied_threshold, yaml.free_threshold});
         });
       }},
  };
  return readers;
}

}  // namespace wayfare::tests
