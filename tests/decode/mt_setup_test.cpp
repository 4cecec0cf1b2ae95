// Settings of Xsens devices, and packets besides measurements: encoded here by the manual.
#include <wayfare/decode/mt_setup.hpp>

#include <memory>
#include <string_view>

#include <wayfare/decode/mt_raw.hpp>
#include <wayfare/decode/mt_sample.hpp>

#include "xbus_streams.hpp"

namespace wayfare::decode {
namespace {

Stream packet(std::uint16_t id, const Stream& data) {
  Stream out;
  put(out, id);
  out.push_back(static_cast<std::uint8_t>(data.size()));
  append(out, data);
  return out;
}

template <class... T>
Stream numbers_of(T... values) {
  Stream out;
  (put(out, values), ...);
  return out;
}

TEST(MtSetup, OutputConfiguration) {
  std::array<std::uint8_t, 64> out{};
  const std::vector<MtOutput> outputs = {
      {0x1020, MtOutput::kAsMeasured}, {0x2010, 100}, {0x8023, 400}};
  const std::size_t n = write_mt_outputs(0xFF, outputs, out);
  // FA FF C0 0C, four bytes for each, and the checksum.
  ASSERT_EQ(n, 17U);
  EXPECT_EQ(out[2], 0xC0);
  EXPECT_EQ(out[3], 12);
  EXPECT_EQ(byte_sum(Bytes(out).subspan(1, n - 1)), 0);
  const auto back = mt_outputs(Bytes(out).subspan(4, 12));
  ASSERT_TRUE(back);
  ASSERT_EQ(back->size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ((*back)[i], outputs[i]);
  EXPECT_FALSE(mt_outputs(Stream(7)));
  EXPECT_EQ(mt_outputs({})->size(), 0U);
  EXPECT_EQ(write_mt_outputs(0xFF, std::vector<MtOutput>(33), out), 0U);
  EXPECT_EQ(write_mt_outputs(0xFF, outputs, std::span(out).first(16)), 0U);
}

TEST(MtSetup, FilterProfiles) {
  Stream list;
  for (const auto& [id, name] :
       {std::pair{39, "general             "}, {43, "high_mag_dep        "}}) {
    list.push_back(static_cast<std::uint8_t>(id));
    list.push_back(17);
    for (const char c : std::string_view(name)) list.push_back(static_cast<std::uint8_t>(c));
  }
  const auto profiles = mt_filter_profiles(list);
  ASSERT_TRUE(profiles);
  ASSERT_EQ(profiles->size(), 2U);
  EXPECT_EQ((*profiles)[1].id, 43);
  EXPECT_EQ((*profiles)[1].version, 17);
  EXPECT_EQ((*profiles)[1].name(), "high_mag_dep");
  EXPECT_FALSE(mt_filter_profiles(Stream(23)));

  EXPECT_EQ(mt_filter_profile(Stream{17, 39})->id, 39);
  EXPECT_EQ(mt_filter_profile(Stream{17, 39})->version, 17);
  const std::string_view name = "General/RobustVRU";
  EXPECT_EQ(mt_filter_profile(Stream(name.begin(), name.end()))->name(), name);
  EXPECT_FALSE(mt_filter_profile({}));
  EXPECT_FALSE(mt_filter_profile(Stream(21, 'x')));
  EXPECT_EQ(mt_filter_profile(Stream(20, 'x'))->name().size(), 20U);

  std::array<std::uint8_t, 64> out{};
  // FA FF 64 02 00 27 and the complement of FF + 64 + 02 + 27.
  ASSERT_EQ(write_mt_filter_profile(0xFF, std::uint8_t{39}, out), 7U);
  EXPECT_EQ((Stream(out.begin(), out.begin() + 7)), (Stream{0xFA, 0xFF, 0x64, 2, 0, 0x27, 0x74}));
  EXPECT_EQ(write_mt_filter_profile(0xFF, name, out), 5 + name.size());
  EXPECT_EQ(write_mt_filter_profile(0xFF, std::uint8_t{39}, std::span(out).first(6)), 0U);
  EXPECT_EQ(mt_error_text(0x04), "message unknown or not allowed now");
  for (const auto& [code, word] : {std::pair{0x03, "period"},
                                   {0x1E, "timer"},
                                   {0x20, "baud"},
                                   {0x21, "parameter"},
                                   {0x28, "fault"},
                                   {0x29, "line"},
                                   {0x2A, "buffer"}})
    EXPECT_NE(mt_error_text(static_cast<std::uint8_t>(code)).find(word), std::string_view::npos)
        << code;
  EXPECT_EQ(mt_error_text(0x99), "");
}

TEST(MtRawTest, TimesAndCounters) {
  Stream data = packet(0x1030, numbers_of(std::uint32_t{345'600'000}));
  append(data, packet(0x10A0, numbers_of(std::uint64_t{0x123456789AULL})));
  append(data, packet(0x10B0, numbers_of(std::uint32_t{70'000})));
  append(data, packet(0x10B0, numbers_of(std::uint16_t{7})));  // of a wrong length
  const auto sample = mt_sample(data);
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->itow_ms, 345'600'000U);
  EXPECT_EQ(sample->sample_time_64, 0x123456789AULL);
  EXPECT_EQ(sample->frame_counter, 70'000U);
  EXPECT_EQ(sample->unknown, 1);
}

// Items of which the recordings have none, and others, each with its own numbers.
TEST(MtRawTest, QuantitiesByTheirNumbers) {
  Stream data = packet(0x4040, numbers_of(1.0F, 2.0F, 3.0F));
  append(data, packet(0x8040, numbers_of(4.0F, 5.0F, 6.0F)));
  append(data, packet(0x4010, numbers_of(7.0F, 8.0F, 9.0F)));
  append(data, packet(0x4030, numbers_of(10.0F, 11.0F, 12.0F)));
  append(data, packet(0x5010, numbers_of(432.5F)));
  append(data, packet(0x5020, numbers_of(480.25F)));
  append(data, packet(0x5040, numbers_of(22.5F, 114.25F)));
  append(data, packet(0x1070, numbers_of(std::uint32_t{77})));
  append(data, packet(0xE010, numbers_of(std::uint8_t{3})));
  append(data, packet(0xE020, numbers_of(std::uint32_t{0x00C00007})));
  append(data, packet(0xE040, numbers_of(std::int8_t{-60})));
  const auto s = mt_sample(data);
  ASSERT_TRUE(s);
  EXPECT_EQ(s->unknown, 0);
  EXPECT_EQ(s->acceleration_hr_mps2, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(s->rate_hr_radps, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(s->delta_v_mps, Eigen::Vector3d(7, 8, 9));
  EXPECT_EQ(s->free_acceleration_mps2, Eigen::Vector3d(10, 11, 12));
  EXPECT_EQ(s->altitude_msl_m, 432.5);
  EXPECT_EQ(s->altitude_ellipsoid_m, 480.25);
  EXPECT_EQ(s->lat_lon_deg, Eigen::Vector2d(22.5, 114.25));
  EXPECT_EQ(s->sample_time_coarse, 77U);
  EXPECT_EQ(s->status_byte, 3);
  EXPECT_EQ(s->status_word, 0x00C00007U);
  EXPECT_EQ(s->rssi_dbm, -60);
}

TEST(MtRawTest, ReadingsAndTemperatures) {
  Stream raw;
  for (std::uint16_t i = 1; i <= 9; ++i) put(raw, static_cast<std::uint16_t>(7000 * i));
  put(raw, static_cast<std::int16_t>(-2 * 256 - 64));
  Stream data = packet(0xA010, raw);
  append(data,
         packet(0xA020, numbers_of(std::int16_t{256}, std::int16_t{-128}, std::int16_t{7680})));
  const MtRawReadings readings = mt_raw_readings(data);
  ASSERT_TRUE(readings.counts);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(readings.counts->accelerometer[i], 7000 * (i + 1));
    EXPECT_EQ(readings.counts->gyroscope[i], 7000 * (i + 4));
    EXPECT_EQ(readings.counts->magnetometer[i], 7000 * (i + 7));
  }
  EXPECT_EQ(readings.counts->temperature, 0xFDC0);  // −2.25 · 256 + 65536
  EXPECT_EQ(readings.temperature_c, -2.25);
  EXPECT_EQ(*readings.gyro_temperature_c, Eigen::Vector3d(1.0, -0.5, 30.0));
  EXPECT_EQ(mt_sample(data)->unknown, 0);
  EXPECT_FALSE(mt_raw_readings(packet(0xA010, Stream(19))).counts);
  EXPECT_FALSE(mt_raw_readings(packet(0xA020, Stream(5))).gyro_temperature_c);
}

TEST(MtRawTest, Satellites) {
  Stream body = numbers_of(std::uint32_t{1000});
  append(body, {2, 0, 0, 0, 0, 11, 41, 0x1F, 6, 3, 22, 0x04});
  const Stream data = packet(0x7020, body);
  const auto satellites = mt_satellites(data);
  ASSERT_TRUE(satellites);
  ASSERT_EQ(satellites->size(), 2U);
  EXPECT_EQ(satellites->itow_ms(), 1000U);
  const std::array<std::uint8_t, 4> expected[] = {{0, 11, 41, 0x1F}, {6, 3, 22, 0x04}};
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ((*satellites)[i].system, expected[i][0]);
    EXPECT_EQ((*satellites)[i].id, expected[i][1]);
    EXPECT_EQ((*satellites)[i].cn0_dbhz, expected[i][2]);
    EXPECT_EQ((*satellites)[i].flags, expected[i][3]);
  }
  body[4] = 3;  // more than there are bytes
  EXPECT_FALSE(mt_satellites(packet(0x7020, body)));
  EXPECT_FALSE(mt_satellites(packet(0x7020, Stream(7))));
}

TEST(MtRawTest, FullSnapshot) {
  Stream body = numbers_of(std::uint16_t{9}, std::uint64_t{1ULL << 40});
  for (std::int32_t i = 1; i <= 4; ++i) put(body, -i);
  for (std::int64_t i = 1; i <= 3; ++i) put(body, i * (std::int64_t{-1} << 33));
  for (std::int32_t i = 5; i <= 7; ++i) put(body, i);
  put(body, std::int32_t{101'325});
  body.push_back(3);
  body.push_back(4);
  put(body, std::uint16_t{0x1801});
  ASSERT_EQ(body.size(), 70U);
  const auto s = mt_full_snapshot(packet(0xC820, body));
  ASSERT_TRUE(s);
  EXPECT_EQ(s->frame, 9);
  EXPECT_EQ(s->timestamp, 1ULL << 40);
  constexpr std::int64_t kUnit = std::int64_t{-1} << 33;
  EXPECT_EQ(s->orientation, (std::array<std::int32_t, 4>{-1, -2, -3, -4}));
  EXPECT_EQ(s->velocity, (std::array<std::int64_t, 3>{kUnit, 2 * kUnit, 3 * kUnit}));
  EXPECT_EQ(s->field, (std::array<std::int32_t, 3>{5, 6, 7}));
  EXPECT_EQ(s->pressure, 101'325);
  EXPECT_EQ(s->clipped_acceleration, 3);
  EXPECT_EQ(s->clipped_rate, 4);
  EXPECT_EQ(s->status, 0x1801);
  EXPECT_FALSE(mt_full_snapshot(packet(0xC820, Stream(69))));
}

TEST(MtRawTest, AGloveIsTwoPackets) {
  Stream body = numbers_of(std::uint32_t{77}, std::uint16_t{0x0FFF});
  body.push_back(0);
  for (std::int32_t finger = 0; finger < 12; ++finger) {
    for (int i = 0; i < 3; ++i) {  // 24 bits with sign
      const std::int32_t q = i == 1 ? -1000 - finger : 8'000'000 + finger;
      for (const int shift : {16, 8, 0}) body.push_back(static_cast<std::uint8_t>(q >> shift));
    }
    for (std::int32_t i = 0; i < 3; ++i) put(body, -100 * finger - i);
    for (int i = 0; i < 3; ++i) put(body, static_cast<std::int16_t>(-finger - i));
    put(body, static_cast<std::uint16_t>(finger));
    body.push_back(1);
    body.push_back(2);
  }
  ASSERT_EQ(body.size(), 255U + 124U);
  const Stream first(body.begin(), body.begin() + 255), rest(body.begin() + 255, body.end());
  Stream data = packet(0xC840, first);
  append(data, packet(0xC840, rest));
  const auto glove = mt_glove(data, true);
  ASSERT_TRUE(glove);
  EXPECT_TRUE(glove->right);
  EXPECT_EQ(glove->frame, 77U);
  EXPECT_EQ(glove->valid, 0x0FFF);
  EXPECT_EQ(glove->fingers[11].orientation,
            (std::array<std::int32_t, 3>{8'000'011, -1011, 8'000'011}));
  EXPECT_EQ(glove->fingers[11].velocity, (std::array<std::int32_t, 3>{-1100, -1101, -1102}));
  EXPECT_EQ(glove->fingers[11].field, (std::array<std::int16_t, 3>{-11, -12, -13}));
  EXPECT_EQ(glove->fingers[3].field[1], -4);
  EXPECT_EQ(glove->fingers[5].flags, 5);
  EXPECT_EQ(glove->fingers[5].clipped_acceleration, 1);
  EXPECT_EQ(glove->fingers[5].clipped_rate, 2);
  EXPECT_FALSE(mt_glove(data, false));
  EXPECT_FALSE(mt_glove(packet(0xC840, first), true)) << "the second part is missing";
  EXPECT_FALSE(mt_glove(packet(0xC840, rest), true));
  Stream twice = packet(0xC840, first);
  append(twice, packet(0xC840, first));
  EXPECT_FALSE(mt_glove(twice, true));
}

}  // namespace
}  // namespace wayfare::decode
