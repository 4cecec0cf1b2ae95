// RTKLIB's time tags and the fit between two clocks.

#include <bit>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <wayfare/io/nav_text.hpp>
#include "little.hpp"
#include "support.hpp"

namespace wayfare::io {
namespace {

using ::wayfare::testing::little;

std::string tags(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& records) {
  std::string out = "TIMETAG RTKLIB demo5";
  out.resize(64, '\0');
  out += little(1752003261, 4) + little(std::bit_cast<std::uint64_t>(0.25), 8);
  for (const auto& [tick, bytes] : records) out += little(tick, 4) + little(bytes, 4);
  return out;
}

TEST(TimeTags, StartAndRecords) {
  const auto file =
      parse_time_tags(tags({{10, 100}, {26, 250}, {5, 260}, {30, 240}, {40, 300}}), "t");
  ASSERT_TRUE(file) << file.error().to_string();
  ASSERT_EQ(file->tags.size(), 3U);
  EXPECT_EQ(file->problems.count(), 2U);
  EXPECT_EQ(file->tags[0].time.nanoseconds(),
            (1752003261LL - 315964800) * 1'000'000'000 + 260'000'000);
  EXPECT_EQ(file->tags[2].bytes, 300U);
  EXPECT_FALSE(parse_time_tags("", "t"));
  EXPECT_FALSE(parse_time_tags("TIMETAG RTKLIB", "t"));
  EXPECT_FALSE(parse_time_tags(tags({}), "t"));
  EXPECT_TRUE(parse_time_tags(tags({{1, 1}}) + "123", "t"));  // a truncated record at the end
}

// A unit whose counter is slow by 200 ppm, its lines tagged on arrival in blocks every 16 ms.
TEST(TimeTags, ConvertACounterToGpsTime) {
  for (const bool carriage_returns : {false, true}) {
    std::string text;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> records;
    std::uint32_t bytes = 0;
    for (int i = 0; i < 5000; ++i) {
      const std::string line = "0.1,0.2,9.8,1,2,3," + std::to_string(200000 + 10 * i) + "\n";
      text += line;
      bytes += static_cast<std::uint32_t>(line.size()) + (carriage_returns ? 1 : 0);
      const double true_ms = 1000.0 + 10.0 * i * (1.0 + 200e-6);
      if (i % 3 == 2)
        records.emplace_back(static_cast<std::uint32_t>(true_ms / 16.0 + 1.0) * 16, bytes);
    }
    const ColumnFormat format{{"ax_g", "ay_g", "az_g", "gx_degps", "gy_degps", "gz_degps", "t_ms"}};
    const auto imu = parse_imu(text, "imu", format);
    ASSERT_TRUE(imu);
    const auto tag_file = parse_time_tags(tags(records), "t");
    ASSERT_TRUE(tag_file);
    const auto fit = fit_time_tags(*imu, *tag_file);
    ASSERT_TRUE(fit) << fit.error().to_string();
    EXPECT_NEAR(fit->rate, 1.0 + 200e-6, 20e-6);  // blocks and ticks beat: 1 ms over 50 s
    // Each sample waits for its block (10 ms on the mean) and the block for the tick (8 ms).
    const LogTime start =
        LogTime::from_nanoseconds((1752003261LL - 315964800) * 1'000'000'000 + 250'000'000);
    const double late_s = to_seconds((*fit)(imu->samples[0].time) - start) - 1.0;
    EXPECT_NEAR(late_s, 0.018, 0.002);
    EXPECT_LT(fit->residual_s, 0.012);
  }
}

TEST(ClockFit, LateStampsDoNotShiftTheFit) {
  std::mt19937 random(7);
  std::exponential_distribution<double> delay(1.0 / 0.05);
  std::vector<ClockPair<DeviceClock>> pairs;
  for (int i = 0; i < 2000; ++i) {
    const double t = i * 1.0;
    pairs.push_back({Time<DeviceClock>::from_seconds(1000.0 + t * (1.0 - 30e-6)),
                     LogTime::from_seconds(5e8 + t + delay(random))});
  }
  const auto fit = fit_clock<DeviceClock>(pairs, {.late = true});
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->rate, 1.0 + 30e-6, 3e-6);
  const double error = to_seconds((*fit)(pairs[1000].device) - LogTime::from_seconds(5e8 + 1000.0));
  EXPECT_GT(error, -0.001);
  EXPECT_LT(error, 0.025);  // half the mean delay; the plain fit is 0.05 late
}

TEST(ClockFit, RejectsASingleInstant) {
  std::vector<ClockPair<DeviceClock>> pairs(1);
  EXPECT_FALSE(fit_clock<DeviceClock>(pairs));
  pairs.resize(5);
  EXPECT_FALSE(fit_clock<DeviceClock>(pairs));  // one instant five times
  pairs[4] = {Time<DeviceClock>::from_seconds(2.0), LogTime::from_seconds(3.0)};
  EXPECT_TRUE(fit_clock<DeviceClock>(pairs));
}

TEST(TimeTags, RealUnit) {
  WAYFARE_NEEDS_RECORDING(csv, "gnss/drive_0708/imu_1934.csv.gz");
  WAYFARE_NEEDS_RECORDING(tag, "gnss/drive_0708/imu_1934.csv.tag.gz");
  const ColumnFormat format{{"ax_g", "ay_g", "az_g", "gx_degps", "gy_degps", "gz_degps", "t_ms"}};
  const auto imu = read_imu(csv, format);
  ASSERT_TRUE(imu);
  EXPECT_EQ(imu->samples.size(), 54860U);
  EXPECT_TRUE(imu->problems.empty());
  const auto tag_file = read_time_tags(tag);
  ASSERT_TRUE(tag_file);
  const auto fit = fit_time_tags(*imu, *tag_file);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->rate, 1.0, 30e-6);  // two quartz clocks
  EXPECT_LT(fit->residual_s, 0.006);   // blocks of 16 ms read evenly: 16 / √12 = 4.6 ms
  EXPECT_GT(fit->used, 54000U);
}

}  // namespace
}  // namespace wayfare::io
