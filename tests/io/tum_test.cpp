#include <wayfare/io/tum.hpp>

#include <cmath>
#include <string>
#include <utility>

#include "support.hpp"

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;

TEST(Tum, PlanarGolden) {
  const Trajectory trajectory = {{LogTime::from_nanoseconds(976052857137530000),
                                  Transform2<frame::Map, frame::Base>(SE2d(1.5, -2.0, Angle()))}};
  EXPECT_EQ(format_tum(trajectory), "976052857.137530000 1.5 -2 0 0 0 0 1\n");
}

//! [tum]
TEST(Tum, PlanarRoundTrip) {
  Trajectory trajectory;
  for (int i = 0; i < 100; ++i) {
    trajectory.push_back({LogTime::from_nanoseconds(1234567890123456789 + i),
                          Transform2<frame::Map, frame::Base>(
                              SE2d(i / 3.0, -i / 7.0, Angle::radians(0.0628 * i - 3.14)))});
  }
  const testing::TemporaryFolder folder;
  ASSERT_TRUE(write_tum(folder / "t.tum", trajectory));
  const Result<TumFile> file = read_tum(folder / "t.tum");
  ASSERT_TRUE(file) << file.error().to_string();
  const Trajectory again = planar(file->trajectory);
  ASSERT_EQ(again.size(), trajectory.size());
  for (std::size_t i = 0; i < again.size(); ++i) {
    EXPECT_EQ(again[i].time, trajectory[i].time);
    EXPECT_EQ(again[i].T_map_base.raw().translation(),
              trajectory[i].T_map_base.raw().translation());
    EXPECT_NEAR(again[i].T_map_base.raw().heading().radians(),
                trajectory[i].T_map_base.raw().heading().radians(), 1e-15);
  }
  EXPECT_FALSE(write_tum(folder / "t.tum", trajectory));  // it exists
}
//! [tum]

TEST(Tum, SpatialRoundTrip) {
  const Trajectory3 trajectory = {
      {LogTime::from_nanoseconds(-5),
       Transform3<frame::Map, frame::Base>(SE3d({1.0 / 3, 2e-9, -3e9}, SO3d::exp({1, -2, 0.5})))}};
  const Result<TumFile> file = parse_tum("# t x y z\n" + format_tum(trajectory), "t");
  ASSERT_TRUE(file) << file.error().to_string();
  EXPECT_EQ(file->trajectory[0].time.nanoseconds(), -5);
  EXPECT_EQ(file->trajectory[0].T_map_base.raw().translation(),
            trajectory[0].T_map_base.raw().translation());
  EXPECT_TRUE(file->trajectory[0].T_map_base.raw().rotation().quaternion().isApprox(
      trajectory[0].T_map_base.raw().rotation().quaternion(), 1e-15));
}

TEST(Tum, MalformedLinesAreReportedAndSkipped) {
  const std::pair<std::string, const char*> cases[] = {
      {"1 2 3", "fewer than 8"},
      {"1 0 0 0 0 0 0 1 9", "more than 8"},
      {"x 0 0 0 0 0 0 1", "not a time stamp: 'x'"},
      {"1 0 nan 0 0 0 0 1", "not a finite number: 'nan'"},
      {"1 0 0 0 0 0 0 0", "unit length"},
      {"\x01\x02", "not a time stamp: '..'"},
  };
  for (const auto& [line, message] : cases) {
    const Result<TumFile> file =
        parse_tum("1 0 0 0 0 0 0 1\n" + line + "\n2 0 0 0 0 0 0 1", "t.tum");
    ASSERT_TRUE(file);
    EXPECT_EQ(file->trajectory.size(), 2U);
    ASSERT_EQ(file->problems.count(), 1U) << line;
    EXPECT_EQ(file->problems.first()[0].line, 2U);
    EXPECT_THAT(file->problems.first()[0].message, HasSubstr(message));
    const Result<TumFile> nothing = parse_tum(line, "t.tum");
    ASSERT_FALSE(nothing);
    EXPECT_EQ(nothing.error().line, 1U);
  }
  EXPECT_FALSE(parse_tum("", "t.tum"));
}

TEST(Relations, ReadsTheOfficialFormat) {
  const Result<RelationsFile> file = parse_relations(
      "976052905.167303 976052911.885496 -0.05 -0.125 0 0 0 -1.5\n"
      "976052905.167303 976052911.885496 -0.05 -0.125 0 0 0\n",
      "r");
  ASSERT_TRUE(file) << file.error().to_string();
  ASSERT_EQ(file->relations.size(), 1U);
  EXPECT_EQ(file->relations[0].first.nanoseconds(), 976052905167303000);
  EXPECT_EQ(file->relations[0].second.nanoseconds(), 976052911885496000);
  EXPECT_EQ(file->relations[0].T_first_second.y(), -0.125);
  EXPECT_NEAR(file->relations[0].T_first_second.heading().radians(), -1.5, 1e-15);
  EXPECT_EQ(file->problems.first()[0].to_string(), "r:2: fewer than 8 numbers");
}

TEST(Relations, RealFiles) {
  WAYFARE_NEEDS_RECORDING(intel, "slam2d/intel.relations.gz");
  WAYFARE_NEEDS_RECORDING(fr079, "slam2d/fr079.relations.gz");
  EXPECT_EQ(read_relations(intel)->relations.size(), 2984U);
  EXPECT_EQ(read_relations(fr079)->relations.size(), 1685U);
}

}  // namespace
}  // namespace wayfare::io
