// Estimators that run in a driver's callback must not allocate.

#include <cstddef>

#include <gtest/gtest.h>

#include <wayfare/inertial/ahrs.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>

#include "core/counted_heap.hpp"
#include "motion.hpp"

namespace wayfare {
namespace {

using tests::allocations;

template <class Estimator>
std::size_t allocations_of(Estimator& estimator, const MargRecording& samples) {
  const std::size_t before = allocations;
  for (const MargSample& s : samples) estimator.add(s);
  return allocations - before;
}

TEST(NoHeap, AttitudeAndPedestrianAllocateNothing) {
  WAYFARE_NEEDS_COUNTED_HEAP();
  testing::MotionOptions o;
  o.duration_s = 30.0;
  const auto motion = testing::simulate(o);
  Ahrs<frame::Ned> exact;
  Ahrs<frame::Enu, float> quick;
  PedestrianParameters p;
  p.magnetic_drift.offset_sigma_uT = 50.0;
  p.ahrs.heading_history_s = 1.0;
  Pedestrian pedestrian(p);
  EXPECT_EQ(allocations_of(exact, motion.samples), 0U);
  EXPECT_EQ(allocations_of(quick, motion.samples), 0U);
  EXPECT_EQ(allocations_of(pedestrian, motion.samples), 0U);
}

}  // namespace
}  // namespace wayfare
