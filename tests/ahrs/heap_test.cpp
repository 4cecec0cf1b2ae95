// Estimators that run in a driver's callback must not wait for the heap.

#include <cstddef>
#include <cstdlib>
#include <memory>

#include <gtest/gtest.h>

#include <wayfare/estimate/ahrs.hpp>
#include <wayfare/estimate/pedestrian.hpp>
#include "ahrs/motion.hpp"

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define WAYFARE_OWN_MALLOC 0
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(__GLIBC__)
#define WAYFARE_OWN_MALLOC 0
#endif
#ifndef WAYFARE_OWN_MALLOC
#define WAYFARE_OWN_MALLOC 1
#endif

namespace {
std::size_t allocations = 0;
std::unique_ptr<Eigen::VectorXd> kept;  // out of the optimiser's sight
}  // namespace

#if WAYFARE_OWN_MALLOC
// What Eigen and operator new take their memory from.
extern "C" {
void* __libc_malloc(std::size_t size);
void* malloc(std::size_t size) noexcept {
  ++allocations;
  return __libc_malloc(size);
}
}
#endif

namespace wayfare {
namespace {

template <class Estimator>
std::size_t allocations_of(Estimator& estimator, const MargRecording& samples) {
  const std::size_t before = allocations;
  for (const MargSample& s : samples) estimator.add(s);
  return allocations - before;
}

TEST(NoHeap, AttitudeAndWalkTakeNone) {
  if (!WAYFARE_OWN_MALLOC)
    GTEST_SKIP() << "the sanitizer of this build brings its own malloc, which cannot be counted";
  const std::size_t before = allocations;
  kept = std::make_unique<Eigen::VectorXd>(7);
  ASSERT_EQ(allocations, before + 2) << "both kinds are counted";

  testing::MotionOptions o;
  o.duration_s = 30.0;
  const auto motion = testing::simulate(o);
  Ahrs<frame::Ned> exact;
  Ahrs<frame::Enu, float> quick;
  PedestrianParameters p;
  p.field_drift.offset_sigma_uT = 50.0;
  Pedestrian pedestrian(p);
  EXPECT_EQ(allocations_of(exact, motion.samples), 0u);
  EXPECT_EQ(allocations_of(quick, motion.samples), 0u);
  EXPECT_EQ(allocations_of(pedestrian, motion.samples), 0u);
}

}  // namespace
}  // namespace wayfare
