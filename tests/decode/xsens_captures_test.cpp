#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>

#include <wayfare/decode/detail/mt_values.hpp>
#include <wayfare/decode/mt_sample.hpp>
#include <wayfare/testing/decoder_laws.hpp>

#include "xbus_streams.hpp"

namespace wayfare::decode {
namespace {

using Fields = std::map<std::string, std::vector<double>>;

std::vector<double> numbers(const MtUtc& t) {
  return {double(t.year), double(t.month),  double(t.day),
          double(t.hour), double(t.minute), t.second + 1e-9 * t.nanoseconds};
}

template <int N>
std::vector<double> numbers(const Eigen::Matrix<double, N, 1>& v) {
  return {v.data(), v.data() + N};
}

std::vector<double> numbers(const MtGnss& g) {
  std::vector<double> v = {double(g.itow_ms),
                           double(g.utc.year),
                           double(g.utc.month),
                           double(g.utc.day),
                           double(g.utc.hour),
                           double(g.utc.minute),
                           double(g.utc.second),
                           double(g.utc.flags),
                           double(g.time_accuracy_ns),
                           double(g.nano),
                           double(g.fix),
                           double(g.flags),
                           double(g.satellites),
                           0.0,
                           double(g.longitude_e7_deg),
                           double(g.latitude_e7_deg),
                           double(g.height_mm),
                           double(g.height_msl_mm),
                           double(g.horizontal_accuracy_mm),
                           double(g.vertical_accuracy_mm)};
  for (const auto x : g.velocity_ned_mmps) v.push_back(double(x));
  for (const double x :
       {double(g.ground_speed_mmps), double(g.heading_of_motion_e5_deg),
        double(g.speed_accuracy_mmps), double(g.heading_accuracy_e5_deg), double(g.heading_e5_deg)})
    v.push_back(x);
  for (const auto x : g.dop_e2) v.push_back(double(x));
  return v;
}

/// A sample's values by their names in the expected texts.
Fields fields_of(const MtSample& s) {
  Fields f;
  const auto add = [&](const char* name, const auto& value) {
    if (!value) return;
    if constexpr (std::is_arithmetic_v<std::decay_t<decltype(*value)>>) {
      f[name] = {double(*value)};
    } else {
      f[name] = numbers(*value);
    }
  };
  add("PacketCounter", s.packet_counter);
  add("SampleTimeFine", s.sample_time_fine);
  add("SampleTimeCoarse", s.sample_time_coarse);
  add("UTCTime", s.utc);
  add("StatusByte", s.status_byte);
  add("StatusWord", s.status_word);
  add("Temperature", s.temperature_c);
  add("BaroPressure", s.pressure_pa);
  add("Acceleration", s.acceleration_mps2);
  add("FreeAcceleration", s.free_acceleration_mps2);
  add("DeltaV", s.delta_v_mps);
  add("DeltaQ", s.delta_q);
  add("RateOfTurn", s.rate_radps);
  add("MagneticField", s.magnetic_field_au);
  add("Quaternion", s.quaternion);
  add("EulerAngles", s.euler_deg);
  if (s.rotation_matrix)
    f["RotationMatrix"] = {s.rotation_matrix->data(), s.rotation_matrix->data() + 9};
  add("LatLon", s.lat_lon_deg);
  add("AltitudeEllipsoid", s.altitude_ellipsoid_m);
  add("VelocityXYZ", s.velocity_mps);
  add("PositionECEF", s.position_ecef_m);
  add("GNSSPVTData", s.gnss);
  return f;
}

double number_in(const std::string& name, const std::string& text) {
  if (name.starts_with("Status")) return static_cast<double>(std::stoul(text, nullptr, 2));
  return std::stod(text);
}

/// The expected messages: "Name(format):" lines, values indented below, blank lines between
/// messages.
std::vector<Fields> expected_samples(const std::string& text) {
  std::vector<Fields> all(1);
  std::istringstream lines(text);
  std::string line, name;
  while (std::getline(lines, line)) {
    if (line.empty()) {
      all.emplace_back();
    } else if (line[0] != ' ') {
      name = line.substr(0, line.find_first_of("(:"));
    } else if (name == "UTCTime") {
      std::vector<double> t(6);
      if (std::sscanf(line.c_str(), " %lf-%lf-%lfT%lf:%lf:%lfZ", &t[0], &t[1], &t[2], &t[3], &t[4],
                      &t[5]) == 6)
        all.back()[name] = t;
    } else if (name != "GNSSSatInfo") {
      const std::size_t colon = line.find(':');
      const std::string value = line.substr(colon == std::string::npos ? 2 : colon + 1);
      all.back()[name].push_back(number_in(name, value));
    }
  }
  while (!all.empty() && all.back().empty()) all.pop_back();
  return all;
}

TEST(XsensCaptures, GoldenTextsInAllEncodings) {
  for (int number = 1; number <= 5; ++number) {
    const std::string base =
        "devices/xsens/mti_mtdata2/einride_testdata/" + std::to_string(number) + "/";
    WAYFARE_NEEDS_RECORDING(path, base + "output.bin");
    WAYFARE_NEEDS_RECORDING(text_path, base + "output.golden");
    const std::vector<Fields> expected = expected_samples(testing::file_text(text_path));
    std::size_t index = 0, values = 0;
    const auto statistics = each_message(testing::file_bytes(path), [&](const XbusMessage& m) {
      ASSERT_EQ(m.id(), XbusId::mt_data2);
      const auto sample = mt_sample(m.data());
      ASSERT_TRUE(sample);
      ASSERT_LT(index, expected.size());
      Fields ours = fields_of(*sample);
      const Fields& theirs = expected[index++];
      for (const auto& [name, numbers_of_it] : theirs) {
        ASSERT_EQ(ours[name].size(), numbers_of_it.size()) << name << " in message " << index;
        for (std::size_t i = 0; i < numbers_of_it.size(); ++i, ++values) {
          if (name == "UTCTime") {
            ASSERT_NEAR(ours[name][i], numbers_of_it[i], 5e-10);
          } else {
            ASSERT_EQ(ours[name][i], numbers_of_it[i]) << name << " in message " << index;
          }
        }
      }
      ASSERT_EQ(ours.size(), theirs.size()) << "message " << index;
    });
    EXPECT_EQ(index, expected.size()) << number;
    EXPECT_EQ(statistics.frames, 100U);
    EXPECT_EQ(statistics.skipped_bytes, 0U);
    EXPECT_GT(values, 1000U);
  }
}

TEST(XsensCaptures, RotationMatrixIsThatOfTheQuaternion) {
  WAYFARE_NEEDS_RECORDING(path, "devices/xsens/mti_mtdata2/einride_testdata/5/output.bin");
  int compared = 0;
  each_message(testing::file_bytes(path), [&](const XbusMessage& m) {
    const auto s = mt_sample(m.data());
    if (!s || !s->quaternion || !s->rotation_matrix) return;
    const Eigen::Vector4d& q = *s->quaternion;
    const Eigen::Matrix3d expected =
        Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
    EXPECT_LT((expected - *s->rotation_matrix).cwiseAbs().maxCoeff(), 1e-6);
    ++compared;
  });
  EXPECT_EQ(compared, 92);
}

TEST(XsensCaptures, GarbageInFront) {
  WAYFARE_NEEDS_RECORDING(
      path, "devices/xsens/mti_mtdata2/20260503_204234_xsensmti_with_gnss_recording.bin.gz");
  std::size_t samples = 0;
  CounterUnwrapper counter(65536);
  std::int64_t last = -1, gaps = 0;
  const auto statistics = each_message(testing::file_bytes(path), [&](const XbusMessage& m) {
    const auto sample = mt_sample(m.data());
    ASSERT_TRUE(sample);
    ++samples;
    if (!sample->packet_counter) return;
    const std::int64_t now = counter.at(*sample->packet_counter);
    gaps += last >= 0 && now != last + 1 && now != last ? 1 : 0;
    last = now;
  });
  EXPECT_EQ(statistics.frames, 4936U);
  EXPECT_EQ(samples, 4936U);
  EXPECT_EQ(statistics.skipped_bytes, 22U);
  EXPECT_EQ(gaps, 0);
}

TEST(XsensCaptures, SatisfyTheLawsUnderDamage) {
  WAYFARE_NEEDS_RECORDING(path, "devices/xsens/mti_mtdata2/einride_testdata/2/output.bin");
  Stream bytes = testing::file_bytes(path);
  std::vector<std::uint64_t> starts;
  each_message(bytes, [&](const XbusMessage& m) { starts.push_back(m.position()); });
  bytes.resize(static_cast<std::size_t>(starts.at(40)));
  const testing::DecoderLaws<XbusDecoder> laws{bytes, kAsText};
  laws.check();
  const testing::DamageReport report = laws.damage(10000);
  report.record("xbus");
  EXPECT_EQ(report.lost, 0U);
  // A checksum of eight bits: one false start in 256 passes and may hide a few messages after it.
  EXPECT_LE(static_cast<double>(report.false_frames), report.most_false(256.0));
  EXPECT_LE(static_cast<double>(report.hidden), 1e-3 * static_cast<double>(report.undamaged));
  EXPECT_GT(report.undamaged, 300'000U);
}

}  // namespace
}  // namespace wayfare::decode
