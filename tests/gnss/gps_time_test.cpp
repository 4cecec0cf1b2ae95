#include <wayfare/gnss/gps_time.hpp>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

using std::chrono::hours;
using std::chrono::seconds;

Time<UtcClock> utc(int year, int month, int day, int hour = 0, int minute = 0, int second = 0) {
  return *utc_from_civil({year, month, day, hour, minute, seconds(second)});
}
Time<GpsClock> gps(int year, int month, int day, int hour = 0, int minute = 0, int second = 0) {
  return *gps_from_civil({year, month, day, hour, minute, seconds(second)});
}

TEST(GpsTime, WeekAndTimeOfWeek) {
  // The recording's own header: 2023-01-08T10:00:00 is GPS week 2244, 36000 s.
  const WeekTime w = week_time(gps(2023, 1, 8, 10));
  EXPECT_EQ(w.week, 2244);
  EXPECT_EQ(w.of_week, seconds(36000));
  EXPECT_EQ(gps_time(2244, seconds(36000)), gps(2023, 1, 8, 10));
  const WeekTime before = week_time(Time<GpsClock>() - Duration(1));
  EXPECT_EQ(before.week, -1);
  EXPECT_EQ(before.of_week, kGpsWeek - Duration(1));
}

TEST(GpsTime, RollOvers) {
  const Time<GpsClock> spring_2019 = gps_time(2051, hours(12));
  EXPECT_EQ(unrolled_week(2051 % 1024, spring_2019), 2051);
  EXPECT_EQ(unrolled_week(2051, spring_2019), 2051);
  // Week 2047 is 1023 modulo 1024, week 2048 is 0: across the roll-over of April 2019.
  EXPECT_EQ(unrolled_week(1023, gps_time(2048, Duration(0))), 2047);
  EXPECT_EQ(unrolled_week(0, gps_time(2047, Duration(0))), 2048);
  EXPECT_EQ(unrolled_week(5, gps_time(4100, Duration(0)), 4096), 4101);
}

TEST(GpsTime, TimeOfWeekNearestToAnother) {
  // A message of Saturday 23:59 received on Sunday belongs to the previous week, and vice versa.
  EXPECT_EQ(nearest_time_of_week(kGpsWeek - seconds(60), gps_time(2051, seconds(30))),
            gps_time(2050, kGpsWeek - seconds(60)));
  EXPECT_EQ(nearest_time_of_week(seconds(60), gps_time(2050, kGpsWeek - seconds(30))),
            gps_time(2051, seconds(60)));
  EXPECT_EQ(nearest_time_of_week(hours(50), gps_time(2051, hours(49))), gps_time(2051, hours(50)));
}

TEST(GpsTime, LeapSeconds) {
  EXPECT_EQ(gps_minus_utc_s(utc(1980, 1, 6)), 0);
  EXPECT_EQ(gps_minus_utc_s(utc(1999, 1, 1)), 13);
  EXPECT_EQ(gps_minus_utc_s(utc(2016, 12, 31, 23, 59, 59)), 17);
  EXPECT_EQ(gps_minus_utc_s(utc(2017, 1, 1)), 18);
  EXPECT_EQ(gps_minus_utc_s(utc(2023, 1, 8)), 18);
  // Across 23:59:60 of 2016, whose UTC reading is that of 00:00:00.
  EXPECT_EQ(to_gps(utc(2016, 12, 31, 23, 59, 59)), gps(2017, 1, 1, 0, 0, 16));
  EXPECT_EQ(to_gps(utc(2017, 1, 1)), gps(2017, 1, 1, 0, 0, 18));
  EXPECT_EQ(to_utc(gps(2017, 1, 1, 0, 0, 16)), utc(2016, 12, 31, 23, 59, 59));
  EXPECT_EQ(to_utc(gps(2017, 1, 1, 0, 0, 17)), utc(2017, 1, 1));
  EXPECT_EQ(to_utc(gps(2017, 1, 1, 0, 0, 18)), utc(2017, 1, 1));
  EXPECT_EQ(to_utc(gps(2017, 1, 1, 0, 0, 19)), utc(2017, 1, 1, 0, 0, 1));
  // A user's table with a future leap second.
  const LeapSecond future[] = {{utc(2030, 1, 1), 19}};
  EXPECT_EQ(to_gps(utc(2030, 1, 1), future), gps(2030, 1, 1, 0, 0, 19));
}

TEST(GpsTime, LeapSecondRoundTrips) {
  for (const LeapSecond& leap : leap_second_table()) {
    for (int s = -3; s <= 3; ++s) {
      const Time<UtcClock> t = leap.from + seconds(s);
      EXPECT_EQ(to_utc(to_gps(t)), t) << leap.gps_minus_utc_s << ' ' << s;
    }
  }
}

TEST(GpsTime, OtherSystems) {
  // BDT 0 = 2006-01-01T00:00:00 UTC, when GPS was 14 s ahead of UTC.
  EXPECT_EQ(to_gps(Time<BeidouClock>()), to_gps(utc(2006, 1, 1)));
  EXPECT_EQ(to_beidou(gps(2006, 1, 1, 0, 0, 14)), Time<BeidouClock>());
  // GST 0 = 1999-08-21T23:59:47 UTC = 1999-08-22T00:00:00 GPS (Galileo OS SIS ICD 5.1.2).
  EXPECT_EQ(to_gps(Time<GalileoClock>()), gps(1999, 8, 22));
  EXPECT_EQ(to_gps(Time<GalileoClock>()), to_gps(utc(1999, 8, 21, 23, 59, 47)));
  EXPECT_EQ(to_galileo(to_gps(Time<GalileoClock>() + hours(5))), Time<GalileoClock>() + hours(5));
  EXPECT_EQ(to_glonass(utc(2020, 5, 1, 21)).since_epoch(), utc(2020, 5, 2).since_epoch());
  EXPECT_EQ(to_utc(to_glonass(utc(2020, 5, 1, 21))), utc(2020, 5, 1, 21));
}

TEST(GpsTime, Calendar) {
  EXPECT_FALSE(gps_from_civil({2019, 2, 29}));
  EXPECT_TRUE(gps_from_civil({2020, 2, 29}));
  EXPECT_FALSE(gps_from_civil({2019, 13, 1}));
  EXPECT_FALSE(gps_from_civil({2019, 1, 1, 24}));
  EXPECT_FALSE(gps_from_civil({2019, 1, 1, 0, 0, seconds(61)}));
  EXPECT_FALSE(gps_from_civil({1979, 12, 31}));
  const CivilTime c = civil_from_gps(gps(2019, 4, 28, 12, 44, 33) + Duration(997000000));
  EXPECT_EQ(c.year, 2019);
  EXPECT_EQ(c.month, 4);
  EXPECT_EQ(c.day, 28);
  EXPECT_EQ(c.hour, 12);
  EXPECT_EQ(c.minute, 44);
  EXPECT_EQ(c.of_minute, Duration(33997000000));
}

}  // namespace
}  // namespace wayfare
