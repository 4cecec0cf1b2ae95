#include <wayfare/core/detail/call_guard.hpp>

#include <new>
#include <utility>

#include <gtest/gtest.h>

namespace wayfare::detail {
namespace {

TEST(CallGuard, ErrorsAreNoInterruption) {
  CallGuard guard;
  const auto fails = [] { return Result<int>(Error{ErrorCode::invalid, "no"}); };
  EXPECT_EQ(guard.run(fails).error().message, "no");
  EXPECT_EQ(guard.run([] { return Result<int>(3); }).value(), 3);
}

TEST(CallGuard, AfterAnExceptionOnlyErrorsUntilReset) {
  CallGuard guard;
  EXPECT_THROW((void)guard.run([]() -> Result<int> { throw std::bad_alloc(); }), std::bad_alloc);
  int calls = 0;
  const auto count = [&]() -> Result<int> { return ++calls; };
  for (int i = 0; i < 2; ++i) EXPECT_EQ(guard.run(count).error().code, ErrorCode::cancelled);
  EXPECT_EQ(calls, 0);
  guard.reset();
  EXPECT_EQ(guard.run(count).value(), 1);
}

}  // namespace
}  // namespace wayfare::detail
