// Every reader of text with what text may be: empty, of one line, ended by anything or nothing,
// with a byte order mark, zeros, lines of megabytes, numbers that are none or out of any use, times
// of any order.

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "abuse/abuse.hpp"
#include "abuse/io_readers.hpp"

namespace wayfare::tests {
namespace {

class TextReaders : public ::testing::TestWithParam<TextReader> {
 protected:
  [[nodiscard]] static ReadText read(const std::string& text) { return GetParam().read(text); }
  [[nodiscard]] static const std::string& good() { return GetParam().good; }
  [[nodiscard]] static bool strict() { return GetParam().strict; }

  /// An error that says where, or problems that do; anything that was read is finite.
  static void expect_sane(const ReadText& file) {
    if (file.error) {
      EXPECT_FALSE(file.error->message.empty());
      EXPECT_EQ(file.error->source, "source");
      EXPECT_LT(file.error->message.size(), 1000U);
    }
    for (const Error& e : file.problems.first()) {
      EXPECT_TRUE(e.source == "source" && e.line > 0) << e.to_string();
      EXPECT_LT(e.message.size(), 1000U);
    }
    EXPECT_EQ(file.digest.find("inf"), std::string::npos) << file.digest.substr(0, 2000);
  }
  static void expect_same(const ReadText& a, const ReadText& b) {
    ASSERT_FALSE(a.error) << a.error->to_string();
    EXPECT_EQ(a.digest, b.digest);
    EXPECT_EQ(a.items, b.items);
    EXPECT_EQ(a.problems.count(), b.problems.count());
  }
};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size() - 1);
    lines.push_back(text.substr(at, end + 1 - at));
    at = end + 1;
  }
  return lines;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string all;
  for (const std::string& line : lines) all += line;
  return all;
}

std::string replaced(std::string text, std::string_view what, std::string_view by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != text.npos; at += by.size())
    text.replace(at, what.size(), by);
  return text;
}

TEST_P(TextReaders, NothingIsAnError) {
  using namespace std::string_literals;
  for (const std::string& text : {""s, "\n"s, "x"s, " \t\r\n \n"s, "\0"s, "\0\n\0\n"s, "#\n#\n"s,
                                  "\xef\xbb\xbf"s, "\xef\xbb\xbf\n"s, "\xef\xbb"s, "\r\r\r"s,
                                  std::string(1000, '\n'), std::string(1000, '\0')}) {
    SCOPED_TRACE(::testing::PrintToString(text));
    const ReadText file = read(text);
    // A navigation file may be without messages, but not without a header.
    ASSERT_TRUE(file.error);
    expect_sane(file);
  }
}

TEST_P(TextReaders, LineEndsAndByteOrderMarksDoNotMatter) {
  const ReadText expected = read(good());
  ASSERT_FALSE(expected.error) << expected.error->to_string();
  ASSERT_GT(expected.items, 0U);
  expect_sane(expected);
  expect_same(read(replaced(good(), "\n", "\r\n")), expected);
  expect_same(read("\xef\xbb\xbf" + good()), expected);
  expect_same(read(good().substr(0, good().size() - 1)), expected);
  expect_same(read(good() + "\r\n\n \n\t\n"), expected);
}

TEST_P(TextReaders, OneLineOfManyIsRead) {
  const auto lines = lines_of(good());
  for (std::size_t n = 0; n <= lines.size(); ++n)
    expect_sane(read(joined({lines.begin(), lines.begin() + static_cast<long>(n)})));
  for (const std::string& line : lines) expect_sane(read(line));
}

TEST_P(TextReaders, ABadLineCostsItself) {
  const ReadText expected = read(good());
  auto lines = lines_of(good());
  constexpr std::size_t kBytes = 10'000'000;
  const auto repeated = [&](std::string_view part) {
    std::string line;
    while (line.size() < kBytes) line += part;
    return line + "\n";
  };
  const std::string zeros = std::string(100, '\0') + "\n";
  for (const std::string& bad : {repeated("\x01"), repeated("1"), repeated("1 "), repeated("1,"),
                                 repeated("-"), repeated("\xff"), zeros}) {
    SCOPED_TRACE(::testing::PrintToString(bad.substr(0, 4)));
    auto with = lines;
    with.insert(with.end() - 1, bad);
    const ReadText file = read(joined(with));
    expect_sane(file);
    if (!GetParam().lines) continue;
    if (strict()) {
      // A line of an unknown kind is no fault where its first word is one.
      if (file.error) {
        EXPECT_EQ(file.error->line, lines.size());
      }
      continue;
    }
    ASSERT_FALSE(file.error) << file.error->to_string();
    EXPECT_EQ(file.items, expected.items);
    if (!file.problems.empty()) {
      EXPECT_EQ(file.problems.count(), 1U);
      EXPECT_EQ(file.problems.first()[0].line, lines.size());
    }
  }
  // A blank line of RINEX may be a satellite without values.
  if (!GetParam().lines) return;
  lines.insert(lines.end() - 1, repeated(" "));
  expect_same(read(joined(lines)), expected);
}

TEST_P(TextReaders, NumbersThatAreNoneOrOfNoUse) {
  const char* const kNumbers[] = {"nan",
                                  "inf",
                                  "-inf",
                                  "1e300",
                                  "-1e300",
                                  "1e-300",
                                  "1e999",
                                  "-1e999",
                                  "1e-999",
                                  "0x10",
                                  "1,5",
                                  "--1",
                                  "+",
                                  "-",
                                  ".",
                                  "e",
                                  "1e",
                                  "0",
                                  "-1",
                                  "1e9",
                                  "-1e9",
                                  "1e10",
                                  "9.3e9",
                                  "-9.3e9",
                                  "4.1e9",
                                  "-4.1e9",
                                  "1e18",
                                  "1e19",
                                  "4294967296",
                                  "18446744073709551616",
                                  "9223372036854775807",
                                  "-9223372036854775808"};
  const auto lines = lines_of(good());
  for (std::size_t l = 0; l < std::min<std::size_t>(lines.size(), 16); ++l) {
    const std::string& line = lines[l];
    for (std::size_t at = 0; at < line.size();) {
      const std::size_t begin = line.find_first_not_of(" ,()[]\n", at);
      if (begin == line.npos) break;
      const std::size_t end = std::min(line.find_first_of(" ,()[]\n", begin), line.size());
      at = end;
      for (const char* number : kNumbers) {
        auto with = lines;
        with[l] = line.substr(0, begin) + number + line.substr(end);
        const ReadText file = read(joined(with));
        SCOPED_TRACE(with[l]);
        expect_sane(file);
        if (HasFailure()) return;
      }
    }
  }
}

TEST_P(TextReaders, TimesOfAnyOrder) {
  if (!GetParam().lines) return;
  auto lines = lines_of(good());
  const ReadText expected = read(good());
  std::reverse(lines.begin() + 1, lines.end());
  expect_sane(read(joined(lines)));
  // Each line a second and a third time.
  lines = lines_of(good());
  const std::vector<std::string> once(lines.begin() + 1, lines.end());
  for (int k = 0; k < 2; ++k) lines.insert(lines.end(), once.begin(), once.end());
  const ReadText thrice = read(joined(lines));
  expect_sane(thrice);
  if (!strict()) {
    ASSERT_FALSE(thrice.error);
    EXPECT_GE(thrice.items, expected.items);
    EXPECT_LE(thrice.items, 3 * expected.items);
  }
}

TEST_P(TextReaders, TruncatedAnywhere) {
  for (std::size_t n = 0; n < good().size(); n += 1 + good().size() / 400)
    expect_sane(read(good().substr(0, n)));
}

TEST_P(TextReaders, TwoThreadsReadTheSame) {
  const auto both = in_two_threads([](int) {
    std::string digest;
    for (int i = 0; i < 5; ++i) digest += read(good()).digest;
    return digest;
  });
  EXPECT_EQ(both[0], both[1]);
}

INSTANTIATE_TEST_SUITE_P(All, TextReaders, ::testing::ValuesIn(text_readers()),
                         [](const auto& i) { return replaced(i.param.name, " ", "_"); });

// Too small a number is zero and too large a one is refused, however it is written.
TEST(TextNumbers, BeyondTheRangeOfTheirType) {
  const auto read = [](const std::string& number) {
    const auto file = io::parse_points(number + " 2 3\n", "source");
    return file ? std::optional(file->points_m[0].x()) : std::nullopt;
  };
  const std::string zeros(400, '0');
  const std::vector<std::string> small = {"1e-400", "0." + zeros + "1", "-1E-999",
                                          "1e-99999999999999999999", "0." + zeros + "1e-5"};
  for (const std::string& number : small) EXPECT_EQ(read(number), 0.0) << number;
  const std::vector<std::string> large = {"1e400", "1" + zeros, "1" + zeros + "e-5", "-1e+999",
                                          "1e99999999999999999999"};
  for (const std::string& number : large) EXPECT_FALSE(read(number)) << number;
}

// A long line is not cut: part of a number is another number.
TEST(TextNumbers, AreWholeInLongLines) {
  const auto file = io::parse_points("1 2" + std::string(195, ' ') + "123456\n", "source");
  ASSERT_TRUE(file);
  EXPECT_EQ(file->points_m[0].z(), 123456.0);
}

TEST(TextNumbers, EveryNanosecondIsATime) {
  for (const std::int64_t ns : {INT64_MIN, INT64_MIN + 1, INT64_MAX, std::int64_t{0}})
    EXPECT_EQ(io::parse_nanoseconds(io::format_nanoseconds(ns)), ns);
  EXPECT_FALSE(io::parse_nanoseconds("-9223372036.854775809"));
  EXPECT_FALSE(io::parse_nanoseconds("-9223372036.8547758085"));
  EXPECT_FALSE(io::parse_nanoseconds("9223372036.8547758075"));
  for (const char* text : {"1e1000", "1e1001", "1e2147483648", "1e99999999999"})
    EXPECT_FALSE(io::parse_nanoseconds(text)) << text;
  for (const char* text : {"1e-1000", "4e-10", "-4e-10"})
    EXPECT_EQ(io::parse_nanoseconds(text), 0) << text;
}

}  // namespace
}  // namespace wayfare::tests
