#include <wayfare/decode/xbus.hpp>

#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <numeric>
#include <sstream>

#include <wayfare/decode/mt_legacy.hpp>
#include <wayfare/decode/mt_measure.hpp>
#include <wayfare/decode/mt_sample.hpp>
#include <wayfare/testing/decoder_laws.hpp>
#include "decode/captures.hpp"

namespace wayfare::decode {
namespace {

using Stream = std::vector<std::uint8_t>;

Stream message(XbusId id, const Stream& data, std::uint8_t bus = 0xFF) {
  Stream out(data.size() + 7);
  out.resize(write_xbus(bus, id, data, out));
  return out;
}

void append(Stream& to, const Stream& more) { to.insert(to.end(), more.begin(), more.end()); }

template <class T>
void put(Stream& out, T value) {
  out.resize(out.size() + sizeof(T));
  store_be(value, &out[out.size() - sizeof(T)]);
}

std::string text_of(const XbusMessage& m) {
  return std::to_string(static_cast<int>(m.id())) + ":" + testing::fingerprint(m.bytes());
}

template <class F>
DecoderStatistics each_message(const Stream& bytes, F&& f) {
  const auto decoder = std::make_unique<XbusDecoder>();
  decoder->feed(bytes, f);
  decoder->finish(f);
  return decoder->statistics();
}

TEST(Xbus, SumsOfBytes) {
  Rng rng(2);
  for (std::size_t n = 0; n < 200; ++n) {
    Stream bytes(n);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng());
    const auto expected = std::accumulate(bytes.begin(), bytes.end(), 0U) & 0xFFU;
    ASSERT_EQ(byte_sum(bytes), expected);
  }
}

TEST(Xbus, MessagesAsTheManualSpellsThem) {
  // GotoConfig: FA FF 30 00 D1 (MT Low Level Communication Protocol, section on messages).
  EXPECT_EQ(message(XbusId::goto_config, {}), (Stream{0xFA, 0xFF, 0x30, 0x00, 0xD1}));
  const Stream longer = message(XbusId::mt_data2, Stream(255, 1), 3);
  EXPECT_EQ(longer.size(), 262U);
  EXPECT_EQ(longer[3], 0xFF);
  int seen = 0;
  each_message(longer, [&](const XbusMessage& m) {
    ++seen;
    EXPECT_EQ(m.bus(), 3);
    EXPECT_EQ(m.id(), XbusId::mt_data2);
    EXPECT_EQ(m.data().size(), 255U);
    EXPECT_EQ(m.data()[254], 1);
  });
  EXPECT_EQ(seen, 1);
  Stream room(4);
  EXPECT_EQ(write_xbus(0xFF, XbusId::goto_config, {}, room), 0U);  // does not fit
}

TEST(Xbus, APreambleInTheDataAfterDamageDoesNotHideTheNext) {
  // The damaged message holds what looks like a long message, over the good ones behind it.
  Stream damaged = message(XbusId::mt_data2, {0xFA, 0xFF, 0x36, 0xFF, 0x04, 0x00, 0xFA, 0xFA});
  damaged.back() ^= 1;
  Stream bytes = damaged;
  for (int i = 0; i < 200; ++i) append(bytes, message(XbusId::mt_data, Stream(10, 7)));
  std::size_t seen = 0;
  const auto statistics = each_message(bytes, [&](const XbusMessage&) { ++seen; });
  EXPECT_EQ(seen, 200U);
  EXPECT_EQ(statistics.skipped_bytes, damaged.size());
  EXPECT_GE(statistics.checksum_failures, 2U);
}

TEST(Xbus, KeepsTheLaws) {
  Rng rng(4);
  Stream bytes;
  for (int i = 0; i < 40; ++i) {
    Stream data(rng.below(i % 10 == 9 ? 2000 : 120));
    for (auto& byte : data) byte = rng.below(8) == 0 ? 0xFA : static_cast<std::uint8_t>(rng());
    append(bytes, message(XbusId::mt_data2, data));
  }
  const testing::DecoderLaws<XbusDecoder> laws{bytes, text_of};
  laws.check();
  const testing::DamageReport report = laws.damage(3000);
  EXPECT_EQ(report.lost, 0U);
  EXPECT_LE(static_cast<double>(report.false_frames), report.most_false(256.0));
}

TEST(MtData2, NumbersInFourWays) {
  // −1.25: float, 12.20 and 16.32 fixed point, double.
  const Stream f32 = {0xBF, 0xA0, 0, 0}, f64 = {0xBF, 0xF4, 0, 0, 0, 0, 0, 0};
  const Stream fixed20 = {0xFF, 0xEC, 0, 0}, fixed32 = {0xC0, 0, 0, 0, 0xFF, 0xFE};
  EXPECT_EQ(mt_real(f32.data(), MtPrecision::float32), -1.25);
  EXPECT_EQ(mt_real(fixed20.data(), MtPrecision::fixed_12_20), -1.25);
  EXPECT_EQ(mt_real(fixed32.data(), MtPrecision::fixed_16_32), -1.25);
  EXPECT_EQ(mt_real(f64.data(), MtPrecision::float64), -1.25);
}

TEST(MtData2, PacketsAreCheckedBeforeTheyAreUsed) {
  EXPECT_TRUE(mt_sample({}));
  EXPECT_FALSE(mt_sample(Stream{0x10}));
  EXPECT_FALSE(mt_sample(Stream{0x10, 0x20}));
  EXPECT_FALSE(mt_sample(Stream{0x10, 0x20, 2, 0}));  // one byte short
  const auto counter = mt_sample(Stream{0x10, 0x20, 2, 1, 2});
  ASSERT_TRUE(counter);
  EXPECT_EQ(counter->packet_counter, 0x0102);
  const auto odd = mt_sample(Stream{0x10, 0x20, 3, 1, 2, 3, 0x99, 0x90, 1, 0, 0x40, 0x20, 0});
  ASSERT_TRUE(odd);
  EXPECT_FALSE(odd->packet_counter);
  EXPECT_FALSE(odd->acceleration_mps2);
  EXPECT_EQ(odd->unknown, 3);
  // A NaN is no reading.
  Stream nan = {0x08, 0x10, 4};
  put(nan, std::nanf(""));
  EXPECT_FALSE(mt_sample(nan)->temperature_c);
}

TEST(MtData2, FramesOfReference) {
  for (const auto& [bits, frame] :
       {std::pair{0x0, MtFrame::enu}, {0x4, MtFrame::ned}, {0x8, MtFrame::nwu}}) {
    Stream data = {0x20, static_cast<std::uint8_t>(0x10 | bits), 16};
    for (const float q : {1.0F, 0.0F, 0.0F, 0.0F}) put(data, q);
    const auto sample = mt_sample(data);
    ASSERT_TRUE(sample && sample->quaternion);
    EXPECT_EQ(sample->frame, frame);
  }
}

TEST(MtData2, ToMeasurements) {
  MtSample sample;
  EXPECT_FALSE(to_imu_sample(sample, LogTime{}));
  sample.rate_radps = Eigen::Vector3d(1, 2, 3);
  sample.acceleration_mps2 = Eigen::Vector3d(0, 0, 9.81);
  sample.magnetic_field_au = Eigen::Vector3d(1, 0, 0);
  const auto imu = to_imu_sample(sample, LogTime::from_nanoseconds(7));
  ASSERT_TRUE(imu);
  EXPECT_EQ(imu->time.nanoseconds(), 7);
  EXPECT_EQ(imu->specific_force_mps2.z(), 9.81);
  EXPECT_EQ(to_marg_sample(sample, LogTime{}, 48.0).magnetic_field_uT.x(), 48.0);
  EXPECT_TRUE(std::isnan(to_marg_sample(MtSample{}, LogTime{}).angular_rate_radps.x()));
}

TEST(MtData2, CountersComeRound) {
  RoundCounter counter(65536);
  EXPECT_EQ(counter.at(65530), 65530);
  EXPECT_EQ(counter.at(3), 65539);
  EXPECT_EQ(counter.at(65535), 65535);  // one that came late
  EXPECT_EQ(counter.at(4), 65540);
  RoundCounter fine(864'000'000);
  EXPECT_EQ(fine.at(863'999'900), 863'999'900);
  EXPECT_EQ(fine.at(0), 864'000'000);
}

TEST(MtLegacy, FollowsItsLayout) {
  // Temperature, calibrated without magnetometer, Euler angles, status, counter; 12.20 fixed point.
  const MtLegacyLayout layout{0x0001 | 0x0002 | 0x0004 | 0x0800, 0x40 | 0x4 | 0x100 | 0x1};
  Stream data;
  for (const double v : {25.5, 0.1, 0.2, 9.8, 0.01, 0.02, 0.03, 10.0, 20.0, 30.0})
    put(data, static_cast<std::int32_t>(std::lround(v * 0x1p20)));
  data.push_back(0x07);
  put(data, std::uint16_t{4242});
  const auto sample = mt_legacy_sample(data, layout);
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->sample.temperature_c, 25.5);
  EXPECT_NEAR(sample->sample.acceleration_mps2->z(), 9.8, 1e-6);
  EXPECT_NEAR(sample->sample.rate_radps->y(), 0.02, 1e-6);
  EXPECT_FALSE(sample->sample.magnetic_field_au);
  EXPECT_EQ(sample->sample.euler_deg->z(), 30.0);
  EXPECT_EQ(sample->sample.status_byte, 7);
  EXPECT_EQ(sample->sample.packet_counter, 4242);
  EXPECT_EQ(sample->sample.frame, MtFrame::nwu);

  Stream wrong = data;
  wrong.pop_back();
  EXPECT_FALSE(mt_legacy_sample(wrong, layout));
  wrong.resize(data.size() + 1);
  EXPECT_FALSE(mt_legacy_sample(wrong, layout));
  EXPECT_FALSE(mt_legacy_sample({}, layout));
}

TEST(MtLegacy, RawMatrixPositionAndTime) {
  const MtLegacyLayout layout{0x4000 | 0x0004 | 0x0008 | 0x0010 | 0x0020,
                              0x8 | 0x400 | 0x300 | 0x2 | 0x80000000U};
  Stream data;
  for (std::uint16_t i = 1; i <= 10; ++i) put(data, i);
  for (int i = 0; i < 9; ++i) put(data, i % 4 == 0 ? 1.0 : 0.1 * i);
  put(data, std::uint16_t{77});
  for (int i = 0; i < 6; ++i) put(data, 0.5 * i);
  put(data, std::uint32_t{5});
  put(data, std::uint16_t{2026});
  for (const int b : {11, 21, 15, 10, 0, 7}) data.push_back(static_cast<std::uint8_t>(b));
  const auto sample = mt_legacy_sample(data, layout);
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->raw->gyroscope[2], 6);
  EXPECT_EQ(sample->raw->temperature, 10);
  EXPECT_EQ((*sample->sample.rotation_matrix)(1, 0), 0.1);  // column by column
  EXPECT_FALSE(sample->aux1);
  EXPECT_EQ(sample->aux2, 77);
  EXPECT_EQ(sample->position_lla->z(), 1.0);
  EXPECT_EQ(sample->sample.velocity_mps->x(), 1.5);
  EXPECT_EQ(sample->sample.utc, (MtUtc{5, 2026, 11, 21, 15, 10, 0, 7}));
  EXPECT_EQ(sample->sample.frame, MtFrame::ned);
  EXPECT_FALSE(mt_legacy_sample(data, {0x1000, 0}));  // a receiver's raw data
}

// ---- captures ----

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

/// A sample under the names the expected texts use.
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

/// The expected messages: "Name(format):" lines, values indented below, messages a blank line
/// apart.
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
  RoundCounter counter(65536);
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

TEST(XsensCaptures, KeepTheLawsUnderDamage) {
  WAYFARE_NEEDS_RECORDING(path, "devices/xsens/mti_mtdata2/einride_testdata/2/output.bin");
  Stream bytes = testing::file_bytes(path);
  std::vector<std::uint64_t> starts;
  each_message(bytes, [&](const XbusMessage& m) { starts.push_back(m.position()); });
  bytes.resize(starts.at(40));
  const testing::DecoderLaws<XbusDecoder> laws{bytes, text_of};
  laws.check();
  const testing::DamageReport report = laws.damage(10000);
  report.record("xbus");
  EXPECT_EQ(report.lost, 0U);
  // Eight bits of checksum: of the starts that are none, one in 256 passes. Where it does, it may
  // hide a few messages behind it.
  EXPECT_LE(static_cast<double>(report.false_frames), report.most_false(256.0));
  EXPECT_LE(static_cast<double>(report.hidden), 1e-3 * static_cast<double>(report.undamaged));
  EXPECT_GT(report.undamaged, 300'000U);
}

}  // namespace
}  // namespace wayfare::decode
