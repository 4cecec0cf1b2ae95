#include <wayfare/decode/xbus.hpp>

#include <cmath>
#include <numeric>

#include <wayfare/decode/detail/mt_values.hpp>
#include <wayfare/decode/mt_sample.hpp>
#include <wayfare/testing/decoder_laws.hpp>

#include "xbus_streams.hpp"

namespace wayfare::decode {
namespace {

TEST(Xbus, SumsOfBytes) {
  Rng rng(2);
  for (std::size_t n = 0; n < 200; ++n) {
    Stream bytes(n);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng());
    const auto expected = std::accumulate(bytes.begin(), bytes.end(), 0U) & 0xFFU;
    ASSERT_EQ(byte_sum(bytes), expected);
  }
}

TEST(Xbus, MessagesMatchTheManual) {
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
  // The damaged message contains the start of an apparent long one that spans the good ones after
  // it.
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

TEST(Xbus, SatisfiesTheLaws) {
  Rng rng(4);
  Stream bytes;
  for (int i = 0; i < 40; ++i) {
    Stream data(rng.below(i % 10 == 9 ? 2000 : 120));
    for (auto& byte : data) byte = rng.below(8) == 0 ? 0xFA : static_cast<std::uint8_t>(rng());
    append(bytes, message(XbusId::mt_data2, data));
  }
  const testing::DecoderLaws<XbusDecoder> laws{bytes, kAsText};
  laws.check();
  const testing::DamageReport report = laws.damage(3000);
  EXPECT_EQ(report.lost, 0U);
  EXPECT_LE(static_cast<double>(report.false_frames), report.most_false(256.0));
}

TEST(MtData2, NumbersInFourEncodings) {
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
  // A NaN is rejected.
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
  EXPECT_EQ(to_marg_sample(sample, LogTime{}).magnetic_field_uT.x(), 49.0);  // by default
  EXPECT_TRUE(std::isnan(to_marg_sample(MtSample{}, LogTime{}).angular_rate_radps.x()));
  // A tracker's: specific force, rate, half of the Earth's field.
  const AwindaMotion motion{1, 2, 1, {1, 2, 3}, {4, 5, 6}, {0.5, 0, 0}, 0};
  const MargSample marg = to_marg_sample(motion, LogTime::from_nanoseconds(7));
  EXPECT_EQ(marg.time.nanoseconds(), 7);
  EXPECT_EQ(marg.specific_force_mps2, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(marg.angular_rate_radps, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(marg.magnetic_field_uT, Eigen::Vector3d(24.5, 0, 0));
  EXPECT_EQ(to_marg_sample(motion, LogTime{}, 48.0).magnetic_field_uT.x(), 24.0);
}

TEST(MtData2, CountersWrapAround) {
  CounterUnwrapper counter(65536);
  EXPECT_EQ(counter.at(65530), 65530);
  EXPECT_EQ(counter.at(3), 65539);
  EXPECT_EQ(counter.at(65535), 65535);  // a late one
  EXPECT_EQ(counter.at(4), 65540);
  CounterUnwrapper fine(864'000'000);
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

}  // namespace
}  // namespace wayfare::decode
