// Random streams of scans and odometry, in which things are missing, duplicated, out of order, not
// finite or far away, against a model: a scan is refused by its own contents and the time of the
// last one accepted; a refused one leaves no trace, which a twin shows that never sees any.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

#include "abuse/slam_support.hpp"

namespace wayfare::tests {
namespace {

/// One call, and whether it is valid apart from its time.
struct Call {
  std::string what;
  LaserScan scan;
  std::optional<Odometry> odometry;
  bool valid = true;
};

Call random_call(int k, Rng& rng) {
  Call c{"scan " + std::to_string(k), scan_of_drive(k), odometry_of_drive(k)};
  const auto also = [&](const char* what) { c.what += std::string(", ") + what; };
  const auto number = [&] { return kNotFinite[rng.below(kNotFinite.size())]; };
  switch (rng.below(16)) {
    case 0:
      also("no beams"), c.scan.ranges_m.clear(), c.valid = false;
      break;
    case 1:
      also("bearing"), c.scan.first_bearing = Angle::radians(number()), c.valid = false;
      break;
    case 2:
      also("no returns"), c.scan.ranges_m.assign(kBeams, NAN);
      break;
    case 3:
      also("early"), c.scan.time = c.scan.time - Duration(1'000'000'000);
      break;
    case 4:
      also("same time"), c.scan.time = c.scan.time - Duration(200'000'000);
      break;
    case 5:
      also("some ranges not finite");
      for (float& r : c.scan.ranges_m)
        if (rng.uniform() < 0.3) r = static_cast<float>(number());
      break;
    case 6:
      also("few beams"), c.scan.ranges_m.resize(1 + rng.below(12));
      break;
    default:
      break;
  }
  switch (rng.below(12)) {
    case 0:
    case 1:
      also("no odometry"), c.odometry.reset();
      break;
    case 2:
      also("odometry not finite"), c.odometry = Odometry(SE2d(0.0, number(), Angle{}));
      c.valid = false;
      break;
    case 3:
      also("odometry far away");
      c.odometry = Odometry(SE2d(1e9, rng.uniform(-1.0, 1.0), Angle{}));
      c.valid = false;
      break;
    case 4:
      also("odometry leaps");
      c.odometry = Odometry(SE2d(rng.normal(0.0, 100.0), rng.normal(0.0, 100.0), 1_rad));
      break;
    case 5:
      also("odometry stays"), c.odometry = odometry_of_drive(std::max(0, k - 1));
      break;
    default:
      break;
  }
  return c;
}

template <class Driver>
class SlamSequence : public ::testing::Test {};
using Drivers = ::testing::Types<GraphDriver, HectorDriver, SubmapDriver>;
TYPED_TEST_SUITE(SlamSequence, Drivers);

TYPED_TEST(SlamSequence, RefusalsLeaveNoTrace) {
  constexpr int kCalls = 14;
  constexpr int kSchedules = std::is_same_v<TypeParam, SubmapDriver> ? 40 : 120;
  for (std::uint64_t seed = 0; seed < kSchedules; ++seed) {
    Rng rng(seed);
    std::string calls = "seed " + std::to_string(seed);
    auto slam = std::make_unique<TypeParam>();
    TypeParam twin;
    std::optional<LogTime> last;
    std::size_t accepted = 0;
    int k = static_cast<int>(rng.below(60));
    for (int i = 0; i < kCalls; ++i, k += static_cast<int>(1 + rng.below(10) / 9)) {
      const Call call = random_call(k, rng);
      calls += "; " + call.what;
      SCOPED_TRACE(calls);
      const bool expected = call.valid && (!last || call.scan.time >= *last);
      const auto outcome = slam->add(call.scan, call.odometry);
      ASSERT_EQ(outcome.has_value(), expected);
      if (expected) {
        last = call.scan.time;
        ++accepted;
        const auto same = twin.add(call.scan, call.odometry);
        ASSERT_TRUE(same);
        ASSERT_EQ(same->score, outcome->score);
        ASSERT_TRUE(outcome->score >= 0.0 && outcome->score <= 1.0);
      }
      const std::uint64_t next = rng.below(20);
      if (next == 0) {
        calls += "; finish";
        ASSERT_TRUE(slam->finish() && twin.finish());
      } else if (next == 1) {
        calls += "; move";
        slam = std::make_unique<TypeParam>(std::move(*slam));
      }
      ASSERT_EQ(slam->scans(), accepted);
      ASSERT_LE(slam->unmatched(), accepted);
    }
    SCOPED_TRACE(calls);
    ASSERT_TRUE(slam->finish() && twin.finish());
    const std::vector<double> path = numbers_of(slam->trajectory());
    ASSERT_EQ(path.size(), 5 * accepted);
    ASSERT_TRUE(all_finite(path));
    ASSERT_EQ(numbers_of(*slam), numbers_of(twin));
  }
}

}  // namespace
}  // namespace wayfare::tests
