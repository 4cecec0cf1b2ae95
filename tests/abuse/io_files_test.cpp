// Files that are none, sizes that headers claim, recordings put together of parts that do not fit,
// and pictures and reports of any numbers.

#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/io/bag.hpp>
#include <wayfare/io/carmen.hpp>
#include <wayfare/io/g2o.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/mcap.hpp>
#include <wayfare/io/nav_recording.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/rinex.hpp>
#include <wayfare/io/tum.hpp>

#include "abuse/abuse.hpp"
#include "io/support.hpp"

namespace wayfare::io {
namespace {

using tests::kInf;
using tests::kNan;
using ::wayfare::testing::TemporaryFolder;

template <class T>
void expect_io_error(const Result<T>& result, const std::string& path) {
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().source, path);
  EXPECT_FALSE(result.error().message.empty());
}

TEST(Files, NoneAndFolders) {
  const TemporaryFolder folder;
  for (const std::string& path : {folder / "none", folder.path().string(), folder / "none/none"}) {
    expect_io_error(read_file(path), path);
    expect_io_error(read_carmen(path), path);
    expect_io_error(read_tum(path), path);
    expect_io_error(read_relations(path), path);
    expect_io_error(read_points(path), path);
    expect_io_error(read_g2o(path), path);
    expect_io_error(read_imu(path), path);
    expect_io_error(read_ranges(path), path);
    expect_io_error(read_fixes(path), path);
    expect_io_error(read_nav(path), path);
    expect_io_error(read_clock(path), path);
    expect_io_error(read_time_tags(path), path);
    expect_io_error(read_float_table(path), path);
    expect_io_error(read_rinex_observations(path), path);
    expect_io_error(read_rinex_navigation(path), path);
    expect_io_error(McapReader::open(path), path);
    expect_io_error(BagReader::open(path), path);
  }
  const std::string inside = folder / "none/none";
  expect_io_error(write_file(inside, "x"), inside);
  expect_io_error(FileSink::create(inside), inside);
  expect_io_error(McapWriter::create(inside), inside);
  const std::string here = folder.path().string();
  expect_io_error(write_file(here, "x", {Existing::replace}), here);
  expect_io_error(FileSink::create(here, {Existing::replace}), here);
}

// To open a pipe for reading would wait for a writer.
TEST(Files, APipeIsNoRecording) {
  const TemporaryFolder folder;
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  expect_io_error(McapReader::open(pipe), pipe);
  expect_io_error(BagReader::open(pipe), pipe);
}

TEST(Files, AreReadUpToTheirLimit) {
  const TemporaryFolder folder;
  const std::string path = folder / "file";
  ASSERT_TRUE(write_file(path, "12345"));
  EXPECT_TRUE(read_file(path, {5}));
  EXPECT_FALSE(read_file(path, {4}));
  EXPECT_FALSE(read_file(path, {0}));
  EXPECT_TRUE(read_file(path, {SIZE_MAX - 1}));
  EXPECT_TRUE(read_file(path, {SIZE_MAX}));
  EXPECT_FALSE(read_file("/dev/zero", {100'000}));
  EXPECT_TRUE(decompress("", "source", {0}));
}

TEST(Files, ProblemsAreCountedBeyondTheirCapacity) {
  Problems none(0);
  none.add({ErrorCode::parse, "x"});
  EXPECT_TRUE(none.first().empty() && none.count() == 1 && !none.empty());
  tests::expect_value_semantics(none, [](Problems& p) {
    p.add({ErrorCode::parse, "y"});
    return p.count();
  });
}

TEST(Files, ProblemsOfATemporaryAreRunOver) {
  const auto found = [] {
    Problems problems;
    problems.add({ErrorCode::parse, "first, too long to be kept in the string itself"});
    problems.add({ErrorCode::parse, "second"});
    return problems;
  };
  std::vector<std::string> said;
  for (const Error& error : found().first()) said.push_back(error.message);
  ASSERT_EQ(said.size(), 2U);
  EXPECT_EQ(said.front(), "first, too long to be kept in the string itself");
}

template <class T>
std::string raw(T value) {
  return std::string(reinterpret_cast<const char*>(&value), sizeof value);
}

TEST(ClaimedSizes, FloatTables) {
  for (const std::int32_t columns : {INT32_MIN, -1, 0, 1, 65536, 65537, INT32_MAX})
    for (const std::int64_t rows : {INT64_MIN, std::int64_t{-1}, std::int64_t{0}, std::int64_t{1},
                                    std::int64_t{1} << 40, INT64_MAX}) {
      const std::string bytes = "F32 " + raw(columns) + raw(rows) + raw(1.0F) + raw(kInf);
      const auto table = parse_float_table(bytes, "source");
      if (!table) continue;
      EXPECT_LE(table->values.size(), 3U);
      EXPECT_FALSE(table->problems.empty());
    }
  MargFormat format;
  format.columns.columns = {"gx_radps", "gy_radps", "gz_radps", "ax_g", "ay_g", "az_g"};
  const std::string table = format_float_table(std::vector<float>(18, 1.0F), 6);
  for (const double period : {kNan, kInf, -kInf, -1.0}) {
    format.period_s = period;
    EXPECT_FALSE(parse_marg(table, "source", format)) << period;
  }
  for (const double period : {1e-300, 1e300, 1e9, 0.01}) {
    format.period_s = period;
    const auto file = parse_marg(table, "source", format);
    EXPECT_TRUE(file && file->samples.size() + file->problems.count() == 3U) << period;
  }
}

TEST(ClaimedSizes, Maps) {
  for (const char* head : {"P5 1048576 1048576 255\n", "P2 1000000000 1 255\n", "P5 1048576 1 255 ",
                           "P5 18446744073709551615 2 255\n", "P5 0 5 255\n", "P5 2 2 65535\n"}) {
    EXPECT_FALSE(parse_pgm(head, "source")) << head;
    EXPECT_FALSE(parse_pgm(std::string(head) + "1234", "source")) << head;
  }
  for (const std::size_t side : {std::size_t{0}, std::size_t{1} << 20, std::size_t{1} << 32,
                                 std::size_t{1} << 63, SIZE_MAX}) {
    EXPECT_FALSE(encode_png({side, side, 1, {1, 2, 3}}));
    EXPECT_FALSE(encode_png({side, 2, 3, {}}));
    const GridImage grid{side, side, 0.05, SE2d(), {0.5F}};
    EXPECT_FALSE(format_pgm(grid));
    EXPECT_TRUE(to_picture(grid).pixels.empty());
    MapPainter painter(grid);
    painter.dot({0.0, 0.0}, kRed).path(std::vector<Eigen::Vector2d>{{0, 0}, {1, 1}}, kBlue);
    EXPECT_TRUE(painter.picture().pixels.empty());
  }
}

TEST(ClaimedSizes, LogsOfLines) {
  for (const char* line : {"FLASER 18446744073709551615 1 2 3", "FLASER 1000000000 1",
                           "RADAR 18446744073709551615 1 2", "RADAR 4294967296",
                           "ROBOTLASER1 0 -1 3 1 80 0 0 4000000000 1",
                           "ROBOTLASER1 0 -1 3 1 80 0 0 1 1 18446744073709551615 1"})
    EXPECT_FALSE(parse_carmen(line, "source", {.needs_laser = false})) << line;
}

// A map with one cell far away, as after a pose that diverged.
TEST(Maps, OfAnyExtentArePictures) {
  OccupancyGrid map;
  for (int i = 0; i < 200; ++i) map.update({i, 2 * i}, LogOdds::from_probability(0.9));
  const GridImage small = grid_image(map);
  EXPECT_EQ(small.width, 200U);
  for (const Cell far : {Cell{kMaxCell, 5}, Cell{-kMaxCell, kMaxCell}}) {
    map.update(far, LogOdds::from_probability(0.9));
    const GridImage image = grid_image(map);
    ASSERT_EQ(image.occupancy.size(), image.width * image.height);
    ASSERT_LT(image.occupancy.size(), std::size_t{1} << 25);
    const auto occupied = [](const GridImage& grid) {
      return std::count_if(grid.occupancy.begin(), grid.occupancy.end(),
                           [](float p) { return p > 0.5F; });
    };
    EXPECT_EQ(occupied(image), 200);
  }
}

// What is outside of the picture is not drawn and takes no time, however long a line is.
TEST(Maps, PathsOfAnyNumbers) {
  const GridImage grid{40, 30, 0.05, SE2d(-1.0, -0.5, Angle::degrees(10.0)),
                       std::vector<float>(1200, 0.5F)};
  const auto painted = [&](const std::vector<Eigen::Vector2d>& path) {
    return MapPainter(grid).path(path, kRed).picture().pixels;
  };
  const auto empty = painted({});
  for (const double far : {1e9, 1e13, 1e100, 1e300, 1.7e308, kInf, kNan}) {
    EXPECT_EQ(painted({{far, far}, {far, -far}}), empty);
    static_cast<void>(painted({{-far, -far}, {far, far}, {0.0, 0.0}, {0.0, far}}));
  }
  // The part within the picture is that of a path which ends at its border.
  const auto through = painted({{-1e6, 0.0}, {1e6, 0.0}});
  EXPECT_NE(through, empty);
  EXPECT_EQ(painted({{-5e5, 0.0}, {5e5, 0.0}}), through);
  for (const double x : {1e300, -1e300, kInf, kNan})
    EXPECT_EQ(MapPainter(grid).dot({x, 0.0}, kRed, 5).picture().pixels, empty);
  // A square as large as it may be covers all, of any smaller side its part.
  const auto covered = MapPainter(grid).dot({0.0, 0.0}, kRed, 1000).picture().pixels;
  EXPECT_EQ(MapPainter(grid).dot({0.0, 0.0}, kRed, INT32_MAX).picture().pixels, covered);
  EXPECT_EQ(MapPainter(grid).dot({0.0, 0.0}, kRed, 0).picture().pixels, empty);
  EXPECT_EQ(MapPainter(grid).dot({0.0, 0.0}, kRed, INT32_MIN).picture().pixels, empty);
  GridImage flat = grid;
  for (const double resolution : {0.0, kNan, kInf, 1e-300, 1e300}) {
    flat.resolution_m = resolution;
    MapPainter(flat).path(std::vector<Eigen::Vector2d>{{0, 0}, {1, 1}}, kRed).dot({1, 1}, kRed);
  }
}

const LogTime kStart = LogTime::from_seconds(1e9);

ImuFile imu_file(int samples) {
  ImuFile file;
  for (int i = 0; i < samples; ++i)
    file.samples.push_back({kStart + std::chrono::milliseconds(10 * i), Eigen::Vector3d::Zero(),
                            Eigen::Vector3d::Zero()});
  file.has_gyro = file.has_accelerometer = true;
  return file;
}

FixFile fix_file(int fixes) {
  FixFile file;
  for (int i = 0; i < fixes; ++i) {
    GnssFix fix;
    fix.time = kStart + std::chrono::milliseconds(100 * i);
    fix.velocity_ned_mps = Eigen::Vector3d(1.0, 2.0, 0.0);
    file.fixes.push_back(fix);
    file.qualities.push_back(0);
  }
  return file;
}

TEST(NavRecordings, OfPartsThatDoNotFit) {
  const TemporaryFolder folder;
  NavReading reading;
  int samples = 0, fixes = 5;
  reading.imu = [&](const std::string&, const ColumnFormat&) { return imu_file(samples); };
  reading.fixes = [&](const std::string&, const ColumnFormat&) { return fix_file(fixes); };
  NavFiles files;
  EXPECT_FALSE(read_nav_recording(files, {}, reading));
  files.imu = {"imu"}, files.fixes = "fixes";
  EXPECT_FALSE(read_nav_recording(files, {}, reading)) << "no sample";
  samples = 100;
  ASSERT_TRUE(read_nav_recording(files, {}, reading));
  fixes = 0;
  EXPECT_FALSE(read_nav_recording(files, {}, reading)) << "no fix";
  fixes = 5;
  for (const double late : {kNan, kInf, -kInf}) {
    NavFormats formats;
    formats.fixes.velocity_late_s = late;
    EXPECT_FALSE(read_nav_recording(files, formats, reading)) << late;
  }
  files.imu = {"imu", "imu"};
  EXPECT_FALSE(read_nav_recording(files, {}, reading)) << "the same part twice";
  files.imu = {"a", "b", "c"};
  EXPECT_FALSE(read_nav_recording(files, {}, reading));
  // Time tags refer to places in a file of text, which other recordings do not have.
  std::string tags = "TIMETAG RTKLIB";
  tags.resize(76, '\0');
  for (std::uint32_t i = 1; i < 9; ++i) tags += raw(i) + raw(10 * i);
  ASSERT_TRUE(write_file(folder / "tags", tags));
  files.imu = {"imu"}, files.imu_tags = folder / "tags";
  EXPECT_FALSE(read_nav_recording(files, {}, reading));
  EXPECT_FALSE(fit_time_tags(ImuFile{}, TimeTagFile{}));
}

TEST(NavRecordings, PartsOfAUnitOfAnyOrder) {
  const std::vector<ImuSample> samples = imu_file(5).samples, none;
  EXPECT_TRUE(merge_imu_parts(none, samples).empty());
  EXPECT_TRUE(merge_imu_parts(samples, none).empty());
  EXPECT_EQ(merge_imu_parts(samples, samples).size(), 5U);
  EXPECT_EQ(merge_imu_parts(samples, samples, Duration(-1)).size(), 5U);
  const std::vector<ImuSample> same(4, samples[0]);
  EXPECT_EQ(merge_imu_parts(same, same).size(), 4U);
  const std::vector<ImuSample> reversed(samples.rbegin(), samples.rend());
  EXPECT_LE(merge_imu_parts(reversed, samples).size(), 5U);
  EXPECT_LE(merge_imu_parts(samples, reversed).size(), 5U);
}

TEST(Logs, OfARecordingThatIsNotInOrder) {
  Recording r;
  for (const double t : {5.0, 1.0, 3.0, 3.0, -1e9}) {
    const SE2d pose(t, 0.0, Angle());
    r.odometry.push_back({LogTime::from_seconds(t), Transform2<frame::Odom, frame::Base>(pose)});
    r.scans.push_back({LogTime::from_seconds(2.0 * t),
                       Angle(),
                       Angle::degrees(1.0),
                       0.1F,
                       30.0F,
                       {1.0F, std::nanf(""), -1.0F, std::numeric_limits<float>::infinity()}});
    r.radar.push_back({LogTime::from_seconds(t), {}});
  }
  // Between two samples of odometry, wherever they are.
  r.truth.push_back({LogTime::from_seconds(2.0), {}});
  const std::string text = format_carmen(r);
  EXPECT_NE(text.find("\nTRUEPOS 0 0 0 2 0 0 "), text.npos);
  const auto log = parse_carmen(text, "source");
  ASSERT_TRUE(log);
  EXPECT_EQ(log->recording.scans.size(), 5U - 1U) << "one is the same as another";
  const auto empty = parse_carmen(format_carmen({}), "source", {.needs_laser = false});
  EXPECT_FALSE(empty);
}

}  // namespace
}  // namespace wayfare::io
