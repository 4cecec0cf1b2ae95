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
    EXPECT_EQ(s.frames + s.malformed, 1U) << content;
  }
}

TEST(Nmea, MissingHeightAndSpeedAreNotNumbers) {
  each_sentence(sentence("GNGGA,000000.50,0000.0,S,00000.0,W,0,,,,,,,,"),
                [](const NmeaSentence& s) {
                  const auto fix = nmea_gga(s);
                  ASSERT_TRUE(fix);
                  EXPECT_EQ(fix->quality, 0);
                  EXPECT_FALSE(fix->hdop || fix->height_above_sea_m || fix->geoid_m);
                });
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
