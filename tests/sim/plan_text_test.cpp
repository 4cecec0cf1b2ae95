#include <wayfare/sim/floor_plan.hpp>

#include <ostream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace wayfare::sim {
namespace {

using ::testing::HasSubstr;

TEST(ReadPlan, PictureWithPlacesAndRoute) {
  const auto read = read_plan(
      "# a room\n"
      "metres_per_character 0.5\n"
      "route a b a\n"
      "picture\n"
      "######\n"
      "#a   #\n"
      "#  .b#\n"
      "######\n");
  ASSERT_TRUE(read.has_value()) << read.error().to_string();
  // Columns and rows are half metres; the lower left corner of the picture is the origin.
  ASSERT_EQ(read->route_m.size(), 3U);
  EXPECT_EQ(read->route_m[0], Eigen::Vector2d(0.75, 1.25));
  EXPECT_EQ(read->route_m[1], Eigen::Vector2d(2.25, 0.75));
  EXPECT_EQ(read->plan.segments().size(), 8U);
  EXPECT_EQ(read->plan.cast({0.75, 1.25}, {1, 0}, 10.0), 1.75);
}

TEST(ReadPlan, WallsPlacesAndWindowsLineEnds) {
  const auto read = read_plan(
      "wall 0 0 4 0\r\nwall 4 0 0 3\r\n\r\nwall 0 3 0 0\r\n"
      "place door 1 1\r\nplace desk 1.5 0.5\r\nroute door desk\r\n");
  ASSERT_TRUE(read.has_value()) << read.error().to_string();
  EXPECT_EQ(read->plan.segments().size(), 3U);
  EXPECT_EQ(read->route_m[1], Eigen::Vector2d(1.5, 0.5));
}

struct BadPlan {
  const char* name;
  const char* text;
  std::size_t line;
  const char* message;
};

void PrintTo(const BadPlan& plan, std::ostream* out) { *out << plan.message; }

class ReadPlanBad : public ::testing::TestWithParam<BadPlan> {};

TEST_P(ReadPlanBad, NamesLineAndFault) {
  const auto read = read_plan(GetParam().text, "office.plan");
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().source, "office.plan");
  EXPECT_EQ(read.error().line, GetParam().line);
  EXPECT_THAT(read.error().message, HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    Texts, ReadPlanBad,
    ::testing::Values(
        BadPlan{"Empty", "", 0, "at least one wall"},
        BadPlan{"ThreeNumbers", "wall 1 2 3\n", 1, "wall X1 Y1 X2 Y2"},
        BadPlan{"NotANumber", "\nwall 1 2 3 x4\n", 2, "'x4' is not a number"},
        BadPlan{"NotFinite", "wall 1 2 3 nan\n", 1, "'nan' is not a number"},
        BadPlan{"NoLength", "wall 1 2 1 2\n", 1, "no length"},
        BadPlan{"UnknownWord", "wull 1 2 3 4\n", 1, "found 'wull'"},
        BadPlan{"PictureWithoutScale", "picture\n##\n", 1, "metres_per_character"},
        BadPlan{"ScaleOfZero", "metres_per_character 0\n", 1, "at least a millimetre"},
        BadPlan{"UnknownCharacter", "metres_per_character 1\npicture\n####\n# *#\n", 4, "column 3"},
        BadPlan{"Tab", "metres_per_character 1\npicture\n#\t#\n", 3, "this is a tab"},
        BadPlan{"BlankPicture", "metres_per_character 1\npicture\n\n  \n", 0, "at least one wall"},
        BadPlan{"PlaceTwice", "metres_per_character 1\npicture\n#a#\n#a#\n", 4,
                "already a place 'a'"},
        BadPlan{"UnknownPlace", "wall 0 0 1 0\nroute q\n", 2, "'q'"}),
    [](const auto& instance) { return std::string(instance.param.name); });

TEST(ReadPlan, SurvivesEveryTruncationOfAValidPlan) {
  const std::string_view text = demo_building();
  for (std::size_t length = 0; length < text.size(); length += 7) {
    const auto read = read_plan(text.substr(0, length));
    if (!read.has_value()) {
      EXPECT_FALSE(read.error().message.empty());
    }
  }
}

TEST(PlanFromPicture, DarkPixelsAreWalls) {
  const std::uint8_t pixels[] = {254, 254, 254, 254, 254, 0, 0, 254, 254, 205, 254, 254};
  const auto plan = plan_from_picture(pixels, 4, 3, 0.1);
  ASSERT_TRUE(plan.has_value());
  EXPECT_EQ(plan->segments().size(), 4U);
  EXPECT_TRUE(plan->lower_corner_m().isApprox(Eigen::Vector2d(0.1, 0.1)));
  EXPECT_FALSE(plan_from_picture(pixels, 5, 3, 0.1).has_value());
}

TEST(DemoBuilding, IsClosedAndOfItsStatedSize) {
  const auto read = read_plan(demo_building());
  ASSERT_TRUE(read.has_value()) << read.error().to_string();
  const Eigen::Vector2d size = read->plan.upper_corner_m() - read->plan.lower_corner_m();
  EXPECT_EQ(size, Eigen::Vector2d(60, 30));
  ASSERT_GT(read->route_m.size(), 10U);
  EXPECT_FALSE(find_leak(read->plan, read->route_m.front()).has_value());
}

}  // namespace
}  // namespace wayfare::sim
