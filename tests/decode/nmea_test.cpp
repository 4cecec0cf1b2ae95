#include <wayfare/decode/nmea.hpp>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/testing/decoder_laws.hpp>

namespace wayfare::decode {
namespace {

/// With start, checksum and line end.
std::string sentence(const std::string& content) {
  unsigned sum = 0;
  for (const char c : content) sum ^= static_cast<unsigned char>(c);
  constexpr char kDigits[] = "0123456789ABCDEF";
  return "$" + content + "*" + kDigits[sum >> 4] + kDigits[sum & 15U] + "\r\n";
}

template <class F>
DecoderStatistics each_sentence(const std::string& text, F&& f) {
  NmeaDecoder decoder;
  decoder.feed(Bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()), f);
  decoder.finish(f);
  return decoder.statistics();
}

TEST(Nmea, SatisfiesTheLawsOfDecoders) {
  Rng rng(1);
  std::string text;
  for (int i = 0; i < 60; ++i) {
    std::string content = "GNXYZ";
    for (auto k = 1 + rng.below(70); k > 0; --k) content += "0123456789,.-NSEW"[rng.below(17)];
    const std::string whole = sentence(content);
    text += whole.substr(0, whole.size() - 2);  // line ends are in no frame
  }
  const std::vector<std::uint8_t> stream(text.begin(), text.end());
  testing::DecoderLaws<NmeaDecoder> laws{stream, [](const NmeaSentence& s) {
                                           return std::string(s.bytes().begin(), s.bytes().end());
                                         }};
  laws.work_per_byte = 2.0;
  laws.check();
  const testing::DamageReport report = laws.damage(1000);
  EXPECT_EQ(report.lost, 0U);
}

// The example of the standard's section on GGA, with its checksum.
TEST(Nmea, PositionOfAKnownSentence) {
  int fixes = 0;
  each_sentence("$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n",
                [&](const NmeaSentence& s) {
                  EXPECT_EQ(s.talker(), "GP");
                  EXPECT_EQ(s.type(), "GGA");
                  const auto fix = nmea_gga(s);
                  ASSERT_TRUE(fix);
                  ++fixes;
                  EXPECT_DOUBLE_EQ(fix->time_of_day_s, 12 * 3600 + 35 * 60 + 19);
                  EXPECT_DOUBLE_EQ(fix->latitude_deg, 48.0 + 7.038 / 60.0);
                  EXPECT_DOUBLE_EQ(fix->longitude_deg, 11.0 + 31.0 / 60.0);
                  EXPECT_EQ(fix->quality, 1);
                  EXPECT_EQ(fix->satellites, 8);
                  EXPECT_DOUBLE_EQ(fix->hdop.value(), 0.9);
                  EXPECT_DOUBLE_EQ(fix->height_above_sea_m.value(), 545.4);
                  EXPECT_DOUBLE_EQ(fix->geoid_m.value(), 46.9);
                });
  EXPECT_EQ(fixes, 1);
}

TEST(Nmea, MotionOfAKnownSentence) {
  int motions = 0;
  each_sentence("$GPRMC,225446,A,4916.45,N,12311.12,W,000.5,054.7,191194,020.3,E*68\r\n",
                [&](const NmeaSentence& s) {
                  const auto motion = nmea_rmc(s);
                  ASSERT_TRUE(motion);
                  ++motions;
                  EXPECT_TRUE(motion->valid);
                  EXPECT_EQ(motion->year * 10000 + motion->month * 100 + motion->day, 19941119);
                  EXPECT_DOUBLE_EQ(motion->longitude_deg, -(123.0 + 11.12 / 60.0));
                  EXPECT_DOUBLE_EQ(motion->speed_mps.value(), 0.5 * 1852.0 / 3600.0);
                  EXPECT_DOUBLE_EQ(motion->course_deg.value(), 54.7);
                });
  EXPECT_EQ(motions, 1);
}

TEST(Nmea, FieldsThatDoNotFitAreRefused) {
  const char* contents[] = {
      "GPGGA,,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",        // no time
      "GPGGA,250000,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",  // hour 25
      "GPGGA,123519,9807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",  // 98 degrees north
      "GPGGA,123519,4867.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",  // 67 minutes
      "GPGGA,123519,4807.038,X,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
      "GPGGA,123519,nan,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,",
      "GPGGA,123519,4807.038,N,01131.000,E,x,08,0.9,545.4,M,46.9,M,,",
      "GPGGA",
      "GPRMC,225446,A,4916.45,N,12311.12,W,000.5,054.7,191394,020.3,E",  // month 13
      "GPRMC,225446,A,4916.45,N,12311.12,W,000.5,054.7,1911,020.3,E",
      "PUBX,00",
  };
  for (const char* content : contents) {
    const DecoderStatistics s = each_sentence(sentence(content), [&](const NmeaSentence& m) {
      EXPECT_FALSE(nmea_gga(m)) << content;
      EXPECT_FALSE(nmea_rmc(m)) << content;
    });
    EXPECT_EQ(s.frames, 1U) << content;
  }
}

/// What `read` makes of the only sentence with this content.
template <class Read>
auto read_one(const std::string& content, Read&& read) {
  decltype(read(NmeaSentence())) result;
  const auto s = each_sentence(sentence(content), [&](const NmeaSentence& m) { result = read(m); });
  EXPECT_EQ(s.frames, 1U) << content;
  return result;
}

TEST(Nmea, EveryFieldOfAMotion) {
  const auto rmc = [](const std::string& content) { return read_one(content, nmea_rmc); };
  const auto motion = rmc("GNRMC,010203.25,V,3351.60,S,15112.30,E,010.0,359.9,310179,,");
  ASSERT_TRUE(motion);
  EXPECT_DOUBLE_EQ(motion->time_of_day_s, 3723.25);  // 3600 + 2 · 60 + 3.25
  EXPECT_FALSE(motion->valid);
  EXPECT_DOUBLE_EQ(motion->latitude_deg, -(33.0 + 51.6 / 60.0));
  EXPECT_DOUBLE_EQ(motion->longitude_deg, 151.0 + 12.3 / 60.0);
  EXPECT_EQ(motion->year * 10000 + motion->month * 100 + motion->day, 20790131);  // the last year
  EXPECT_DOUBLE_EQ(motion->speed_mps.value(), 18520.0 / 3600.0);
  EXPECT_DOUBLE_EQ(motion->course_deg.value(), 359.9);
  const auto on = [&](const std::string& date) {
    return rmc("GNRMC,000000,A,0000.0,N,00000.0,E,,," + date + ",,");
  };
  const auto first = on("011280");
  ASSERT_TRUE(first);
  EXPECT_EQ(first->year * 10000 + first->month * 100 + first->day, 19801201);
  EXPECT_FALSE(first->speed_mps || first->course_deg);
  for (const char* date : {"000180", "320180", "010080", "011380", "01018", "0101800"})
    EXPECT_FALSE(on(date)) << date;
}

TEST(Nmea, TimesAnglesAndCountsToTheEndOfTheirRanges) {
  const auto gga = [](const std::string& time, const std::string& place,
                      const std::string& quality = "1") {
    return read_one("GNGGA," + time + "," + place + "," + quality + ",08,0.9,0,M,0,M,,", nmea_gga);
  };
  const auto west = gga("235960.5", "9000.0,N,18000.0,W");  // within a leap second
  ASSERT_TRUE(west);
  EXPECT_DOUBLE_EQ(west->time_of_day_s, 86400.5);
  EXPECT_DOUBLE_EQ(west->latitude_deg, 90.0);
  EXPECT_DOUBLE_EQ(west->longitude_deg, -180.0);
  const auto east = gga("000000", "9000.0,S,18000.0,E");
  ASSERT_TRUE(east);
  EXPECT_DOUBLE_EQ(east->time_of_day_s, 0.0);
  EXPECT_DOUBLE_EQ(east->latitude_deg, -90.0);
  EXPECT_DOUBLE_EQ(east->longitude_deg, 180.0);
  EXPECT_TRUE(gga("120000", "4859.99,N,00900.0,E", "1000000"));
  for (const char* time : {"235961", "126000", "240000", "-1"})
    EXPECT_FALSE(gga(time, "4800.0,N,00900.0,E")) << time;
  for (const char* place : {"9000.1,N,00900.0,E", "4860.0,N,00900.0,E", "-100.0,N,00900.0,E",
                            "4800.0,NN,00900.0,E", "4800.0,N,18000.1,E", "4800.0,E,00900.0,N"})
    EXPECT_FALSE(gga("120000", place)) << place;
  for (const char* quality : {"1000001", "-1", "1.5", ""})
    EXPECT_FALSE(gga("120000", "4800.0,N,00900.0,E", quality)) << quality;
}

// The exclusive or of AIVDM,1,1 is 57, of GNGLL,M 2F.
TEST(Nmea, AnotherStartAndDigitsOfEitherCase) {
  std::string seen;
  const auto s =
      each_sentence("!AIVDM,1,1*57\r\n$GNGLL,M*2f\r\n$GNGLL,M*2F", [&](const NmeaSentence& m) {
        seen += std::string(m.talker()) + "-" + std::string(m.type()) + " ";
      });
  EXPECT_EQ(seen, "AI-VDM GN-GLL GN-GLL ");
  EXPECT_EQ(s.skipped_bytes, 4U);  // the line ends
  read_one("PUBX,00,1", [](const NmeaSentence& m) {
    EXPECT_EQ(m.talker(), "P");
    EXPECT_EQ(m.type(), "UBX");
    EXPECT_EQ(m.field(1), "1");
    return 0;
  });
}

// From five characters, talker and type, to 1024 bytes with start, star and checksum.
TEST(Nmea, LengthsOfSentences) {
  for (const auto& [length, frames] :
       {std::pair<std::size_t, unsigned>{4, 0}, {5, 1}, {1020, 1}, {1021, 0}}) {
    const std::string content = "GNXYZ" + std::string(1100, '1');
    const auto s = each_sentence(sentence(content.substr(0, length)), [](const NmeaSentence&) {});
    EXPECT_EQ(s.frames, frames) << length;
    EXPECT_EQ(s.malformed, 1U - frames) << length;
  }
}

TEST(Nmea, MissingHeightAndSpeedAreNotNumbers) {
  const auto fix = read_one("GNGGA,000000.50,0000.0,S,00000.0,W,0,,,,,,,,", nmea_gga);
  ASSERT_TRUE(fix);
  EXPECT_EQ(fix->quality, 0);
  EXPECT_FALSE(fix->hdop || fix->height_above_sea_m || fix->geoid_m);
}

TEST(Nmea, OnlyWholeSentencesWithTheRightChecksumAreDelivered) {
  const std::string good = sentence("GNGLL,1,2");
  std::string flipped = good;
  flipped[8] = '3';
  const std::string text = flipped + "$GNGLL,1" + good + std::string(400, 'x') + "$" +
                           std::string(1100, 'y') + good + "$GNGLL,1,2*7";
  int sentences = 0;
  const DecoderStatistics s = each_sentence(text, [&](const NmeaSentence& m) {
    ++sentences;
    EXPECT_EQ(m.field(1), "2");
    EXPECT_EQ(m.field(2), "");
  });
  EXPECT_EQ(sentences, 2);
  EXPECT_EQ(s.checksum_failures, 1U);
  EXPECT_EQ(s.malformed, 2U);  // cut off by the next sentence, and longer than any sentence
}

}  // namespace
}  // namespace wayfare::decode
