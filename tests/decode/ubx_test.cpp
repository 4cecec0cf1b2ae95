#include <wayfare/decode/ubx_messages.hpp>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/testing/decoder_laws.hpp>

#include "ubx_streams.hpp"

namespace wayfare::decode {
namespace {

template <class F>
DecoderStatistics each_ubx(const UbxBytes& bytes, F&& f) {
  const auto decoder = std::make_unique<UbxDecoder>();
  decoder->feed(bytes, f);
  decoder->finish(f);
  return decoder->statistics();
}

TEST(Ubx, SatisfiesTheLawsOfDecoders) {
  Rng rng(1);
  UbxBytes stream;
  for (int i = 0; i < 40; ++i) {
    UbxBytes payload(rng.below(120));
    for (std::uint8_t& byte : payload) byte = static_cast<std::uint8_t>(rng());
    append_bytes(stream, ubx(static_cast<UbxId>(rng.below(0x10000)), payload));
  }
  testing::DecoderLaws<UbxDecoder> laws{
      stream, [](const UbxMessage& m) { return std::string(m.bytes().begin(), m.bytes().end()); }};
  laws.work_per_byte = 3.0;
  laws.check();
  const testing::DamageReport report = laws.damage(1000);
  EXPECT_EQ(report.lost, 0U);
  EXPECT_LE(static_cast<double>(report.false_frames), report.most_false(65536.0));
}

// The poll request of MON-VER in u-center's list of messages: B5 62 0A 04 00 00 0E 34.
TEST(Ubx, ChecksumOfAKnownMessage) {
  const UbxBytes known = {0xB5, 0x62, 0x0A, 0x04, 0x00, 0x00, 0x0E, 0x34};
  EXPECT_EQ(ubx(static_cast<UbxId>(0x0A04), {}), known);
}

TEST(Ubx, RawMeasurementsReadBack) {
  const std::vector<UbxMeasurement> sent = sample_measurements();
  const UbxBytes bytes = rawx({345678.25, 2200, 18, true, false}, sent);
  std::size_t epochs = 0;
  each_ubx(bytes, [&](const UbxMessage& m) {
    const auto raw = rxm_rawx(m);
    ASSERT_TRUE(raw);
    ++epochs;
    EXPECT_EQ(raw->epoch().time_of_week_s, 345678.25);
    EXPECT_EQ(raw->epoch().week, 2200);
    EXPECT_EQ(raw->epoch().leap_seconds, 18);
    EXPECT_TRUE(raw->epoch().leap_seconds_known);
    EXPECT_FALSE(raw->epoch().clock_reset);
    ASSERT_EQ(raw->size(), sent.size());
    for (std::size_t i = 0; i < sent.size(); ++i) {
      const UbxMeasurement got = raw->measurement(i);
      EXPECT_EQ(got.pseudorange_m, sent[i].pseudorange_m);
      EXPECT_EQ(got.carrier_phase_cycles, sent[i].carrier_phase_cycles);
      EXPECT_EQ(got.doppler_hz, sent[i].doppler_hz);
      EXPECT_EQ(got.gnss, sent[i].gnss);
      EXPECT_EQ(got.satellite, sent[i].satellite);
      EXPECT_EQ(got.signal, sent[i].signal);
      EXPECT_EQ(got.glonass_channel, sent[i].glonass_channel);
      EXPECT_DOUBLE_EQ(got.lock_time_s, sent[i].lock_time_s);
      EXPECT_EQ(got.cn0_db_hz, sent[i].cn0_db_hz);
      EXPECT_DOUBLE_EQ(got.pseudorange_sigma_m, sent[i].pseudorange_sigma_m);
      EXPECT_DOUBLE_EQ(got.carrier_phase_sigma_cycles, sent[i].carrier_phase_sigma_cycles);
      EXPECT_DOUBLE_EQ(got.doppler_sigma_hz, sent[i].doppler_sigma_hz);
      EXPECT_EQ(got.pseudorange_valid, sent[i].pseudorange_valid);
      EXPECT_EQ(got.carrier_phase_valid, sent[i].carrier_phase_valid);
      EXPECT_EQ(got.half_cycle_resolved, sent[i].half_cycle_resolved);
      EXPECT_EQ(got.half_cycle_subtracted, sent[i].half_cycle_subtracted);
    }
  });
  EXPECT_EQ(epochs, 1U);
}

// As the interface description numbers messages (class, id) and systems (gnssId).
TEST(Ubx, NumbersOfMessagesAndSystems) {
  EXPECT_EQ(static_cast<int>(UbxId::nav_pvt), 0x0107);
  EXPECT_EQ(static_cast<int>(UbxId::rxm_sfrbx), 0x0213);
  EXPECT_EQ(static_cast<int>(UbxId::rxm_rawx), 0x0215);
  EXPECT_EQ(static_cast<int>(UbxGnss::gps), 0);
  EXPECT_EQ(static_cast<int>(UbxGnss::sbas), 1);
  EXPECT_EQ(static_cast<int>(UbxGnss::galileo), 2);
  EXPECT_EQ(static_cast<int>(UbxGnss::beidou), 3);
  EXPECT_EQ(static_cast<int>(UbxGnss::qzss), 5);
  EXPECT_EQ(static_cast<int>(UbxGnss::glonass), 6);
  EXPECT_EQ(static_cast<int>(UbxGnss::navic), 7);
}

// Byte by byte: a message with each bit of its two fields of flags, and with the exponents of the
// standard deviations beside bits that are not theirs.
TEST(Ubx, FlagsAndExponentsOfRawMeasurements) {
  for (unsigned bit = 0; bit < 8; ++bit) {
    UbxBytes p(16 + 32);
    p[10] = 0xEE;  // −18
    p[11] = 1;
    p[12] = p[46] = static_cast<std::uint8_t>(1U << bit);
    p[36] = 6, p[37] = 4, p[38] = 2, p[39] = 13;  // channel 13 − 7
    store_le<std::uint16_t>(1500, &p[40]);
    p[43] = 0xF5, p[44] = 0xF2, p[45] = 0xF7;  // the lower four bits: 5, 2, 7
    int seen = 0;
    each_ubx(ubx(UbxId::rxm_rawx, p), [&](const UbxMessage& message) {
      ++seen;
      const auto raw = rxm_rawx(message);
      ASSERT_TRUE(raw);
      EXPECT_EQ(raw->epoch().leap_seconds, -18);
      EXPECT_EQ(raw->epoch().leap_seconds_known, bit == 0);
      EXPECT_EQ(raw->epoch().clock_reset, bit == 1);
      const UbxMeasurement m = raw->measurement(0);
      EXPECT_EQ(m.gnss, UbxGnss::glonass);
      EXPECT_EQ(m.signal, 2);
      EXPECT_EQ(m.glonass_channel, 6);
      EXPECT_DOUBLE_EQ(m.lock_time_s, 1.5);
      EXPECT_DOUBLE_EQ(m.pseudorange_sigma_m, 0.32);          // 0.01 · 2⁵
      EXPECT_DOUBLE_EQ(m.carrier_phase_sigma_cycles, 0.008);  // 0.004 · 2
      EXPECT_DOUBLE_EQ(m.doppler_sigma_hz, 0.256);            // 0.002 · 2⁷
      EXPECT_EQ(m.pseudorange_valid, bit == 0);
      EXPECT_EQ(m.carrier_phase_valid, bit == 1);
      EXPECT_EQ(m.half_cycle_resolved, bit == 2);
      EXPECT_EQ(m.half_cycle_subtracted, bit == 3);
    });
    EXPECT_EQ(seen, 1);
  }
}

TEST(Ubx, SubframeWords) {
  int seen = 0;
  UbxBytes payload = {2, 11, 1, 0, 3, 0, 2, 0};
  for (const std::uint32_t word : {0x8B0000AAU, 1U, 0xFFFFFFFFU}) put_le(payload, word);
  each_ubx(ubx(UbxId::rxm_sfrbx, payload), [&](const UbxMessage& m) {
    ++seen;
    const auto frame = rxm_sfrbx(m);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->gnss(), UbxGnss::galileo);
    EXPECT_EQ(frame->satellite(), 11);
    EXPECT_EQ(frame->signal(), 1);
    ASSERT_EQ(frame->size(), 3U);
    EXPECT_EQ(frame->word(0), 0x8B0000AAU);
    EXPECT_EQ(frame->word(1), 1U);
    EXPECT_EQ(frame->word(2), 0xFFFFFFFFU);
    EXPECT_EQ(frame->glonass_channel(), 0);
  });
  payload[0] = 6, payload[3] = 4;  // of GLONASS, 4 − 7
  each_ubx(ubx(UbxId::rxm_sfrbx, payload), [&](const UbxMessage& m) {
    ++seen;
    const auto frame = rxm_sfrbx(m);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->gnss(), UbxGnss::glonass);
    EXPECT_EQ(frame->glonass_channel(), -3);
  });
  EXPECT_EQ(seen, 2);
}

TEST(Ubx, PositionVelocityTime) {
  int seen = 0;
  UbxBytes p(92);
  store_le<std::uint32_t>(123456000, &p[0]);
  store_le<std::uint16_t>(2022, &p[4]);
  p[6] = 7, p[7] = 8, p[8] = 10, p[9] = 17, p[10] = 18, p[11] = 0x37;
  store_le<std::int32_t>(-1250, &p[16]);
  p[20] = 3, p[21] = 0x83, p[23] = 21;
  store_le<std::int32_t>(-756'972'000, &p[24]);
  store_le<std::int32_t>(454'215'123, &p[28]);
  store_le<std::int32_t>(-31'250, &p[32]);
  store_le<std::int32_t>(2'500, &p[36]);
  store_le<std::uint32_t>(14, &p[40]);
  store_le<std::int32_t>(-12'345, &p[48]);
  store_le<std::int32_t>(-4'500'000, &p[64]);
  store_le<std::uint16_t>(123, &p[76]);
  each_ubx(ubx(UbxId::nav_pvt, p), [&](const UbxMessage& m) {
    ++seen;
    const auto v = nav_pvt(m);
    ASSERT_TRUE(v);
    EXPECT_DOUBLE_EQ(v->time_of_week_s, 123456.0);
    EXPECT_EQ(v->year * 10000 + v->month * 100 + v->day, 20220708);
    EXPECT_EQ(v->hour * 10000 + v->minute * 100 + v->second, 101718);
    EXPECT_TRUE(v->date_valid && v->time_valid && v->time_resolved);
    EXPECT_EQ(v->nanosecond, -1250);
    EXPECT_EQ(v->fix_type, 3);
    EXPECT_TRUE(v->fix_ok && v->differential);
    EXPECT_EQ(v->carrier_solution, 2);
    EXPECT_EQ(v->satellites, 21);
    EXPECT_DOUBLE_EQ(v->longitude_deg, -75.6972);
    EXPECT_DOUBLE_EQ(v->latitude_deg, 45.4215123);
    EXPECT_DOUBLE_EQ(v->height_m, -31.25);
    EXPECT_DOUBLE_EQ(v->height_above_sea_m, 2.5);
    EXPECT_DOUBLE_EQ(v->horizontal_sigma_m, 0.014);
    EXPECT_DOUBLE_EQ(v->velocity_ned_mps[0], -12.345);
    EXPECT_DOUBLE_EQ(v->course_deg, -45.0);
    EXPECT_DOUBLE_EQ(v->pdop, 1.23);
  });
  EXPECT_EQ(seen, 1);
}

// Flags valid (byte 11) and flags (byte 21) bit by bit, accuracies and the other velocities.
TEST(Ubx, AccuraciesAndFlagsOfAPosition) {
  UbxBytes p(92);
  store_le<std::uint32_t>(25, &p[12]);
  store_le<std::uint32_t>(23, &p[44]);
  store_le<std::int32_t>(1'500, &p[52]);
  store_le<std::int32_t>(-2'500, &p[56]);
  store_le<std::int32_t>(12'500, &p[60]);
  store_le<std::uint32_t>(340, &p[68]);
  store_le<std::uint32_t>(150'000, &p[72]);
  int seen = 0;
  for (int bit = 0; bit < 8; ++bit) {
    p[11] = p[21] = static_cast<std::uint8_t>(1 << bit);
    each_ubx(ubx(UbxId::nav_pvt, p), [&](const UbxMessage& m) {
      ++seen;
      const auto v = nav_pvt(m);
      ASSERT_TRUE(v);
      EXPECT_EQ(v->date_valid, bit == 0);
      EXPECT_EQ(v->time_valid, bit == 1);
      EXPECT_EQ(v->time_resolved, bit == 2);
      EXPECT_EQ(v->fix_ok, bit == 0);
      EXPECT_EQ(v->differential, bit == 1);
      EXPECT_EQ(v->carrier_solution, bit < 6 ? 0 : bit - 5);
      EXPECT_DOUBLE_EQ(v->time_sigma_s, 25e-9);
      EXPECT_DOUBLE_EQ(v->vertical_sigma_m, 0.023);
      EXPECT_DOUBLE_EQ(v->velocity_ned_mps[1], 1.5);
      EXPECT_DOUBLE_EQ(v->velocity_ned_mps[2], -2.5);
      EXPECT_DOUBLE_EQ(v->ground_speed_mps, 12.5);
      EXPECT_DOUBLE_EQ(v->speed_sigma_mps, 0.34);
      EXPECT_DOUBLE_EQ(v->course_sigma_deg, 1.5);
    });
  }
  EXPECT_EQ(seen, 8);
}

TEST(Ubx, LengthsThatDoNotFitAreRefused) {
  UbxBytes payload(16 + 32);
  payload[11] = 2;  // says two measurements, has one
  int seen = 0;
  const auto refused = [&](const UbxMessage& m) {
    ++seen;
    EXPECT_FALSE(rxm_rawx(m));
    EXPECT_FALSE(rxm_sfrbx(m));
    EXPECT_FALSE(nav_pvt(m));
  };
  each_ubx(ubx(UbxId::rxm_rawx, payload), refused);
  each_ubx(ubx(UbxId::rxm_rawx, {}), refused);
  each_ubx(ubx(UbxId::rxm_sfrbx, {0, 1, 0, 0, 9, 0, 2, 0}), refused);
  each_ubx(ubx(UbxId::nav_pvt, UbxBytes(84)), refused);
  EXPECT_EQ(seen, 4);
}

// A payload of 8192 bytes is the longest: RXM-RAWX with 255 measurements has 8176.
TEST(Ubx, TheLongestPayload) {
  for (const std::size_t length : {std::size_t{8192}, std::size_t{8193}}) {
    const auto s = each_ubx(ubx(UbxId::rxm_rawx, UbxBytes(length)), [](const UbxMessage&) {});
    EXPECT_EQ(s.frames, length == 8192 ? 1U : 0U);
    EXPECT_EQ(s.malformed, length == 8192 ? 0U : 1U);
  }
}

TEST(Ubx, ATooLongPayloadIsMalformed) {
  UbxBytes bytes = {0xB5, 0x62, 0x02, 0x15, 0xFF, 0xFF};
  append_bytes(bytes, ubx(UbxId::nav_pvt, UbxBytes(92)));
  int messages = 0;
  const DecoderStatistics s = each_ubx(bytes, [&](const UbxMessage&) { ++messages; });
  EXPECT_EQ(messages, 1);
  EXPECT_EQ(s.malformed, 1U);
  EXPECT_EQ(s.skipped_bytes, 6U);
}

}  // namespace
}  // namespace wayfare::decode
