#include <wayfare/sync/in_order.hpp>

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/sensors/measurements.hpp>

namespace wayfare {
namespace {

std::vector<ImuSample> at(const std::vector<double>& times_s) {
  std::vector<ImuSample> samples;
  for (const double t : times_s) {
    ImuSample sample;
    sample.time = LogTime::from_seconds(t);
    sample.angular_rate_radps.x() = static_cast<double>(samples.size());  // its index in the file
    samples.push_back(sample);
  }
  return samples;
}

std::vector<int> order(const std::vector<ImuSample>& samples) {
  std::vector<int> places;
  for (const ImuSample& s : samples) places.push_back(static_cast<int>(s.angular_rate_radps.x()));
  return places;
}

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(InOrder, KeepsSortedMeasurements) {
  auto samples = at({1.0, 1.01, 1.02, 500.0, 500.01});  // a gap is not an error
  const SortReport report = sort_by_time(samples);
  EXPECT_THAT(order(samples), ElementsAre(0, 1, 2, 3, 4));
  EXPECT_EQ(report.out_of_order + report.duplicates + report.outliers, 0U);
}

TEST(InOrder, OutOfOrderAndDuplicates) {
  auto samples = at({1.0, 1.02, 1.01, 1.03, 1.03, 1.04});
  const SortReport report = sort_by_time(samples);
  EXPECT_THAT(order(samples), ElementsAre(0, 2, 1, 3, 5));
  EXPECT_EQ(report.out_of_order, 1U);
  EXPECT_EQ(report.duplicates, 1U);
}

TEST(InOrder, OutlierStampsAreDropped) {
  auto samples = at({9e5, 1.0, 1.01, 7e8, 1.02, -4e6, 1.03, 1.04, 34.6e6});
  const SortReport report = sort_by_time(samples);
  EXPECT_THAT(order(samples), ElementsAre(1, 2, 4, 6, 7));
  EXPECT_EQ(report.outliers, 4U);
}

TEST(InOrder, TooFewToJudge) {
  auto none = at({}), two = at({5e6, 1.0});
  sort_by_time(none);
  sort_by_time(two);
  EXPECT_THAT(order(none), IsEmpty());
  EXPECT_THAT(order(two), ElementsAre(1, 0));
}

}  // namespace
}  // namespace wayfare
