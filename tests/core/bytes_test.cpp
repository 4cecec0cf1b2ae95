#include <wayfare/core/detail/bytes.hpp>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string_view>

#include <gtest/gtest.h>

namespace wayfare::decode {
namespace {

constexpr std::uint8_t kBytes[] = {0xff, 0x01, 0x02, 0x03, 0x84, 0x05, 0x06, 0x07, 0x88};

TEST(Bytes, NumbersOfEitherOrder) {
  EXPECT_EQ(load_le<std::uint16_t>(kBytes + 1), 0x0201);
  EXPECT_EQ(load_be<std::uint16_t>(kBytes + 1), 0x0102);
  EXPECT_EQ(load_le<std::uint32_t>(kBytes + 1), 0x84030201U);
  EXPECT_EQ(load_be<std::uint32_t>(kBytes + 1), 0x01020384U);
  EXPECT_EQ(load_le<std::uint64_t>(kBytes + 1), 0x8807060584030201U);
  EXPECT_EQ(load_be<std::uint64_t>(kBytes + 1), 0x0102038405060788U);
  EXPECT_EQ(load_le<std::int8_t>(kBytes), -1);
  EXPECT_EQ(load_le<std::int32_t>(kBytes + 1), -0x7bfcfdff);  // 0x84030201 − 2³²
  constexpr std::uint8_t kOne[] = {0x3f, 0x80, 0, 0};         // 1 as IEEE 754 single
  EXPECT_EQ(load_be<float>(kOne), 1.0F);
  EXPECT_EQ(load_le<std::uint16_t>(std::string_view("abc"), 1), 'b' + 256 * 'c');
}

template <class T>
void expect_stored(T value) {
  std::uint8_t p[10];
  const auto untouched_about = [&] { return p[0] == 0x55 && p[1 + sizeof(T)] == 0x55; };
  std::fill(std::begin(p), std::end(p), std::uint8_t{0x55});
  store_le(value, p + 1);
  EXPECT_EQ(load_le<T>(p + 1), value);
  EXPECT_TRUE(untouched_about()) << value;
  store_be(value, p + 1);
  EXPECT_EQ(load_be<T>(p + 1), value);
  EXPECT_TRUE(untouched_about()) << value;
}

TEST(Bytes, StoresAreTheInverseOfLoads) {
  expect_stored(std::uint8_t{0xa7});
  expect_stored(std::int16_t{-2});
  expect_stored(std::uint32_t{0x12345678});
  expect_stored(std::uint64_t{0x1122334455667788});
  expect_stored(-3.5F);
  expect_stored(1e-300);
}

TEST(Bytes, BeforeTheFirstOfAValue) {
  EXPECT_EQ(bytes_before(Bytes(kBytes), 0xff), 0U);
  EXPECT_EQ(bytes_before(Bytes(kBytes), 0x84), 4U);
  EXPECT_EQ(bytes_before(Bytes(kBytes), 0x99), sizeof kBytes);
  EXPECT_EQ(bytes_before(Bytes(), 0), 0U);
}

}  // namespace
}  // namespace wayfare::decode
