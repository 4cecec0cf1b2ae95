// Submap SLAM saved and restored at random moments continues bit for bit as one that was not; saved
// bytes that were changed are refused or give a map that works.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/random.hpp>

#include "abuse/slam_support.hpp"

namespace wayfare::tests {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Of many submaps, with searches for loops that run for some scans and old submaps dropped.
SubmapSlamOptions busy(int threads = 1) {
  SubmapSlamOptions o;
  o.node_distance_m = 0.05;
  o.node_turn = Angle::degrees(5);
  o.submap_nodes = 6;
  o.nodes_between_loops = 2;
  o.loop_latency_scans = 3;
  o.loop_gap_travel_m = 1.0;
  o.loop_context_nodes = 3;
  o.tables_kept = 2;
  o.max_submaps = 4;
  o.threads = threads;
  return o;
}

struct Step {
  LaserScan scan;
  MotionHint hint;
};
Step random_step(int k, Rng& rng) {
  Step s{scan_of_drive(k), {odometry_of_drive(k), {}}};
  if (rng.below(12) == 0) s.scan.ranges_m.assign(kBeams, NAN);
  if (rng.below(6) == 0) s.hint.odometry.reset();
  if (rng.below(6) == 0) s.hint.turn = Angle::radians(0.1);
  if (rng.below(20) == 0) s.hint.odometry = Odometry(SE2d(rng.normal(0.0, 5.0), 0.0, 1_rad));
  return s;
}

TEST(SubmapSequence, SavedAndRestoredAtRandomMoments) {
  constexpr int kSchedules = 40;
  std::size_t loops = 0, forgotten = 0, restored_times = 0;
  for (std::uint64_t seed = 0; seed < kSchedules; ++seed) {
    Rng rng(seed);
    std::string calls = "seed " + std::to_string(seed);
    const SubmapSlamOptions options = busy(seed % 4 == 0 ? 2 : 1);
    auto slam = std::make_unique<SubmapSlam>(options);
    SubmapSlam twin(options);
    const int from = static_cast<int>(rng.below(60)), n = 10 + static_cast<int>(rng.below(50));
    for (int k = from; k < from + n; ++k) {
      SCOPED_TRACE(calls);
      const Step step = random_step(k, rng);
      const auto a = slam->add_scan(step.scan, step.hint), b = twin.add_scan(step.scan, step.hint);
      ASSERT_TRUE(a && b);
      ASSERT_EQ(a->score, b->score);
      ASSERT_EQ(a->loop_closures, b->loop_closures);
      const std::uint64_t next = rng.below(10);
      if (next == 0 || next == 1) {
        calls += "; restore after " + std::to_string(k);
        const Bytes saved = slam->save();
        ASSERT_EQ(saved, twin.save());
        auto restored = SubmapSlam::restore(saved, options);
        ASSERT_TRUE(restored) << restored.error().to_string();
        ASSERT_EQ(restored->save(), saved);
        ASSERT_EQ(numbers_of(restored->trajectory()), numbers_of(slam->trajectory()));
        ASSERT_EQ(restored->local().T_local_base.raw().translation(),
                  slam->local().T_local_base.raw().translation());
        if (next == 0)
          slam = std::make_unique<SubmapSlam>(*std::move(restored));
        else
          *slam = *std::move(restored);
        ++restored_times;
      } else if (next == 2) {
        calls += "; finish after " + std::to_string(k);
        ASSERT_EQ(slam->finish().has_value(), twin.finish().has_value());
      }
    }
    SCOPED_TRACE(calls);
    ASSERT_EQ(slam->finish().has_value(), twin.finish().has_value());
    ASSERT_EQ(slam->save(), twin.save());
    ASSERT_TRUE(all_finite(numbers_of(slam->trajectory())));
    loops += slam->statistics().loop_closures;
    forgotten += slam->statistics().forgotten_submaps;
  }
  EXPECT_GT(loops, 10U);  // the schedules reach all parts of the state
  EXPECT_GT(forgotten, 10U);
  EXPECT_GT(restored_times, 100U);
}

constexpr std::size_t kWord = sizeof(std::uint64_t);

/// With the digest of the new contents at the end, as a hostile writer would.
void sign(Bytes& bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (std::size_t i = 0; i + kWord < bytes.size(); ++i) hash = (hash ^ bytes[i]) * 0x100000001b3;
  decode::store_le(hash, bytes.data() + bytes.size() - kWord);
}

/// States of different kinds: before the first scan, of one, with a search running, with submaps
/// dropped. Few beams keep them small.
const std::vector<Bytes>& states() {
  static const std::vector<Bytes> all = [] {
    std::vector<Bytes> made;
    for (const int scans : {0, 1, 7, 44}) {
      SubmapSlam slam(busy());
      for (int k = 0; k < scans; ++k) {
        LaserScan scan = scan_of_drive(k);
        LaserScan few = scan;
        few.ranges_m.clear();
        for (std::size_t i = 0; i < kBeams; i += 5) few.ranges_m.push_back(scan.ranges_m[i]);
        few.bearing_step = 5.0 * scan.bearing_step;
        EXPECT_TRUE(slam.add_scan(few, {odometry_of_drive(k), {}}));
      }
      made.push_back(slam.save());
    }
    return made;
  }();
  return all;
}

/// Refused, with the place, or a map that takes scans, is saved, drawn and finished.
bool refused_or_works(const Bytes& bytes, int scans) {
  auto slam = SubmapSlam::restore(bytes, busy());
  if (!slam) {
    EXPECT_EQ(slam.error().code, ErrorCode::parse) << slam.error().to_string();
    return true;
  }
  EXPECT_EQ(slam->save().size(), bytes.size());
  for (int k = 0; k < scans; ++k)
    (void)slam->add_scan(
        scan_of_room(LogTime::from_nanoseconds(INT64_MAX - 10 + k), pose_of_drive(45 + 4 * k)),
        {odometry_of_drive(45 + 4 * k), {}});
  (void)slam->finish();
  (void)slam->memory_bytes();
  EXPECT_TRUE(all_finite(numbers_of(slam->trajectory())));
  EXPECT_LT(slam->map().tiles().tile_count(), 5000U);
  return false;
}

TEST(SubmapSequence, DamagedBytesAreRefused) {
  for (const Bytes& good : states()) {
    ASSERT_TRUE(SubmapSlam::restore(good, busy()));
    const std::size_t step = 1 + good.size() / 400;
    for (std::size_t i = 0; i < good.size(); i += step) {
      for (int bit = 0; bit < 8; ++bit) {
        Bytes bad = good;
        bad[i] ^= static_cast<std::uint8_t>(1U << bit);
        ASSERT_FALSE(SubmapSlam::restore(bad, busy())) << "byte " << i << " bit " << bit;
      }
      ASSERT_FALSE(SubmapSlam::restore(std::span(good).first(i), busy())) << i;
    }
    Bytes longer = good;
    for (int i = 0; i < 20; ++i) {
      longer.push_back(static_cast<std::uint8_t>(i));
      ASSERT_FALSE(SubmapSlam::restore(longer, busy()));
    }
  }
}

// The digest is right: the values themselves must be checked. Single bits, whole words, bytes
// removed and inserted.
TEST(SubmapSequence, SignedNonsenseIsRefusedOrWorks) {
  const std::vector<double> odd = {0.0, -1.0, 1e9, 1e18, 1e300, -1e300, 5e-324};
  std::size_t refused = 0, worked = 0;
  const auto attempt = [&](Bytes bytes, const std::string& what) {
    SCOPED_TRACE(what);
    sign(bytes);
    (refused_or_works(bytes, 4) ? refused : worked) += 1;
  };
  for (std::size_t s = 0; s < states().size(); ++s) {
    const Bytes& good = states()[s];
    Rng rng(s);
    const auto at = [&](std::size_t i) {
      return "state " + std::to_string(s) + " byte " + std::to_string(i);
    };
    const std::size_t content = good.size() - 2 * kWord;
    for (int trial = 0; trial < 50; ++trial) {
      const std::size_t i = kWord + rng.below(content);
      Bytes bad = good;
      bad[i] ^= static_cast<std::uint8_t>(1U << rng.below(8));
      attempt(std::move(bad), at(i));
    }
    for (int trial = 0; trial < 50; ++trial) {
      const std::size_t i = kWord + rng.below(content - kWord);
      Bytes bad = good;
      if (trial % 3 == 0)
        decode::store_le(odd[rng.below(odd.size())], bad.data() + i);
      else if (trial % 3 == 1)
        decode::store_le(rng.below(2) == 0 ? INT32_MAX : INT32_MIN, bad.data() + i);
      else
        decode::store_le(rng.below(2) == 0 ? INT64_MAX : INT64_MIN, bad.data() + i);
      attempt(std::move(bad), at(i) + " word");
    }
    for (int trial = 0; trial < 20; ++trial) {
      const auto i = static_cast<std::ptrdiff_t>(kWord + rng.below(content));
      Bytes bad = good;
      if (trial % 2 == 0)
        bad.erase(bad.begin() + i);
      else
        bad.insert(bad.begin() + i, static_cast<std::uint8_t>(rng.below(256)));
      attempt(std::move(bad), at(static_cast<std::size_t>(i)) + " moved");
    }
  }
  EXPECT_GT(refused, 40U);
  EXPECT_GT(worked, 40U);
}

// Counts of 1e9 and more at every place of a state that could be one.
TEST(SubmapSequence, ClaimedSizesDoNotAllocate) {
  for (const Bytes& good : states())
    for (std::size_t i = kWord; i + 2 * kWord <= good.size(); i += 1 + good.size() / 300)
      for (const std::uint64_t n :
           {std::uint64_t{1'000'000'000}, std::uint64_t{1} << 40, UINT64_MAX}) {
        Bytes bad = good;
        decode::store_le(n, bad.data() + i);
        sign(bad);
        (void)refused_or_works(bad, 0);
      }
}

// Another set of options than it was saved under.
TEST(SubmapSequence, RestoredUnderOtherOptions) {
  for (const Bytes& good : states())
    for (int variant = 0; variant < 6; ++variant) {
      SubmapSlamOptions o = busy();
      if (variant == 0) o = {};
      if (variant == 1) o.submap_nodes = 1;
      if (variant == 2) o.max_submaps = 1;
      if (variant == 3) o.grid.finest.resolution_m = 0.5;
      if (variant == 4) o.loop_latency_scans = 0;
      if (variant == 5) o.grid.levels = 1;
      auto slam = SubmapSlam::restore(good, o);
      ASSERT_TRUE(slam);
      for (int k = 44; k < 60; ++k)
        ASSERT_TRUE(slam->add_scan(scan_of_drive(k), {odometry_of_drive(k), {}}));
      EXPECT_TRUE(slam->finish());
      EXPECT_TRUE(all_finite(numbers_of(slam->trajectory())));
    }
}

}  // namespace
}  // namespace wayfare::tests
