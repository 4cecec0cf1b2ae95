// Random messages added, replaced, merged and looked up, beside a list that is searched whole.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/gnss/ephemerides.hpp>

#include "abuse/abuse.hpp"
#include "gnss/sky.hpp"

namespace wayfare {
namespace {

using namespace tests;

bool from_e5a(const Ephemeris& e) {
  const auto* k = std::get_if<KeplerianEphemeris>(&e);
  return k != nullptr && k->clock_of_e5a;
}
double bias_of(const Ephemeris& e) {
  return std::visit([](const auto& x) { return x.clock_bias_s; }, e);
}

/// Every message in the order of arrival.
struct Model {
  std::vector<Ephemeris> all;

  void add(const Ephemeris& e) {
    for (Ephemeris& old : all) {
      if (satellite_of(old) != satellite_of(e) || reference_time(old) != reference_time(e) ||
          from_e5a(old) != from_e5a(e))
        continue;
      old = e;
      return;
    }
    all.push_back(e);
  }
  [[nodiscard]] const Ephemeris* nearest(SatelliteId id, Time<GpsClock> time) const {
    const auto further = [&](const Ephemeris& e) {
      const auto toe = reference_time(e);
      // Of equal distances the earlier, and then I/NAV.
      return std::tuple(toe < time ? time - toe : toe - time, toe.nanoseconds(), from_e5a(e));
    };
    const Ephemeris* best = nullptr;
    for (const Ephemeris& e : all)
      if (satellite_of(e) == id && (best == nullptr || further(e) < further(*best))) best = &e;
    return best;
  }
};

class MessageSchedule {
 public:
  explicit MessageSchedule(std::uint64_t seed) : rng_(seed) {}

  void run(int calls) {
    for (int i = 0; i < calls && !::testing::Test::HasFailure(); ++i) step();
  }

 private:
  Time<GpsClock> a_time() {
    if (rng_.below(10) == 0)
      return Time<GpsClock>() + (rng_.below(2) == 0 ? Duration::min() : Duration::max());
    return testing::sky_time() + std::chrono::hours(rng_.below(8));
  }
  Ephemeris message() {
    const int number = 1 + static_cast<int>(rng_.below(3));
    const auto system = GnssSystem(rng_.below(4));
    if (system == GnssSystem::glonass) {
      GlonassEphemeris g = testing::sky_glonass(number);
      g.toe = a_time(), g.clock_bias_s = 1e-6 * rng_.normal();
      return g;
    }
    KeplerianEphemeris k = testing::sky_message(system, number);
    k.toe = k.toc = a_time(), k.clock_bias_s = 1e-6 * rng_.normal();
    k.clock_of_e5a = system == GnssSystem::galileo && rng_.below(2) == 0;
    return k;
  }
  static void spoil(Ephemeris& e, double by) {
    std::visit([&](auto& x) { x.clock_bias_s = by; }, e);
  }

  void step() {
    switch (rng_.below(8)) {
      case 0: {
        Ephemerides other;
        Model list;
        for (std::uint64_t i = rng_.below(5); i > 0; --i) {
          const Ephemeris e = message();
          EXPECT_TRUE(other.add(e));
          list.add(e);
        }
        tested_.add(other);
        for (const Ephemeris& e : list.all) model_.add(e);
        break;
      }
      case 1: {
        Ephemeris e = message();
        spoil(e, rng_.below(2) == 0 ? kNotFinite[rng_.below(3)] : kHuge);
        EXPECT_FALSE(tested_.add(e));
        break;
      }
      case 2:
        tested_.add(tested_);
        break;
      case 3: {
        Ephemerides elsewhere(rng_.below(2) == 0 ? std::move(tested_) : tested_);
        tested_ = std::move(elsewhere);
        break;
      }
      default: {
        const Ephemeris e = message();
        EXPECT_TRUE(tested_.add(e));
        model_.add(e);
      }
    }
    check();
  }

  void check() {
    EXPECT_EQ(tested_.size(), model_.all.size());
    EXPECT_EQ(tested_.empty(), model_.all.empty());
    for (const SatelliteId id : tested_.satellites())
      EXPECT_TRUE(std::is_sorted(
          tested_.of(id).begin(), tested_.of(id).end(),
          [](const auto& a, const auto& b) { return reference_time(a) < reference_time(b); }));
    const SatelliteId id{GnssSystem(rng_.below(4)), static_cast<std::uint8_t>(rng_.below(5))};
    const Time<GpsClock> time = a_time();
    const Ephemeris *a = tested_.nearest(id, time), *b = model_.nearest(id, time);
    ASSERT_EQ(a == nullptr, b == nullptr);
    if (a == nullptr) return;
    EXPECT_EQ(reference_time(*a), reference_time(*b));
    EXPECT_EQ(bias_of(*a), bias_of(*b));
  }

  Rng rng_;
  Ephemerides tested_;
  Model model_;
};

TEST(EphemeridesSequences, EqualAListOfAllMessages) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    MessageSchedule(seed).run(80);
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace wayfare
