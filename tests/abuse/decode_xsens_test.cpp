// The content of Xsens messages, counters, and Awinda stations at their edges.
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/decode/awinda.hpp>
#include <wayfare/decode/mt_sample.hpp>

#include "abuse/abuse.hpp"
#include "abuse/decode_streams.hpp"

namespace wayfare::decode {
namespace {

using tests::kNotFinite;
using tests::Stream;

void append_be(Stream& out, double value) {
  out.resize(out.size() + 8);
  store_be(value, &out[out.size() - 8]);
}

// ---- MTData2 and MTData ----

TEST(MtAbuse, EveryIdWithEveryLength) {
  Rng rng(5);
  for (unsigned id = 0; id <= 0xFFFF; id += 1 + static_cast<unsigned>(rng.below(3)))
    for (const std::size_t n : {0U, 1U, 2U, 4U, 12U, 16U, 18U, 24U, 36U, 46U, 72U, 94U, 255U}) {
      Stream data = {static_cast<std::uint8_t>(id >> 8), static_cast<std::uint8_t>(id),
                     static_cast<std::uint8_t>(n)};
      data.resize(3 + n, static_cast<std::uint8_t>(rng()));
      const auto sample = mt_sample(data);
      ASSERT_TRUE(sample);
      static_cast<void>(to_marg_sample(*sample, LogTime{}));
      ASSERT_EQ(awinda_snapshot(data).has_value(), (id == 0xC810 || id == 0xC811) && n == 46);
      data.pop_back();
      ASSERT_FALSE(mt_sample(data)) << "one byte short";
    }
}

TEST(MtAbuse, NumbersThatAreNotFiniteAreMissing) {
  for (const double bad : kNotFinite)
    for (std::size_t k = 0; k < 3; ++k) {
      Stream data = {
          0x80,
          0x23,
          24,
      };
      for (std::size_t i = 0; i < 3; ++i) append_be(data, i == k ? bad : 1e9);
      data.insert(data.end(), {0x40, 0x23, 24});
      for (int i = 0; i < 3; ++i) append_be(data, 1e300);
      const auto sample = mt_sample(data);
      ASSERT_TRUE(sample);
      EXPECT_FALSE(sample->rate_radps);
      EXPECT_EQ(sample->unknown, 1);
      EXPECT_EQ(sample->acceleration_mps2, Eigen::Vector3d::Constant(1e300));
      EXPECT_FALSE(to_imu_sample(*sample, LogTime{}));
      const MtLegacyLayout layout{0x0002, 0x300 | 0x40};
      Stream legacy;
      for (std::size_t i = 0; i < 6; ++i) append_be(legacy, i == k ? bad : 1.0);
      EXPECT_FALSE(mt_legacy_sample(legacy, layout));
    }
}

TEST(MtAbuse, TheLastOfRepeatedPacketsCounts) {
  const auto sample = mt_sample(Stream{0x10, 0x20, 2, 0, 1, 0x10, 0x20, 2, 0, 2});
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->packet_counter, 2);
}

TEST(MtAbuse, LegacyLayoutsOfAnySetting) {
  Rng rng(6);
  std::size_t read = 0;
  for (int trial = 0; trial < 100'000; ++trial) {
    const MtLegacyLayout layout{static_cast<std::uint16_t>(rng()),
                                static_cast<std::uint32_t>(rng())};
    read += mt_legacy_sample(Stream(rng.below(200)), layout) ? 1U : 0U;
  }
  EXPECT_GT(read, 100U);
  EXPECT_TRUE(mt_legacy_sample({}, {}));
}

// ---- counters ----

TEST(CounterUnwrapperAbuse, SmallPeriodsAndLargeCounts) {
  CounterUnwrapper one(1);
  for (const std::uint32_t count : {0U, 5U, 0xFFFFFFFFU}) EXPECT_EQ(one.at(count), 0);
  CounterUnwrapper three(3);
  EXPECT_EQ(three.at(0), 0);
  EXPECT_EQ(three.at(2), -1);
  EXPECT_EQ(three.at(1), -2);
  // A count beyond the period is that of another turn.
  CounterUnwrapper day(864'000'000);
  EXPECT_EQ(day.at(0xFFFFFFFFU), 0xFFFFFFFFLL % 864'000'000);
}

TEST(CounterUnwrapperAbuse, AgreesWithASum) {
  Rng rng(7);
  for (const std::uint64_t period : {std::uint64_t{65536}, std::uint64_t{864'000'000},
                                     std::uint64_t{1} << 32, std::uint64_t{7}}) {
    CounterUnwrapper counter(period);
    const auto p = static_cast<std::int64_t>(period);
    std::int64_t total = 0;
    ASSERT_EQ(counter.at(0), 0);
    for (int i = 0; i < 20'000; ++i) {
      total += static_cast<std::int64_t>(rng.below((period + 1) / 2)) - (p - 1) / 4;
      ASSERT_EQ(counter.at(static_cast<std::uint32_t>(((total % p) + p) % p)), total);
    }
  }
}

TEST(MtAbuseDeathTest, ACounterHasAPeriod) {
  EXPECT_DEATH(CounterUnwrapper(0), "period");
  EXPECT_DEATH(CounterUnwrapper((std::uint64_t{1} << 32) + 1), "period");
  EXPECT_DEATH(static_cast<void>(AwindaConfiguration{}.tracker(0)), "tracker");
}

// ---- Awinda ----

AwindaSnapshot frame_of(std::uint32_t frame, bool retransmitted = false) {
  AwindaSnapshot s;
  s.frame = frame;
  s.retransmitted = retransmitted;
  return s;
}

TEST(AwindaAbuse, ACounterThatRestartsIsAnotherSequence) {
  AwindaStation<> station(0.01);
  std::vector<std::uint32_t> frames;
  const auto sink = [&](const AwindaMotion& m) {
    frames.push_back(m.frame);
    EXPECT_EQ(m.frames, 1U);
  };
  for (const std::uint32_t first : {100'000U, 0U})
    for (std::uint32_t i = 0; i < 50; ++i) station.add(frame_of(first + i), sink);
  station.finish(sink);
  EXPECT_EQ(frames.size(), 98U) << "49 motions of either, and none between them";
  EXPECT_EQ(station.late() + station.missing(), 0U);
}

TEST(AwindaAbuse, ADamagedFrameNumberCostsNoMoreThanItsNeighbours) {
  for (const std::uint32_t damage : {1U << 7, 1U << 20, 1U << 30, 1U << 31}) {
    AwindaStation<> station(0.01);
    std::size_t motions = 0;
    const auto sink = [&](const AwindaMotion& m) {
      ++motions;
      EXPECT_GT(m.frames, 0U);
      EXPECT_TRUE(m.rate_radps.allFinite() && m.acceleration_mps2.allFinite());
    };
    for (std::uint32_t i = 0; i < 1000; ++i) station.add(frame_of(i == 500 ? i ^ damage : i), sink);
    station.finish(sink);
    EXPECT_GE(motions, 996U) << damage;
    EXPECT_LE(motions, 999U) << damage;
  }
}

TEST(AwindaAbuse, AnOldRetransmissionIsLate) {
  AwindaReorderBuffer<> order;
  std::size_t seen = 0;
  const auto sink = [&](const AwindaSnapshot&) { ++seen; };
  order.add(frame_of(10'000), sink);
  order.add(frame_of(5, true), sink);
  order.add(frame_of(10'001), sink);
  order.finish(sink);
  EXPECT_EQ(seen, 2U);
  EXPECT_EQ(order.late(), 1U);
  order.finish(sink);
  EXPECT_EQ(seen, 2U) << "nothing is delivered twice";
}

TEST(AwindaAbuse, WithoutAPeriodThereIsNoMotion) {
  for (const double period : {0.0, -0.01, tests::kNan, tests::kInf, -tests::kInf}) {
    AwindaStation<4, 8> station(period);
    const auto sink = [](const AwindaMotion&) { FAIL(); };
    for (std::uint32_t i = 0; i < 10; ++i) station.add(frame_of(i), sink);
    station.finish(sink);
    EXPECT_EQ(station.refused(), 10U);
  }
  Stream configuration(98);
  EXPECT_EQ(awinda_configuration(configuration)->period_s, 0.0);
}

TEST(AwindaAbuse, AnyBitsAreAFiniteMotion) {
  Rng rng(8);
  for (int trial = 0; trial < 20'000; ++trial) {
    std::array<AwindaSnapshot, 2> s;
    for (AwindaSnapshot& one : s) {
      constexpr std::array<std::int32_t, 5> kEdges = {INT32_MIN, -1, 0, 1, INT32_MAX};
      for (std::size_t i = 0; i < 3; ++i) {
        one.orientation[i] =
            trial % 2 == 0 ? kEdges[rng.below(5)] : static_cast<std::int32_t>(rng());
        one.velocity[i] = trial % 2 == 0 ? kEdges[rng.below(5)] : static_cast<std::int32_t>(rng());
      }
      one.status = static_cast<std::uint16_t>(rng());
    }
    s[1].frame = s[0].frame + 1 + static_cast<std::uint32_t>(rng.below(100));
    const AwindaMotion m = awinda_motion(s[0], s[1], 1e-3);
    ASSERT_TRUE(m.rate_radps.allFinite() && m.acceleration_mps2.allFinite()) << trial;
    ASSERT_LE(m.rate_radps.norm(), 3.1416e3);
  }
}

TEST(AwindaAbuse, StationsAreValues) {
  using Station = AwindaStation<2, 8>;
  Station station(0.01);
  for (const std::uint32_t i : {1U, 3U, 4U}) station.add(frame_of(i), [](const AwindaMotion&) {});
  tests::expect_value_semantics(station, [](Station& s) {
    std::vector<std::uint32_t> seen;
    const auto sink = [&](const AwindaMotion& m) { seen.push_back(m.frame); };
    s.add(frame_of(2, true), sink);
    s.finish(sink);
    seen.push_back(static_cast<std::uint32_t>(s.missing()));
    return seen;
  });
}

TEST(AwindaAbuse, TwoStationsInTwoThreads) {
  const auto both = tests::in_two_threads([](int) {
    const auto station = std::make_unique<AwindaStation<>>(0.01);
    std::vector<std::uint32_t> seen;
    const auto sink = [&](const AwindaMotion& m) { seen.push_back(m.frame); };
    Rng rng(9);
    for (std::uint32_t i = 0; i < 2000; ++i)
      station->add(frame_of(i - static_cast<std::uint32_t>(rng.below(20)), true), sink);
    station->finish(sink);
    return seen;
  });
  EXPECT_EQ(both[0], both[1]);
  EXPECT_GT(both[0].size(), 1000U);
}

}  // namespace
}  // namespace wayfare::decode
