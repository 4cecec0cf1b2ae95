#include <wayfare/io/text_file.hpp>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "support.hpp"

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;

TEST(FloatTable, GoldenBytes) {
  const std::vector<float> values = {1.0F, -2.0F};
  const std::string expected("F32 \x02\0\0\0\x01\0\0\0\0\0\0\0\0\0\x80\x3f\0\0\0\xc0", 24);
  EXPECT_EQ(format_float_table(values, 2), expected);
}

TEST(FloatTable, RoundTripWithNaN) {
  std::vector<float> values = {1.5F, std::numeric_limits<float>::quiet_NaN(), -3e38F, 0.0F, 1e-40F,
                               7.0F};
  const Result<FloatTable> table = parse_float_table(format_float_table(values, 3), "t");
  ASSERT_TRUE(table) << table.error().to_string();
  ASSERT_EQ(table->columns, 3U);
  ASSERT_EQ(table->rows(), 2U);
  EXPECT_TRUE(table->problems.empty());
  EXPECT_TRUE(std::isnan(table->row(0)[1]));
  EXPECT_EQ(table->row(0)[2], -3e38F);
  EXPECT_EQ(table->row(1)[1], 1e-40F);
  EXPECT_EQ(table->row(1)[2], 7.0F);
}

TEST(FloatTable, ATruncatedTableKeepsItsWholeRows) {
  const std::vector<float> values = {1, 2, 3, 4, 5, 6};
  const std::string bytes = format_float_table(values, 2);
  const Result<FloatTable> table = parse_float_table(bytes.substr(0, bytes.size() - 3), "t");
  ASSERT_TRUE(table);
  EXPECT_EQ(table->rows(), 2U);
  ASSERT_EQ(table->problems.count(), 1U);
  EXPECT_EQ(table->problems.first()[0].byte, bytes.size() - 3);
}

TEST(FloatTable, RejectsInvalidTables) {
  const std::vector<float> values = {1, 2};
  const std::string good = format_float_table(values, 2);
  const auto message = [](const std::string& bytes) {
    const Result<FloatTable> table = parse_float_table(bytes, "t");
    return table ? std::string("taken") : table.error().message;
  };
  EXPECT_THAT(message(""), HasSubstr("F32"));
  EXPECT_THAT(message("text, not a table"), HasSubstr("F32"));
  EXPECT_THAT(message(good.substr(0, 9)), HasSubstr("header"));
  EXPECT_THAT(message(good + "x"), HasSubstr("after its last row"));
  EXPECT_THAT(message(good + "more"), HasSubstr("after its last row"));
  EXPECT_THAT(message(good.substr(0, 20)), HasSubstr("no rows"));
  std::string columns = good, rows = good;
  columns[4] = '\0', columns[7] = '\x80';
  EXPECT_THAT(message(columns), HasSubstr("columns"));
  columns[7] = '\x7f';  // a row would overflow
  EXPECT_THAT(message(columns), HasSubstr("columns"));
  rows[15] = '\x80';
  EXPECT_THAT(message(rows), HasSubstr("negative"));
  rows[15] = '\x7f';  // more rows than bytes: the available ones
  EXPECT_EQ(message(rows), "taken");
}

TEST(FloatTable, RealRecording) {
  WAYFARE_NEEDS_RECORDING(path, "ahrs/broad10_half/21_undisturbed_fast_combined.f32.gz");
  const Result<FloatTable> table = read_float_table(path);
  ASSERT_TRUE(table) << table.error().to_string();
  EXPECT_EQ(table->columns, 14U);
  EXPECT_EQ(table->rows(), 26806U);
  EXPECT_TRUE(table->problems.empty());
}

}  // namespace
}  // namespace wayfare::io
