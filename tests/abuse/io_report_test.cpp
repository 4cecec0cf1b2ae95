// Reports of any text and any numbers: valid characters, finite coordinates, one file.

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/io/report.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::io {
namespace {

using tests::kInf;
using tests::kNan;

/// Whether every sequence is the shortest one of a character that may be exchanged.
bool is_utf8(const std::string& s) {
  for (std::size_t i = 0; i < s.size();) {
    const auto byte = [&](std::size_t k) {
      return k < s.size() ? static_cast<unsigned char>(s[k]) : 0U;
    };
    const unsigned first = byte(i);
    const std::size_t n = first < 0x80 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
    std::uint32_t code = n == 1 ? first : first & (0x7fU >> n);
    if (first >= 0x80 && first < 0xc0) return false;
    for (std::size_t k = 1; k < n; ++k) {
      if ((byte(i + k) & 0xc0U) != 0x80U) return false;
      code = code << 6U | (byte(i + k) & 0x3fU);
    }
    constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
    if (code < kLeast[n] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return false;
    if (n == 1 && code < 0x20 && code != '\n' && code != '\t') return false;
    i += n;
  }
  return true;
}

TEST(Reports, TextOfAnyBytesIsValid) {
  for (const char* text :
       {"\xc0\xaf", "\xe0\x80\xaf", "\xf0\x80\x80\xaf", "\xed\xa0\x80", "\xed\xbf\xbf",
        "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff", "\xe2\x82", "\xc3"}) {
    EXPECT_TRUE(is_utf8(escape_html(text))) << ::testing::PrintToString(text);
    EXPECT_NE(escape_html(text).find("\xef\xbf\xbd"), std::string::npos);
  }
  for (const char* text : {"\xc2\x80", "\xe0\xa0\x80", "\xed\x9f\xbf", "\xee\x80\x80",
                           "\xf0\x90\x80\x80", "\xf4\x8f\xbf\xbf", "\xc3\xa4\xe2\x82\xac"})
    EXPECT_EQ(escape_html(text), text);
  Rng rng(1);
  for (int i = 0; i < 3000; ++i) {
    std::string text(rng.below(12), '\0');
    for (char& c : text)
      c = static_cast<char>(rng.below(2) == 0 ? rng.below(256) : 0x80 + rng.below(80));
    ASSERT_TRUE(is_utf8(escape_html(text))) << ::testing::PrintToString(text);
  }
}

const std::vector<double> kNumbers = {0.0,    1.0,    -1.0,    kNan, kInf,  -kInf, 1e300,
                                      -1e300, 1e-300, 5e-324,  1e99, -1e99, 1e100, 1.7e308,
                                      1e9,    1e-9,   -1e-320, 1e15, 1e7,   1e-5,  12.5};

TEST(Reports, PlotsOfAnyNumbersHaveFiniteCoordinates) {
  for (std::uint64_t seed = 0; seed < 1500; ++seed) {
    Rng rng(seed);
    Plot plot{"<title>", "x", "y", {}, rng.below(2) == 0};
    for (std::uint64_t s = rng.below(4); s > 0; --s) {
      Series series;
      series.mark = static_cast<Mark>(rng.below(3));
      for (std::uint64_t n = rng.below(6); n > 0; --n)
        series.add(kNumbers[rng.below(kNumbers.size())], kNumbers[rng.below(kNumbers.size())]);
      if (rng.below(10) == 0) series.y.resize(rng.below(8));
      plot.series.push_back(rng.below(4) == 0   ? bounds_series(series)
                            : rng.below(4) == 0 ? broken_at_wraps(series)
                                                : series);
    }
    const std::string svg = to_svg(plot);
    ASSERT_EQ(svg.find("nan"), std::string::npos) << "seed " << seed << '\n' << svg;
    ASSERT_EQ(svg.find("inf"), std::string::npos) << "seed " << seed << '\n' << svg;
    ASSERT_LT(svg.size(), 60'000U);
  }
}

TEST(Reports, ThousandsOfPointsInAnyOrder) {
  for (const bool grows : {true, false}) {
    Series series;
    Rng rng(2);
    for (int i = 0; i < 200'000; ++i)
      series.add(grows ? i : rng.uniform(), i % 1000 == 0 ? kNan : rng.uniform(-1e9, 1e9));
    Plot plot = time_plot("t", "y");
    plot.series = {series};
    EXPECT_LT(to_svg(plot).size(), 12'000'000U);
  }
}

TEST(Reports, AreValuesAndIndependent) {
  const auto make = [](int) {
    Report report("<&>", std::string("\0", 1));
    report.heading("").paragraph("\xff").facts({}).facts({{"", "nan"}}).plot({}).image({}, "none");
    report.image({2, 2, 1, {0, 1, 2, 3}}, "four").table(eval::Table(), "");
    return report.html();
  };
  EXPECT_TRUE(is_utf8(make(0)));
  const auto both = tests::in_two_threads(make);
  EXPECT_EQ(both[0], both[1]);
  Report report("title");
  report.paragraph("one");
  tests::expect_value_semantics(report, [](Report& r) { return r.paragraph("two").html(); });
}

}  // namespace
}  // namespace wayfare::io
