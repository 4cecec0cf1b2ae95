#pragma once

// What a law suite has to say about a type that breaks its laws.

#include <string>

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

namespace wayfare::testing {

/// The messages of all expectations that fail in `check`, which do not count as failures.
template <class Check>
[[nodiscard]] std::string faults_of(const Check& check) {
  ::testing::TestPartResultArray results;
  {
    const ::testing::ScopedFakeTestPartResultReporter reporter(
        ::testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &results);
    check();
  }
  std::string messages;
  for (int i = 0; i < results.size(); ++i) messages += results.GetTestPartResult(i).message();
  return messages;
}

}  // namespace wayfare::testing
