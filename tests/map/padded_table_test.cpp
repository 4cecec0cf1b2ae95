#include <wayfare/map/detail/padded_table.hpp>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

struct Table : PaddedTable {
  using PaddedTable::reset;
};

TEST(PaddedTable, HasAReadableBorderOnEverySide) {
  Table table;
  const Cell corner{-7, 3};
  ASSERT_TRUE(table.reset(0.1, {corner, corner + Cell{4, 2}}, 9));
  EXPECT_EQ(table.width(), 5);
  EXPECT_EQ(table.height(), 3);
  EXPECT_EQ(table.origin(), corner);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 5; ++x)
      table.data()[y * table.stride() + x] = static_cast<std::uint16_t>(100 + 10 * y + x);
  constexpr int kBorder = PaddedTable::kBorder;
  for (int y = -kBorder; y < 3 + kBorder; ++y)
    for (int x = -kBorder; x < 5 + kBorder; ++x) {
      const bool inside = x >= 0 && x < 5 && y >= 0 && y < 3;
      const int want = inside ? 100 + 10 * y + x : 9;
      ASSERT_EQ(table.data()[y * table.stride() + x], want) << x << ' ' << y;
      ASSERT_EQ(table.value(corner + Cell{x, y}), want) << x << ' ' << y;
    }
  EXPECT_EQ(table.value({1'000'000, -1'000'000}), 9);
}

TEST(PaddedTable, ClearsItsCellsAndReportsInvalidSizes) {
  Table table;
  const CellBox box{{0, 0}, {9, 9}};
  ASSERT_TRUE(table.reset(0.1, box, 1));
  table.data()[0] = 5;
  ASSERT_TRUE(table.reset(0.1, box, 2));
  EXPECT_EQ(table.value({0, 0}), 2);
  EXPECT_FALSE(table.reset(0.0, box, 2));
  EXPECT_TRUE(table.empty());
  ASSERT_TRUE(table.reset(0.1, box, 2));
  EXPECT_FALSE(table.reset(0.1, {{0, 0}, {1'000'000, 1'000'000}}, 2));
  EXPECT_TRUE(table.empty());
}

}  // namespace
}  // namespace wayfare
