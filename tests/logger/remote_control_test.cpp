#include <wayfare/logger/logger.hpp>

#include <string>

#include "io/support.hpp"

namespace wayfare::logger {
namespace {

TEST(RemoteControl, AcceptsFourBytesOnly) {
  int known = 0;
  for (int b = 0; b < 256; ++b)
    if (const auto command = command_of(static_cast<std::uint8_t>(b))) {
      ++known;
      EXPECT_EQ(static_cast<char>(*command), static_cast<char>(b));
    }
  EXPECT_EQ(known, 4);
  EXPECT_EQ(command_of('B'), Command::begin);
  EXPECT_EQ(command_of('S'), Command::stop);
  EXPECT_EQ(command_of('T'), Command::terminate);
  EXPECT_EQ(command_of('C'), Command::check);
}

TEST(RemoteControl, AStatusLineHasTheStandardChecksum) {
  // CRC-32 of "123456789" is cbf43926 (its published check value).
  EXPECT_EQ(status_line("123456789"), "123456789*cbf43926\n");
  EXPECT_EQ(status_of_line("123456789*cbf43926\r\n"), "123456789");
}

TEST(RemoteControl, ADamagedLineIsRejected) {
  const std::string line = status_line(R"({"state":"idle","note":"a*b"})");
  ASSERT_TRUE(status_of_line(line));
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    std::string damaged = line;
    damaged[i] = static_cast<char>(damaged[i] ^ 4);
    EXPECT_FALSE(status_of_line(damaged)) << i;
    EXPECT_FALSE(status_of_line(line.substr(0, i))) << i;
  }
  EXPECT_FALSE(status_of_line(""));
}

}  // namespace
}  // namespace wayfare::logger
