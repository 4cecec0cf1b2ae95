#include <wayfare/io/text_file.hpp>

#include <cstdint>
#include <limits>
#include <random>
#include <utility>

#include <gtest/gtest.h>

namespace wayfare::io {
namespace {

TEST(TimeText, ParsesExactly) {
  const std::pair<const char*, std::int64_t> cases[] = {
      {"0", 0},
      {"976052857.137530", 976052857137530000},  // no double represents this to the nanosecond
      {"1.000000001", 1000000001},
      {"-2.5", -2500000000},
      {"+7.", 7000000000},
      {".5", 500000000},
      {"1.23379e+03", 1233790000000},
      {"5e-9", 5},
      {"0.0000000004", 0},
      {"0.0000000005", 1},
      {"0.00000000049999999999999", 0},
      {"0.99999999951", 1000000000},
      {"000001.5", 1500000000},
      {"9223372036.854775807", std::numeric_limits<std::int64_t>::max()},
      {"1e-300", 0},
  };
  for (const auto& [text, expected] : cases) EXPECT_EQ(parse_nanoseconds(text), expected) << text;
}

TEST(TimeText, RejectsInvalidTimes) {
  for (const char* text : {"", "-", ".", "1.2.3", "nan", "inf", "1e", "1e+", "0x10", "12 ", " 12",
                           "host", "9223372036.854775808", "1e30", "1e99999999999", "--1"}) {
    EXPECT_FALSE(parse_nanoseconds(text)) << text;
  }
  EXPECT_FALSE(parse_nanoseconds(std::string(100000, '1')));
}

TEST(TimeText, RoundTrip) {
  EXPECT_EQ(format_nanoseconds(976052857137530000), "976052857.137530000");
  EXPECT_EQ(format_nanoseconds(-1), "-0.000000001");
  EXPECT_EQ(format_nanoseconds(std::numeric_limits<std::int64_t>::min()), "-9223372036.854775808");
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const auto ns = static_cast<std::int64_t>(random() >> (i % 64)) * (i % 2 == 0 ? 1 : -1);
    if (ns == std::numeric_limits<std::int64_t>::min()) continue;
    EXPECT_EQ(parse_nanoseconds(format_nanoseconds(ns)), ns);
  }
}

}  // namespace
}  // namespace wayfare::io
