#pragma once

// Counts a program's heap allocations. Include it in only one source file of a test.

#include <cstddef>
#include <cstdlib>
#include <memory>

#include <gtest/gtest.h>
#include <Eigen/Core>

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define WAYFARE_OWN_MALLOC 0
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(__GLIBC__)
#define WAYFARE_OWN_MALLOC 0
#endif
#ifndef WAYFARE_OWN_MALLOC
#define WAYFARE_OWN_MALLOC 1
#endif

namespace wayfare::tests {
inline std::size_t allocations = 0;
inline std::unique_ptr<Eigen::VectorXd> taken_vector;  // not optimised away
}  // namespace wayfare::tests

#if WAYFARE_OWN_MALLOC
// The functions through which Eigen and operator new allocate.
// NOLINTBEGIN(bugprone-reserved-identifier,misc-definitions-in-headers): of the C library, replaced
// once
extern "C" {
void* __libc_malloc(std::size_t size);
void* malloc(std::size_t size) noexcept {
  ++wayfare::tests::allocations;
  return __libc_malloc(size);
}
}
// NOLINTEND(bugprone-reserved-identifier,misc-definitions-in-headers)
#endif

namespace wayfare::tests {

/// Whether allocations can be counted in this build: checked with one by `new` and one by Eigen.
inline bool heap_is_counted() {
  const std::size_t before = allocations;
  taken_vector = std::make_unique<Eigen::VectorXd>(7);
  if (WAYFARE_OWN_MALLOC) {
    EXPECT_EQ(allocations, before + 2) << "both kinds are counted";
  }
  return WAYFARE_OWN_MALLOC;
}

}  // namespace wayfare::tests

/// Skips the test where a sanitizer replaces malloc.
#define WAYFARE_NEEDS_COUNTED_HEAP()        \
  if (!::wayfare::tests::heap_is_counted()) \
  GTEST_SKIP() << "this build's sanitizer replaces malloc, whose calls cannot be counted"
